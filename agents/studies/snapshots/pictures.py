"""Pictures of the snapshots: panels drawn by ``wrench.plot``, one legend for all."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra
from coopenv.wrench import decompose, plot

from ..figures import save_figure
from . import examples

PANEL = (4.0, 2.9)  # [in]
FOOT = 0.75  # [in] for the legend
COLUMNS = 2


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One split, and how it is drawn."""

    title: str
    applied: FloatArray
    grips: FloatArray
    options: Mapping[str, Any] = field(default_factory=dict)


def panels() -> dict[str, list[Panel]]:
    """Panels of each picture, by the name of its file."""
    lines = [
        Panel(f"({first:g}, {second:g}) N: {name}", applied, examples.BEAM, {"method": method})
        for (first, second), applied in zip(
            examples.LINE, examples.along(examples.LINE), strict=True
        )
        for name, method in (("ours", "optimal"), ("Moore-Penrose", "moore_penrose"))
    ]
    trio = examples.TRIO - examples.TRIO_SPLIT
    return {
        "fig2": lines,
        "fig3": _methods(examples.COUPLE, examples.BEAM, ("optimal", *_OTHERS)),
        "fig4": _discs(),
        "fig5": [
            Panel("the figure's split", examples.TRIO, examples.POINT, {"internal": trio}),
            *_methods(examples.TRIO, examples.POINT, ("point_mass", *_MOST)),
        ],
        "fig6": _methods(examples.GRASP, examples.DIGITS, ("optimal", *_OTHERS)),
        "fig7": _methods(examples.PAIR, examples.SHORTER, ("optimal", "point_mass")),
        "fig8": [
            Panel(f"{name}: w = {w:g}", applied, examples.SHORTER, {"torque_weight": w})
            for name, applied in _WEIGHED.items()
            for w in (0.1, 0.9)
        ],
    }


_OTHERS = ("moore_penrose", "nonsqueezing", "virtual_linkage")
_MOST = ("max_internal", "moore_penrose")
_NAMES = {
    "optimal": "ours",
    "point_mass": "point mass (23)",
    "moore_penrose": "Moore-Penrose",
    "nonsqueezing": "nonsqueezing",
    "virtual_linkage": "virtual linkage",
    "max_internal": "most internal force",
}
_WEIGHED = {"w matters": examples.WEIGHED, "it is of no account": examples.UNWEIGHED}


def _methods(applied: FloatArray, grips: FloatArray, methods: Sequence[str]) -> list[Panel]:
    return [Panel(_NAMES[method], applied, grips, {"method": method}) for method in methods]


def _discs() -> list[Panel]:
    """Splits of one force, against an effector that gives way: on the circle, within, beyond."""
    found = []
    for name, reach in (("within the disc", 0.3), ("beyond it: not plausible", 0.75)):
        internal = np.zeros((2, 3))
        internal[0, :2] = reach * examples.SINGLE + 0.4 * np.array([-1.0, 3.0]) * reach
        internal[1] = -internal[0]
        applied = np.zeros((2, 3))
        applied[0, :2], applied[1] = examples.SINGLE, internal[1]
        found.append(Panel(name, applied, examples.PAIR_POINT, {"internal": internal}))
    return found


def draw(name: str, shown: Sequence[Panel], path: str | os.PathLike) -> None:
    """Draw panels two in a row into a PNG.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtra("the figures of a study", "analysis") from error
    rows = (len(shown) + COLUMNS - 1) // COLUMNS
    size = (COLUMNS * PANEL[0], rows * PANEL[1] + FOOT)
    figure = Figure(figsize=size)
    grid = figure.subplots(rows, COLUMNS, squeeze=False)
    legend: dict[str, Any] = {}
    for panel, axes in zip(shown, grid.flat, strict=False):
        plot(panel.applied, panel.grips, ax=axes, legend=False, **panel.options)
        axes.set_title(f"{panel.title}\n{axes.get_title().partition(': ')[2]}", fontsize=9)
        axes.set(xlabel="", ylabel="")
        axes.tick_params(labelsize=7)
        handles, names = axes.get_legend_handles_labels()
        legend |= {key: value for key, value in zip(names, handles, strict=True)}
    for axes in grid.flat[len(shown) :]:
        axes.set_axis_off()
    figure.legend(legend.values(), legend.keys(), loc="lower center", ncols=3, fontsize=9,
                  frameon=False)  # fmt: skip
    figure.subplots_adjust(
        left=0.06, right=0.985, top=1 - 0.42 / size[1], bottom=(FOOT + 0.25) / size[1],
        hspace=0.32, wspace=0.14,
    )  # fmt: skip
    save_figure(figure, path)


def draw_power(path: str | os.PathLike) -> None:
    """Fig. 17: the split of a pair, and the powers of both for every direction of motion."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtra("the figures of a study", "analysis") from error
    figure = Figure(figsize=(8.0, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    applied, grips = examples.CROSSING, examples.PAIR_POINT
    plot(applied, grips, method="point_mass", ax=left, title="point mass (23)")
    angle = np.linspace(-np.pi, np.pi, 361)
    speed = np.stack([np.cos(angle), np.sin(angle)])
    split = decompose(applied, grips, method="point_mass").manipulation
    power, shown = applied[1, :2] @ speed, split[1, :2] @ speed
    right.fill_between(np.degrees(angle), np.minimum(power, 0), np.maximum(power, 0),
                       color="#E4E4E4", label="between 0 and Ė_2: eq. 35")  # fmt: skip
    right.plot(np.degrees(angle), power, color="#777777", linewidth=2.4, label="Ė_2, applied")
    right.plot(np.degrees(angle), shown, "--", color="#0072B2", linewidth=1.8,
               label="Ė_M,2, manipulation")  # fmt: skip
    right.axvline(float(np.degrees(np.arctan2(*examples.TWIST[1::-1]))), color="#D55E00",
                  linewidth=1.0, label="the velocity of the claim")  # fmt: skip
    right.set(xlabel="direction of a velocity of 1 m/s [°]", ylabel="power of effector 2 [W]")
    right.legend(
        fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2
    )
    right.grid(alpha=0.3)
    save_figure(figure, path)
