"""``coopenv benchmark``: enter policies in the suites of the benchmark."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from coopenv.cli.progress import bar_over, lines_over
from coopenv.errors import InvalidInput
from coopenv.options import POSITIONAL, Common

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.benchmark import Entry, Outcome, Plan, Suite

SHOWN = ("success_rate", "success_time", "effort", "relative_cost", "internal_force_level")


@dataclass(frozen=True, kw_only=True)
class Benchmark:
    """Enter policies in the benchmark: the same scenarios, episodes and measures for all.

    Everything is tried for two steps before the first episode. Interrupted or killed, the same
    command goes on.
    """

    entries: Annotated[tuple[str, ...], POSITIONAL] = ()
    """nobody, random, scripted, scripted:nonsqueezing and the like; module:function of your own;
    the file of a trained policy, or pretrained:{task}/joint, where {task} stands for the task of
    each scenario. See docs/benchmark.md."""
    suites: tuple[str, ...] = ()
    """team, partners, bodies, haptics; all without one."""
    only: tuple[str, ...] = ()
    """Scenarios of these suites by name, for example BeamDoorway, or "motion, 20 kg"."""
    name: str | None = None
    """What a single entry is called in tables and files."""
    out: Path = Path("runs/benchmark")
    """Folder for the summaries."""
    trust: bool = False
    """Run what the files hold: pickles of Stable-Baselines3."""
    dry_run: bool = False
    """Try everything for two steps and say what it comes to; write nothing."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv benchmark scripted random --suites team --only BeamTransport",
        "coopenv benchmark 'pretrained:{task}/joint' --dry-run",
        "coopenv benchmark runs/carry/policy.npz --name carry --suites partners bodies",
        "coopenv benchmark my_policies:act --suites haptics --json",
    )

    def run(self) -> dict[str, Any]:
        """Try, run, print the tables."""
        from rich.console import Console

        from coopenv.agents.benchmark import conduct, find_suites, plan

        suites = find_suites(self.suites)
        planned = plan(self._entries(), suites, self.only)
        console, errors = Console(), Console(stderr=True)
        for what, why in planned.left_out.items():
            errors.print(f"left out: {what}: {why}", markup=False, highlight=False, soft_wrap=True)
        if self.dry_run:
            return _told(planned, suites, console)
        progress = bar_over if console.is_terminal else lines_over
        try:
            with progress(console) as show:
                outcome = conduct(planned, self.out, show)
        except KeyboardInterrupt as stop:
            raise KeyboardInterrupt(
                "interrupted; finished scenarios are kept, and the same command goes on"
            ) from stop
        _print_tables(outcome, suites, console)
        return _document(outcome)

    def _entries(self) -> "list[Entry]":
        from coopenv.agents.benchmark import read_entry

        if not self.entries:
            raise InvalidInput(
                "entries must name at least one, got none; for example: coopenv benchmark scripted"
            )
        if self.name is not None and len(self.entries) > 1:
            raise InvalidInput(
                f"name must be of a single entry, got {self.name!r} for {len(self.entries)}; enter "
                "them one by one"
            )
        return [read_entry(given, name=self.name, trust=self.trust) for given in self.entries]


def _told(planned: "Plan", suites: "Sequence[Suite]", console: "Console") -> dict[str, Any]:
    """What a plan comes to."""
    cells = planned.cells
    for suite in suites:
        names = dict.fromkeys(cell.scenario.name for cell in cells if cell.suite is suite)
        line = f"{suite.label} ({len(names)}): {'; '.join(names)}"
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    episodes = sum(cell.suite.episodes for cell in cells)
    console.print(
        f"{len(cells)} cells, {episodes:,} held-out episodes at each of 3 tolerances; nothing was "
        "run",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )
    scenarios = [
        {"entry": cell.entry.name, "suite": cell.suite.label, "scenario": cell.scenario.name}
        for cell in cells
    ]
    return {"cells": scenarios, "episodes": episodes, "left_out": dict(planned.left_out)}


def _print_tables(outcome: "Outcome", suites: "Sequence[Suite]", console: "Console") -> None:
    """A table a suite: a line for each scenario and entry."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    from coopenv.agents.benchmark.measures import MEASURES, shown

    heads = [" ".join(filter(None, MEASURES[name])) for name in SHOWN]
    for suite in suites:
        mine = [each for each in outcome.summaries.values() if each.suite == suite.name]
        table = Table("scenario", "entry", *heads, box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
        for one in suite.scenarios:
            for summary in mine:
                if one.name in summary.results:
                    found = summary.results[one.name].measures
                    cells = [shown(name, found[name]) for name in SHOWN]
                    table.add_row(*map(Text, (one.name, summary.entry, *cells)))
        if table.row_count:
            console.print(Text(f"{suite.label}: {suite.title} [95 % interval]", "table.title"))
            console.print(table)
    for path in outcome.summaries:
        console.print(f"wrote {path}", markup=False, highlight=False, soft_wrap=True)


def _document(outcome: "Outcome") -> dict[str, Any]:
    """Every measure with its interval, for programs."""
    from dataclasses import asdict

    return {
        "summaries": [asdict(summary) for summary in outcome.summaries.values()],
        "left_out": dict(outcome.left_out),
        "files": [*outcome.summaries],
    }
