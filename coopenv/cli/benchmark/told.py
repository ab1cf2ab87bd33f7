"""What the benchmark's command tells: its plan, a table a suite, a document for programs."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

    from coopenv.agents.benchmark import Outcome, Plan, Suite
    from coopenv.agents.benchmark.trained import Trained

SHOWN = ("success_rate", "success_time", "effort", "relative_cost", "internal_force_level")


def show_plan(planned: "Plan", suites: "Sequence[Suite]", console: "Console") -> dict[str, Any]:
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
    for suite in suites:
        for name in dict.fromkeys(cell.entry.name for cell in cells if cell.suite is suite):
            mine = (suite, name)
            told = [cell.trained for cell in cells if (cell.suite, cell.entry.name) == mine]
            _print_training(name, suite, told, console)
    scenarios = [
        {"entry": cell.entry.name, "suite": cell.suite.label, "scenario": cell.scenario.name}
        for cell in cells
    ]
    return {"cells": scenarios, "episodes": episodes, "left_out": dict(planned.left_out)}


def print_tables(outcome: "Outcome", suites: "Sequence[Suite]", console: "Console") -> None:
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
        for summary in mine:
            _print_training(summary.entry, suite, summary.trained, console)
    for path in outcome.summaries:
        console.print(f"wrote {path}", markup=False, highlight=False, soft_wrap=True)


def _print_training(
    entry: str, suite: "Suite", told: "Sequence[Trained | None]", console: "Console"
) -> None:
    """How much training is behind an entry, where that is not told or more than the budget."""
    from coopenv.agents.benchmark.trained import UNTOLD, exceeds, said

    if exceeds(told, suite.budget):
        told = [one for one in told if one is not None]
        remedy = "is marked as over it"
    elif said(told) == UNTOLD:
        remedy = "is marked so; --trained STEPS says it"
    else:
        return
    line = (
        f"{entry} in {suite.label}: trained {said(told)}, of {suite.budget:,} control steps, "
        f"{remedy}"
    )
    console.print(line, markup=False, highlight=False, soft_wrap=True)


def document_of(outcome: "Outcome") -> dict[str, Any]:
    """Every measure with its interval, for programs."""
    from dataclasses import asdict

    return {
        "summaries": [asdict(summary) for summary in outcome.summaries.values()],
        "left_out": dict(outcome.left_out),
        "files": [*outcome.summaries],
    }
