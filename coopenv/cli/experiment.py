"""``coopenv experiment``, ``report`` and ``sweep``: grids of runs that run themselves."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from coopenv.agents.settings import TrainConfig
from coopenv.errors import InvalidInput

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.experiments import Experiment, Outcome, Results, Search


@dataclass(frozen=True, kw_only=True)
class RunExperiment:
    """Run a grid of trainings from a file, several at a time, and write its report.

    The same command goes on after an interruption or a kill: finished cells are kept. A cell that
    fails is told and the others go on.
    """

    file: Path
    """.toml file of the experiment; see docs/experiments.md."""
    out: Path | None = None
    """Folder; the file's out, or runs/NAME-OF-THE-FILE."""
    workers: int | None = None
    """Cells at a time; one a core."""
    tune: int = 0
    """Trials of a search over the settings of each algorithm that learns, before the grid; the
    file's [search.space] says over which. Each trial is all of the algorithm's grid."""
    wandb: str | None = None
    """Project of Weights & Biases that the curves go to."""
    dry_run: bool = False
    """Check the file and say what it comes to; run and write nothing."""

    def run(self) -> None:
        """Check, run, report."""
        from dataclasses import replace

        from rich.console import Console

        from coopenv.agents.experiments import load

        experiment, search = load(self.file)
        if self.out is not None:
            experiment = replace(experiment, out=self.out)
        if self.wandb is not None:
            experiment = replace(experiment, wandb=self.wandb)
        _conduct(experiment, search, self, Console())


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Train with one weight of one reward term after the other, and draw time against waste.

    Goes on after an interruption or a kill, as coopenv experiment does.
    """

    term: str
    """Term of the reward, or the name of one that is added to it: wasted_cost, internal_force."""
    values: tuple[float, ...]
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

    def run(self) -> None:
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
        _conduct(experiment, None, self, Console())


@dataclass(frozen=True, kw_only=True)
class Report:
    """Write the report of an experiment again, of what is finished of it."""

    folder: Path
    """Of the experiment or sweep."""

    def run(self) -> None:
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


def _conduct(
    experiment: "Experiment",
    search: "Search | None",
    command: RunExperiment | Sweep,
    console: "Console",
) -> None:
    from coopenv.agents.experiments import check, conduct
    from coopenv.agents.experiments.tracking import found

    tune = command.tune if isinstance(command, RunExperiment) else 0
    cells = check(experiment, search=search, tune=tune, workers=command.workers)
    if command.dry_run:
        _print_plan(experiment, len(cells), console)
        return
    if experiment.wandb is not None:
        found()  # told before the first cell
    progress = _progress if console.is_terminal else _lines
    try:
        with progress(console) as show:
            outcome = conduct(
                experiment, search=search, tune=tune, workers=command.workers, show=show
            )
    except KeyboardInterrupt as stop:
        raise KeyboardInterrupt(
            "interrupted; finished cells are kept, and the same command goes on"
        ) from stop
    if outcome.files:
        _print_table(outcome.results, console)
        _print_files(experiment.out, outcome.files, console)
    _raise_failures(outcome, experiment.out)


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


def _print_plan(experiment: "Experiment", cells: int, console: "Console") -> None:
    for axis, levels in experiment.levels().items():
        labels = ", ".join(level.label for level in levels)
        console.print(f"{axis} ({len(levels)}): {labels}", markup=False, highlight=False)
    seeds = len(experiment.seeds)
    console.print(f"seeds ({seeds}): {', '.join(map(str, experiment.seeds))}", highlight=False)
    steps = sum(cell.training.steps for cell in experiment.cells() if cell.learns)
    console.print(
        f"{cells:,} cells, {steps:,} control steps of training, {experiment.episodes} held-out "
        f"episodes each, in {experiment.out}; nothing was run",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )


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


@contextmanager
def _progress(console: "Console") -> Iterator[Callable[..., None]]:
    """A bar over the control steps of all cells, with the time that is left."""
    from rich.progress import (
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns: tuple[Any, ...] = (
        TextColumn("{task.fields[cells]} of {task.fields[of]} cells"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=console, speed_estimate_period=600.0)
    with bar:
        task = bar.add_task("", total=None, cells=0, of="?")
        plan: list[float] = []

        def show(*, done: float, total: float, cells: int, of: int) -> None:
            if plan != [total]:
                plan[:] = [total]
                bar.reset(task, total=total)
            bar.update(task, completed=done, total=total, cells=cells, of=of)

        yield show


@contextmanager
def _lines(console: "Console") -> Iterator[Callable[..., None]]:
    """A line whenever a cell has finished, with the time that is left: for a file of a log."""
    begun, told = monotonic(), [-1]

    def show(*, done: float, total: float, cells: int, of: int) -> None:
        if told == [cells]:
            return
        told[:] = [cells]
        passed = monotonic() - begun
        left = f", {_duration(passed * (total - done) / done)} left" if 0 < done < total else ""
        console.print(f"{cells} of {of} cells{left}", highlight=False)

    yield show


def _duration(seconds: float) -> str:
    """As hours, minutes and seconds."""
    return str(timedelta(seconds=round(seconds)))
