"""What prices on disagreement do: ``python -m benchmarks.learning.shaping [--runs DIR] [--write]``.

``coopenv experiment examples/reward_shaping.toml --out DIR`` trains and evaluates; ``--runs DIR``
takes what came out of it into docs/results/reward_shaping/runs.csv. From that file come the tables
and the picture of docs/results/reward_shaping.md, which ``--write`` renews.
"""

from dataclasses import dataclass
from pathlib import Path

import tyro
from rich.console import Console

from benchmarks.learning.shaping.answer import shown, tables
from benchmarks.learning.shaping.picture import draw
from benchmarks.learning.shaping.runs import saved, take
from benchmarks.pages import DOCS, fill

PAGE = DOCS / "results" / "reward_shaping.md"
PICTURE = PAGE.with_suffix(".png")


@dataclass(frozen=True, kw_only=True)
class Shaping:
    """Renew the page of the reward-shaping grid."""

    runs: Path | None = None
    """Folder of the experiment, whose results are taken into docs/results/reward_shaping."""
    write: bool = False
    """Put tables and picture onto docs/results/reward_shaping.md."""


def main() -> None:
    """Take, print and write what the command line asks for."""
    asked, console = tyro.cli(Shaping), Console()
    if asked.runs is not None:
        take(asked.runs)
    made = tables(saved())
    for table in made.values():
        console.print(table, markup=False, soft_wrap=True)
    if asked.write:
        draw(shown(saved()), PICTURE)
        fill(PAGE, made)


if __name__ == "__main__":
    main()
