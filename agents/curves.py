"""Learning curves: a table of numbers over steps, as CSV and as a picture."""

import csv
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from coopenv.errors import MissingExtra
from coopenv.files import written

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Row = dict[str, float]
"""What one update's episodes showed, by name; ``steps`` is where it stands on the axis."""

PANELS = {
    "return": {"reward": "return of an episode"},
    "success": {"success": "success rate"},
    "relative cost": {"relative_cost": "γ"},
    "disagreement": {
        "internal_force_level": "F_I [N]",
        "internal_torque_level": "T_I [N·m]",
        "wasted_cost": "wasted cost [N]",
    },
    "unevenness of the load": {"load_imbalance": "0: alike, 1: one carries all"},
}

STYLES = ("-", "--", ":")  # of the quantities that share a panel


def save_rows(rows: Sequence[Row], path: str | os.PathLike) -> None:
    """Write the curves as CSV, one row an update."""
    names = dict.fromkeys(name for row in rows for name in row)
    with written(path) as part, part.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(names))
        writer.writeheader()
        writer.writerows(rows)


def draw(runs: Mapping[str, Sequence[Sequence[Row]]], path: str | os.PathLike) -> None:
    """Draw curves into a PNG.

    Parameters
    ----------
    runs
        Label → the curves of one or several runs, which share a colour. The reward terms are
        drawn for a single label only.
    path
        Of the picture.
    """
    try:
        from matplotlib.figure import Figure
        from matplotlib.ticker import EngFormatter
    except ImportError as error:
        raise MissingExtra("the picture of the curves", "train") from error
    figure = Figure(figsize=(12, 6.5), layout="constrained")
    figure.suptitle("episodes during training, exploration noise included")
    grid: Any = figure.subplots(2, 3)
    panels: list[Axes] = list(grid.flat)
    for axes, (title, curves) in zip(panels, PANELS.items(), strict=False):
        axes.set_title(title)
        for number, (label, group) in enumerate(runs.items()):
            for name, style in zip(curves, STYLES, strict=False):
                parts = [label] * (len(runs) > 1) + [curves[name]] * (len(curves) > 1)
                _lines(axes, group, name, ", ".join(parts), color=f"C{number}", linestyle=style)
        if len(curves) == 1:
            axes.set_ylabel(next(iter(curves.values())))
    panels[1].set_ylim(-0.02, 1.02)
    for axes in panels[2:5]:
        axes.set_ylim(bottom=0)
    if len(runs) == 1:
        panels[-1].set_title("reward terms, sums over an episode")
        (group,) = runs.values()
        terms = sorted({name for rows in group for row in rows for name in row if "/" in name})
        for number, name in enumerate(terms):
            _lines(panels[-1], group, name, name.removeprefix("reward/"), color=f"C{number}")
    else:
        panels[-1].set_axis_off()
    for axes in panels:
        axes.set_xlabel("control steps")
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.grid(alpha=0.3)
        axes.margins(x=0)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize="small")
    with written(path) as part:
        figure.savefig(part, format="png", dpi=110)


def _lines(
    axes: "Axes", group: Sequence[Sequence[Row]], name: str, label: str, **look: Any
) -> None:
    """One line a run, all alike; the first bears the label."""
    for number, rows in enumerate(group):
        seen = [(row["steps"], row[name]) for row in rows if name in row]
        if seen:
            steps, values = np.transpose(seen)
            shown = label if label and number == 0 else None
            axes.plot(steps, values, label=shown, linewidth=1.4, **look)
