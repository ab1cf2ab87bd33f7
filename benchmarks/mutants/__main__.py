"""Mutants of the code, and whether the tests catch them: ``make mutants``.

python -m benchmarks.mutants --mutants 200 --seed 0    # goes on where it was broken off
python -m benchmarks.mutants --seed 0 --again          # tries survivors anew, with newer tests
python -m benchmarks.mutants --seed 0 --write          # also writes docs/mutants.md, of all seeds

A seed's sample is that of one state of the code: where the code changes, another one is drawn.
"""

from dataclasses import dataclass
from pathlib import Path

import tyro
from rich.console import Console
from rich.table import Table

from benchmarks.mutants.campaign import Campaign
from benchmarks.mutants.child import warm_up
from benchmarks.mutants.report import score, survivors, table
from benchmarks.mutants.tree import Project

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Put faults into the code one at a time and see whether the tests notice."""

    mutants: int = 200
    """How many."""
    seed: int = 0
    """Of the sample."""
    budget: float = 60.0
    """Seconds of tests for a mutant, by what they took when they were recorded."""
    folder: Path = ROOT / ".mutants"
    """For the copy of the tree, recordings and results."""
    again: bool = False
    """Try the survivors anew."""
    quick: bool = False
    """Record only files of tests that a mutant needs, and at most three for each."""
    jobs: int = 1
    """Files of tests recorded at a time."""
    write: bool = False
    """Write docs/mutants.md, of all seeds whose mutants have been tried."""


def main() -> None:
    """Try the sample and print what came of it."""
    settings = tyro.cli(Settings)
    warm_up()
    campaign = Campaign(
        project=Project(root=ROOT),
        folder=settings.folder.resolve(),
        mutants=settings.mutants,
        seed=settings.seed,
        budget=settings.budget,
        again=settings.again,
        record_all=not settings.quick,
        jobs=settings.jobs,
    )
    results = campaign.run()
    tables = (
        table(results, "folder", lambda result: result.folder),
        table(results, "operator", lambda result: result.operator),
    )
    print("\n\n".join(survivors(results)))
    console = Console()
    for columns, rows in tables:
        shown = Table(*columns)
        for row in rows:
            shown.add_row(*row)
        console.print(shown)
    console.print(f"{score(results):.1f} % of those that change behaviour were caught")
    if settings.write:
        from benchmarks.mutants.page import write

        write(campaign.finished())


if __name__ == "__main__":
    main()
