"""The page of the benchmark: its table with intervals, and its figure."""

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.haptics.cells import ACTIONS, BEAMS, Cell, Found
from benchmarks.learning.partner_ablation import interval
from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.evaluate import wilson_interval
from coopenv.arrays import FloatArray
from coopenv.files import written

PAGE = DOCS / "haptics.md"
FIGURE = DOCS / "haptics.png"
CELLS = DOCS / "haptics"  # finished cells, small files
COLUMNS = ("success [%]", "steps", "effort [N]", "γ", "F_I [N]")


@dataclass(frozen=True, kw_only=True)
class Line:
    """A follower with one action and beam: all its seeds."""

    follower: str
    action: str
    beam: str
    found: tuple[Found, ...]

    def success(self) -> tuple[float, float, float]:
        """Mean, low and high end of the 95 % interval [%].

        Over the seeds by the bootstrap; of a single run over its episodes (Wilson).
        """
        rates = np.array([one.success for one in self.found])
        middle = float(rates.mean())
        if len(rates) == 1:
            count = self.found[0].episodes
            low, high = wilson_interval(round(middle * count), count)
        else:
            low, high = _ends(rates)
        return 100 * middle, 100 * low, 100 * high

    def cells(self) -> list[str]:
        """What the table shows of it."""
        middle, low, high = self.success()
        steps = [one.steps for one in self.found if one.steps is not None]
        return [
            f"{middle:.1f} [{low:.1f}, {high:.1f}]",
            f"{np.mean(steps):.0f}" if steps else "–",
            f"{np.mean([one.effort for one in self.found]):.2f}",
            f"{np.mean([one.relative_cost for one in self.found]):.3f}",
            f"{np.mean([one.internal_force for one in self.found]):.2f}",
        ]


def lines(found: Mapping[Cell, Found], followers: Sequence[str]) -> list[Line]:
    """One for each follower, action and beam of which there is something."""
    made = []
    for beam in BEAMS:
        for action in ACTIONS:
            for follower in followers:
                mine = [one for cell, one in found.items() if cell[:3] == (follower, action, beam)]
                if mine:
                    made.append(
                        Line(follower=follower, action=action, beam=beam, found=tuple(mine))
                    )
    return made


def table(shown: Sequence[Line]) -> str:
    """All lines as Markdown; with the number of seeds, where somebody learned."""
    rows = [[line.beam, line.action, line.follower, _seeds(line), *line.cells()] for line in shown]
    return markdown(("beam", "action", "follower", "seeds", *COLUMNS), rows)


def write(shown: Sequence[Line], measured: Sequence[Found], others: Mapping[str, str]) -> None:
    """Put the table, ``others`` and the figure on the page, and what was ``measured`` beside it.

    Other cells beside the page stay as they are.
    """
    fill(PAGE, {"haptics": table(shown), **others})
    draw(shown, FIGURE)
    for one in measured:
        one.save(CELLS)


def save_table(shown: Sequence[Line], path: Path) -> None:
    """The table as CSV."""
    with written(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("beam", "action", "follower", "seeds", *COLUMNS))
        for line in shown:
            writer.writerow([line.beam, line.action, line.follower, _seeds(line), *line.cells()])


def draw(shown: Sequence[Line], path: Path) -> None:
    """Success of every follower with its interval, a panel a beam, a colour an action."""
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(line.follower for line in shown))
    figure = Figure(figsize=(10, 1.5 + 0.32 * len(names)), layout="constrained")
    panels = figure.subplots(1, len(BEAMS), sharey=True, squeeze=False)[0]
    for axes, beam in zip(panels, BEAMS, strict=True):
        for number, action in enumerate(ACTIONS):
            mine = [line for line in shown if (line.beam, line.action) == (beam, action)]
            if not mine:
                continue
            middle, low, high = np.array([line.success() for line in mine]).T
            place = np.array([names.index(line.follower) for line in mine]) + 0.16 * number
            ends = np.maximum([middle - low, high - middle], 0.0)
            axes.errorbar(
                middle, place, xerr=ends, fmt="os"[number], color=f"C{number}", label=action,
                capsize=3,
            )  # fmt: skip
        axes.set_title(beam)
        axes.set_xlim(-2, 102)
        axes.set_xlabel("success [%], 95 %")
        axes.grid(axis="x", alpha=0.3)
    panels[0].set_yticks(range(len(names)), names)
    panels[0].invert_yaxis()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    with written(path) as part:
        figure.savefig(part, format="png", dpi=110, metadata={"Software": None})


def _seeds(line: Line) -> str:
    return "–" if line.found[0].cell.seed is None else str(len(line.found))


def _ends(rates: FloatArray) -> tuple[float, float]:
    """Ends of the bootstrap interval over seeds."""
    shown = interval([rates])
    if "[" not in shown:
        return float(rates.mean()), float(rates.mean())
    low, high = shown.partition("[")[2].rstrip("]").split(", ")
    return float(low), float(high)
