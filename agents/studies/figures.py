"""Figures of trials over time: what was applied, what each method calls internal.

Trials stand side by side, one column each; quantities one below the other with a common scale.
Legends are beside the panels, where they hide nothing.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra
from coopenv.files import written
from coopenv.wrench import Decomposition, energy_share, load_share, object_wrench

from .methods import LOOKS, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 150
PANEL = (1.75, 1.35)  # [in] so small that words are still read where a page is 600 px wide
MARGINS = (0.85, 1.9, 0.55, 0.75)  # [in] left, right (legends), bottom, top
BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#444444"  # after Okabe & Ito


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """One recorded trial, as it is drawn."""

    title: str
    time: FloatArray  # (time,) [s]
    pose: FloatArray  # (time, 3) world frame [m, rad]
    twist: FloatArray  # (time, 3) object frame [m/s, rad/s]
    applied: FloatArray  # (time, 2, 3) object frame [N, N·m]
    grips: FloatArray  # (2, 2) [m]
    by_method: Mapping[str, Decomposition] = field(default_factory=dict)
    planned: FloatArray | None = None  # (time, 3) as pose


@dataclass(frozen=True, slots=True)
class Curve:
    """One line in a panel."""

    label: str
    values: FloatArray  # (time,)
    look: Look


Panel: TypeAlias = tuple[str, Callable[[Trial], Sequence[Curve]]]
"""What the vertical axis says, with unit, and the curves of a trial."""


def first(label: str) -> Look:
    """How the first of several curves is drawn."""
    return Look(label, BLUE, "-", 2.4)


def second(label: str) -> Look:
    """The second."""
    return Look(label, ORANGE, "--", 1.6)


def third(label: str) -> Look:
    """The third."""
    return Look(label, GREEN, ":", 1.8)


def pose_curves(trial: Trial) -> list[Curve]:
    """Pose, and the plan behind it."""
    looks = (first("x [m]"), second("y [m]"), third("θ [rad]"))
    curves = [curve(look, trial.pose[:, i]) for i, look in enumerate(looks)]
    if trial.planned is not None:
        plan = Look("plan", "#BBBBBB", "-", 5.0)
        plans = [curve(plan, trial.planned[:, i]) for i in range(3)]
        curves = plans + curves
    return curves


def resultant_curves(trial: Trial) -> list[Curve]:
    """Force and torque on the object."""
    resultant = object_wrench(trial.applied, trial.grips)
    looks = (first("f_o,x [N]"), second("f_o,y [N]"), third("t_o [N·m]"))
    return [curve(look, resultant[:, i]) for i, look in enumerate(looks)]


def component(index: int, symbol: str) -> Callable[[Trial], Sequence[Curve]]:
    """One component of both agents' applied wrench."""

    def curves(trial: Trial) -> list[Curve]:
        looks = (first(f"{symbol.format(1)}"), second(f"{symbol.format(2)}"))
        return [curve(look, trial.applied[:, i, index]) for i, look in enumerate(looks)]

    return curves


def load_share_curves(trial: Trial) -> list[Curve]:
    """Load shares of agent 1; gaps where they are undefined."""
    share = load_share(trial.applied, trial.grips)
    return [
        curve(first("α_f,1 (force)"), share.force[:, 0]),
        curve(second("α_t,1 (torque)"), share.torque[:, 0]),
    ]


def energy_share_curves(trial: Trial) -> list[Curve]:
    """Energy shares of agent 1; gaps where they are undefined."""
    share = energy_share(trial.applied, trial.grips, trial.twist)
    return [
        curve(first("β_1 (total)"), share.total[:, 0]),
        curve(second("β_lin,1"), share.linear[:, 0]),
        curve(third("β_rot,1"), share.angular[:, 0]),
    ]


def method_curves(measure: str) -> Callable[[Trial], Sequence[Curve]]:
    """One measure of the decomposition (an attribute of `Decomposition`), by method."""

    def curves(trial: Trial) -> list[Curve]:
        return [
            curve(LOOKS[name], getattr(split, measure)) for name, split in trial.by_method.items()
        ]

    return curves


MOTION_PANELS: tuple[Panel, ...] = (
    ("pose [m, rad]", pose_curves),
    ("on the object\n[N, N·m]", resultant_curves),
    ("force along [N]", component(0, "f_{},x")),
    ("force across [N]", component(1, "f_{},y")),
    ("torque [N·m]", component(2, "t_{}")),
    ("load share", load_share_curves),
    ("energy share", energy_share_curves),
)
"""What was done: counterparts of Figs. 9 and 12."""

DISAGREEMENT_PANELS: tuple[Panel, ...] = (
    ("F_I [N]", method_curves("internal_force_level")),
    ("T_I [N·m]", method_curves("internal_torque_level")),
    ("γ", method_curves("relative_cost")),
)
"""What the methods make of it: counterparts of Figs. 10, 11 and 13."""


def draw_trials(
    trials: Sequence[Trial],
    panels: Sequence[Panel],
    path: str | os.PathLike,
    *,
    title: str = "",
    marks: Sequence[float] = (),
) -> None:
    """Draw trials side by side into a PNG.

    Parameters
    ----------
    trials
        One a column.
    panels
        One a row; all columns share its scale.
    path
        Of the picture.
    title
        Above everything.
    marks
        Instants at which a thin vertical line is drawn [s].

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    left, right, bottom, top = MARGINS
    width, height = left + PANEL[0] * len(trials) + right, bottom + PANEL[1] * len(panels) + top
    figure, grid = new_figure(len(panels), len(trials), size=(width, height), layout=None)
    figure.subplots_adjust(  # by hand: a layout engine takes as long as everything else together
        left=left / width,
        right=1 - right / width,
        bottom=bottom / height,
        top=1 - top / height,
        wspace=0.06,
        hspace=0.14,
    )
    if title:
        figure.suptitle(title)
    explained: list[str] = []
    for row, (label, curves_of) in zip(grid, panels, strict=True):
        for axes, trial in zip(row, trials, strict=True):
            draw_panel(axes, trial.time, curves_of(trial), marks)
        share_scale(row)
        row[0].set_ylabel(label)
        if explained != (explained := row[-1].get_legend_handles_labels()[1]):
            legend_beside(row[-1])
    for axes, trial in zip(grid[0], trials, strict=True):
        axes.set_title(trial.title, fontsize="medium")
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    figure.align_ylabels(grid[:, 0])
    save_figure(figure, path)


def new_figure(
    rows: int,
    columns: int,
    *,
    size: tuple[float, float],
    layout: Literal["constrained"] | None = "constrained",
) -> "tuple[Figure, Any]":
    """A figure and its axes ``(rows, columns)``; size in inches."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtra("the figures of a study", "analysis") from error
    figure = Figure(figsize=size, layout=layout)
    return figure, figure.subplots(rows, columns, squeeze=False, sharex="col")


def save_figure(figure: "Figure", path: str | os.PathLike) -> None:
    """Write the figure as PNG, whole or not at all."""
    with written(path) as part:
        figure.savefig(part, format="png", dpi=DPI)


def curve(look: Look, values: FloatArray) -> Curve:
    """A line that is called as its look is."""
    return Curve(look.label, values, look)


def draw_panel(
    axes: "Axes", time: FloatArray, curves: Sequence[Curve], marks: Sequence[float]
) -> None:
    """Curves over time; several of one label share one entry of the legend."""
    labels = set()
    for each in curves:
        look = each.look
        label = None if each.label in labels else each.label
        labels.add(each.label)
        axes.plot(time, each.values, look.line, color=look.color, linewidth=look.width, label=label)
    for mark in marks:
        axes.axvline(mark, color="#999999", linewidth=0.6)
    axes.grid(alpha=0.3)
    axes.margins(x=0)


def share_scale(row: "Sequence[Axes]") -> None:
    """One vertical scale for a row; a range that is only rounding is opened to ±1."""
    low = min(axes.dataLim.ymin for axes in row)
    high = max(axes.dataLim.ymax for axes in row)
    if not np.isfinite([low, high]).all() or high - low < 1e-6:
        middle = 0.0 if not np.isfinite([low, high]).all() else (low + high) / 2
        low, high = middle - 1, middle + 1
    room = 0.06 * (high - low)
    for axes in row:
        axes.set_ylim(low - room, high + room)
        if axes is not row[0]:
            axes.tick_params(labelleft=False)


def legend_beside(axes: "Axes") -> None:
    """A legend to the right of a panel, where it hides nothing."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            loc="center left",
            bbox_to_anchor=(1.02, 0.5),
            fontsize="small",
            frameon=False,
            handlelength=2.8,
        )
