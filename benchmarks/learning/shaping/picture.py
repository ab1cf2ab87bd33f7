"""The picture of the reward-shaping grid: a row a reward, a panel an action and measure."""

from collections.abc import Mapping
from math import isfinite
from pathlib import Path

from coopenv.files import written

DPI = 110
Shown = tuple[float, float, float]
"""Value, low and high end of its interval."""


def draw(panels: Mapping[str, Mapping[str, Shown]], path: Path, *, across: int = 4) -> None:
    """Intervals of every panel, ``across`` of them side by side.

    Parameters
    ----------
    panels
        Title of a panel to its lines, by label; the same labels in each.
    path
        Of the PNG.
    across
        Panels in a row.
    """
    from matplotlib.figure import Figure

    labels = [*next(iter(panels.values()))]
    down = -(-len(panels) // across)
    size = (3.0 + 2.4 * across, down * (0.9 + 0.27 * len(labels)))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(down, across, sharey=True, squeeze=False).flatten()
    for place, (title, lines) in zip(axes, panels.items(), strict=False):
        for row, label in enumerate(labels):
            value, low, high = lines[label]
            colour = f"C{int(row >= len(labels) // 2)}"
            if isfinite(value):
                place.hlines(row, low, high, color=colour, linewidth=5, alpha=0.35)
                place.plot([value], [row], "|", color=colour, markersize=11, markeredgewidth=2)
        place.axhline(len(labels) / 2 - 0.5, color="0.6", linewidth=0.8)
        place.set_title(title, fontsize="medium")
        place.set_ylim(len(labels) - 0.5, -0.5)
        place.grid(axis="x", alpha=0.3)
        place.margins(x=0.08)
    axes[0].set_yticks(range(len(labels)), labels)
    for spare in axes[len(panels) :]:
        spare.set_visible(False)
    with written(path) as part:
        figure.savefig(part, format="png", dpi=DPI, metadata={"Software": None})
