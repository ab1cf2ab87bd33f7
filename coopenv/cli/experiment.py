"""``coopenv experiment``, ``report`` and ``sweep``: grids of runs that run themselves."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from coopenv.agents.settings import TrainConfig
from coopenv.cli.progress import bar_over, lines_over
from coopenv.errors import InvalidInput
from coopenv.options import POSITIONAL, Common

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.experiments import Experiment, Nodes, Outcome, Results, Search


@dataclass(frozen=True, kw_only=True)
class RunExperiment:
    """Run a grid of trainings from a file, several at a time, and write its report.

    The same command goes on after an interruption or a kill: finished cells are kept. A cell that
    fails is told and the others go on.
    """

    file: Annotated[Path, POSITIONAL]
    """.toml file of the experiment; see docs/experiments.md."""
    out: Path | None = None
    """Folder; the file's out, or runs/NAME-OF-THE-FILE."""
    workers: int | None = None
    """Cells at a time; one a core."""
    tune: int = 0
    """Trials of a search over the settings of each algorithm that learns, before the grid; the
    file's [search.space] says over which. Each trial is all of the algorithm's grid."""
    ray: bool = False
    """Spread the cells over the nodes of a Ray cluster, a core each; those of a lost node run
    again. Without address and RAY_ADDRESS, a Ray on this machine's cores."""
    address: str | None = None
    """Of the cluster, with ray: HOST:6379, ray://HOST:10001, or auto for that of this machine."""
    wandb: str | None = None
    """Project of Weights & Biases that the curves go to."""
    dry_run: bool = False
    """Check the file and say what it comes to; run and write nothing."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv experiment rewards.toml --dry-run",
        "coopenv experiment rewards.toml --workers 2",
        "coopenv experiment rewards.toml --tune 20 --out runs/tuned",
        "coopenv experiment rewards.toml --ray --address auto",
    )

    def run(self) -> dict[str, Any]:
        """Check, run, report."""
        from dataclasses import replace

        from rich.console import Console

        from coopenv.agents.experiments import load

        if self.address is not None and not self.ray:
            raise InvalidInput(
                f"address must come with ray, got {self.address!r} without it; add --ray"
            )
        experiment, search = load(self.file)
        if self.out is not None:
            experiment = replace(experiment, out=self.out)
        if self.wandb is not None:
            experiment = replace(experiment, wandb=self.wandb)
        return _conduct(experiment, search, self, Console())


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Train with one weight of one reward term after the other, and draw time against waste.

    Goes on after an interruption or a kill, as coopenv experiment does.
    """

    term: Annotated[str, POSITIONAL]
    """Term of the reward, or the name of one that is added to it: wasted_cost, internal_force."""
    values: Annotated[tuple[float, ...], POSITIONAL]
    """Its weights."""
    training: TrainConfig = field(default_factory=lambda: TrainConfig(out=Path("runs/sweep")))
    seeds: int = 5
    """Trainings of each weight; their numbers begin at seed."""
    episodes: int = 200
    """Held-out episodes of each evaluation."""
    workers: int | None = None
    """Cells at a time; one a core."""
    wandb: str | None = None
    """Project of Weights & Biases that the curves go to."""
    dry_run: bool = False
    """Say what it comes to; run and write nothing."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv sweep wasted_cost 0 0.1 0.3 1 --seeds 3",
        "coopenv sweep internal_force 0 0.01 --env coopenv/BeamDoorway-v0 --dry-run --json",
    )

    def run(self) -> dict[str, Any]:
        """Run, report."""
        from rich.console import Console

        from coopenv.agents.experiments import sweep

        experiment = sweep(
            self.term,
            self.values,
            self.training,
            seeds=self.seeds,
            episodes=self.episodes,
            wandb=self.wandb,
        )
        return _conduct(experiment, None, self, Console())


@dataclass(frozen=True, kw_only=True)
class Report:
    """Write the report of an experiment again, of what is finished of it."""

    folder: Annotated[Path, POSITIONAL]
    """Of the experiment or sweep."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv report runs/rewards",
        "coopenv report runs/sweep --json",
    )

    def run(self) -> dict[str, Any]:
        """Read what is there, write the report, print its first table."""
        from rich.console import Console

        from coopenv.agents.experiments import Results, write_report

        results = Results.load(self.folder)
        if not results.runs:
            raise InvalidInput(
                f"folder must hold a cell that is finished, got {str(self.folder)!r}, which has "
                f"none of {len(results.waiting)}; run coopenv experiment to its end"
            )
        files = write_report(results, self.folder)
        console = Console()
        _print_table(results, console)
        _print_files(self.folder, files, console)
        return _document(results, self.folder, files)


def _conduct(
    experiment: "Experiment",
    search: "Search | None",
    command: RunExperiment | Sweep,
    console: "Console",
) -> dict[str, Any]:
    from coopenv.agents.experiments import check, conduct
    from coopenv.agents.experiments.tracking import found

    tune = command.tune if isinstance(command, RunExperiment) else 0
    cells = check(experiment, search=search, tune=tune, workers=command.workers)
    if command.dry_run:
        plan = _plan(experiment, len(cells))
        _print_plan(plan, console)
        return plan
    if experiment.wandb is not None:
        found()  # told before the first cell
    progress = bar_over if console.is_terminal else lines_over
    try:
        with _nodes(command, console) as nodes, progress(console) as show:
            outcome = conduct(
                experiment,
                search=search,
                tune=tune,
                workers=command.workers,
                show=show,
                nodes=nodes,
            )
    except KeyboardInterrupt as stop:
        raise KeyboardInterrupt(
            "interrupted; finished cells are kept, and the same command goes on"
        ) from stop
    if outcome.files:
        _print_table(outcome.results, console)
        _print_files(experiment.out, outcome.files, console)
    _raise_failures(outcome, experiment.out)
    return _document(outcome.results, experiment.out, outcome.files)


@contextmanager
def _nodes(command: RunExperiment | Sweep, console: "Console") -> Iterator["Nodes | None"]:
    """Those of Ray where they are asked for, told of before the first cell."""
    from coopenv.agents.experiments import joined

    if isinstance(command, Sweep) or not command.ray:
        yield None
        return
    with joined(command.address) as nodes:
        console.print(str(nodes), highlight=False)
        yield nodes


def _raise_failures(outcome: "Outcome", out: Path) -> None:
    """Raise `InvalidInput` if cells failed, with the first reason."""
    if not outcome.failures:
        return
    folder, why = next(iter(outcome.failures.items()))
    raise InvalidInput(
        f"cells must come to their end, got {len(outcome.failures)} of {outcome.cells} that "
        f"failed; {out / folder}: {why}; failure.txt in each says all, and the same command tries "
        "them again"
    )


def _plan(experiment: "Experiment", cells: int) -> dict[str, Any]:
    """What an experiment comes to."""
    levels = experiment.levels().items()
    return {
        "axes": {axis: [level.label for level in each] for axis, each in levels},
        "seeds": experiment.seeds,
        "cells": cells,
        "steps": sum(cell.steps for cell in experiment.cells()),
        "episodes": experiment.episodes,
        "folder": experiment.out,
    }


def _print_plan(plan: dict[str, Any], console: "Console") -> None:
    for axis, labels in (*plan["axes"].items(), ("seeds", [*map(str, plan["seeds"])])):
        console.print(f"{axis} ({len(labels)}): {', '.join(labels)}", markup=False, highlight=False)
    console.print(
        f"{plan['cells']:,} cells, {plan['steps']:,} control steps of training, "
        f"{plan['episodes']} held-out episodes each, in {plan['folder']}; nothing was run",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )


def _document(results: "Results", folder: Path, files: list[str]) -> dict[str, Any]:
    """Interquartile means of each setting with their intervals, for programs."""
    from coopenv.agents.experiments.report import estimates_of

    runs = results.by_setting()
    settings = [
        {"setting": results.title(setting), "runs": len(runs[setting]), "measures": measures}
        for setting, measures in estimates_of(results).items()
    ]
    return {
        "name": results.name,
        "settings": settings,
        "waiting": results.waiting,
        "failed": results.failed,
        "folder": folder,
        "files": files,
    }


def _print_table(results: "Results", console: "Console") -> None:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    from coopenv.agents.experiments.report import summary

    head, rows = summary(results)
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for name in head:
        table.add_column(Text(name), overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    console.print(Text(f"{results.name}: interquartile mean [95 % interval]", "table.title"))
    console.print(table)


def _print_files(out: Path, files: list[str], console: "Console") -> None:
    console.print(f"in {out}: {', '.join(files)}", markup=False, highlight=False)
