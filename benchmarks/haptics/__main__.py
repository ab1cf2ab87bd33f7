"""What a hand's feeling is good for: followers of somebody who alone knows the goal.

python -m benchmarks.haptics                      # every cell that is not finished yet
python -m benchmarks.haptics --only scripted --write
python -m benchmarks.haptics --only "PPO" "PPO, frames" --seeds 0 1 2 --budget 500000 --write

Agent 0 alone is told the goal (``informed=(0,)``); each sees what it can sense by itself
(``sensing="own"``). A cell is a follower with an action and a beam, of a learner one seed; each is
kept as a small file when it is finished, so that the same command goes on after a kill. ``--write``
puts table and figure on docs/haptics.md, of all cells that are finished at that budget; it replaces
the files beside the page of those cells alone that it was asked for.
"""

from collections.abc import Container, Iterator
from dataclasses import dataclass
from pathlib import Path

import tyro
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from benchmarks.haptics import elsewhere, learned, page, scripted
from benchmarks.haptics.cells import ACTIONS, BEAMS, Cell, Found, grid, kept
from coopenv.arrays import whole
from coopenv.errors import InvalidInput, UnknownName

GROUPS = {"scripted": tuple(scripted.FOLLOWERS), "learned": tuple(learned.LEARNERS)}
FOLLOWERS = tuple(name for group in GROUPS.values() for name in group)


@dataclass(frozen=True, kw_only=True)
class Haptics:
    """Followers with hands that feel, and with wrenches, on two beams."""

    only: tuple[str, ...] = ()
    """Followers by name, or all that are scripted or learned; none: all."""
    actions: tuple[str, ...] = ACTIONS
    """motion, wrench, or both."""
    beams: tuple[str, ...] = tuple(BEAMS)
    """7.7 kg, 20 kg, or both."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Training runs of each learner."""
    budget: int = 2_000_000
    """Rows that a learner learns from: steps of an agent."""
    episodes: int = 500
    """Held-out episodes of each cell."""
    out: Path = Path("runs/haptics")
    """Folder for finished cells."""
    policies: Path | None = None
    """Folder in which learners' policies are kept; cells whose policy it lacks are run again."""
    elsewhere: bool = False
    """Also the scripted followers in the other environments; a few minutes of one core."""
    write: bool = False
    """Put tables and figure on docs/haptics.md."""

    def __post_init__(self) -> None:
        whole(self.budget, "budget", at_least=1)
        whole(self.episodes, "episodes", at_least=1)
        known = {"only": (*GROUPS, *FOLLOWERS), "actions": ACTIONS, "beams": tuple(BEAMS)}
        for name, names in known.items():
            for given in getattr(self, name):
                if given not in names:
                    raise UnknownName(name, given, names)
        if len(set(self.seeds)) < len(self.seeds):
            raise InvalidInput(f"seeds must differ, got {self.seeds}; drop one")

    def cells(self) -> Iterator[Cell]:
        """All that are asked for and possible; scripted ones first, learners' seed by seed."""
        wanted = {name for given in self.only or GROUPS for name in GROUPS.get(given, (given,))}
        every = (
            *grid(GROUPS["scripted"], (None,), None),
            *grid(GROUPS["learned"], self.seeds, self.budget),
        )
        for cell in every:
            asked = cell.action in self.actions and cell.beam in self.beams
            if asked and cell.follower in wanted and module_of(cell).possible(cell):
                yield cell

    def shown(self) -> dict[Cell, Found]:
        """All finished cells that belong on one page: of this budget and number of episodes."""
        asked = set(self.cells())
        mine = {cell: one for cell, one in kept((self.out,)).items() if cell in asked}
        every = (*kept((page.CELLS,)).items(), *mine.items())
        return {cell: one for cell, one in every if self._belongs(one)}

    def lacks(self, cell: Cell, done: Container[Cell]) -> bool:
        """Whether a cell is to be run: it is not finished, or its policy is wanted and not kept."""
        if cell not in done:
            return True
        if self.policies is None or cell.seed is None:
            return False
        path = learned.policy_file(cell, self.policies)
        return path is not None and not path.exists()

    def measure(self, cell: Cell) -> Found:
        """Run a cell."""
        if cell.seed is None:
            return scripted.run(cell, self.episodes)
        return learned.run(cell, self.episodes, self.policies)

    def check_page(self) -> None:
        """Raise `InvalidInput` if the page would lose rows: cells of other numbers of episodes."""
        asked = set(self.cells())
        for cell, one in kept((page.CELLS,)).items():
            shown = cell.rows in (None, self.budget) and cell not in asked
            if shown and one.episodes != self.episodes:
                raise InvalidInput(
                    f"episodes must be {one.episodes} as of {cell.name}, which stands on the page "
                    f"too, got {self.episodes}; measure all of the page, or do not write"
                )

    def _belongs(self, one: Found) -> bool:
        return one.cell.rows in (None, self.budget) and one.episodes == self.episodes


def module_of(cell: Cell):
    """Which of `scripted` and `learned` knows the cell's follower."""
    return scripted if cell.seed is None else learned


def run(study: Haptics, console: Console) -> None:
    """Run every cell that is not finished, and keep it."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    times = TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(*columns, *times, console=console) as progress:
        done, cells = study.shown(), [*study.cells()]
        task = progress.add_task("", total=len(cells))
        for cell in cells:
            progress.update(task, description=cell.name)
            if study.lacks(cell, done):
                found = study.measure(cell)
                found.save(study.out)
                console.print(
                    f"{cell.name}: {100 * found.success:.1f} %, γ {found.relative_cost:.3f}, "
                    f"{found.seconds:.0f} s",
                    highlight=False,
                )
            progress.advance(task)


def main() -> None:
    """Run what the command line asks for; print the table."""
    study, console = tyro.cli(Haptics, description=__doc__), Console()
    if study.write:
        study.check_page()
    run(study, console)
    found = study.shown()
    shown = page.lines(found, FOLLOWERS)
    console.print(page.table(shown), markup=False, soft_wrap=True, highlight=False)
    page.save_table(shown, study.out / "table.csv")
    others = {}
    if study.elsewhere:
        others["elsewhere"] = elsewhere.table(study.episodes)
        console.print(others["elsewhere"], markup=False, soft_wrap=True, highlight=False)
    if study.write:
        page.write(shown, [found[cell] for cell in study.cells() if cell in found], others)


if __name__ == "__main__":
    main()
