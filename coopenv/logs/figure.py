"""Picture of the time series of an analysis, drawn with matplotlib."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra
from coopenv.logs.analysis import Analysis
from coopenv.logs.columns import effector_names
from coopenv.logs.envelope import Envelope
from coopenv.logs.recording import Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COMPONENTS = 6  # lines that a panel bears; with more, norms are drawn
MARKED_TRIALS = 60  # more are not marked
STYLES = ("-", "--", ":")
COLOURS = ("#0072B2", "#F0AA14", "#CC79A7", "#009E73", "#56B4E9", "#F0E442")  # as agents' in films
INTERNAL = "#D55E00"
DPI = 150


class Curve(NamedTuple):
    """A column, or the norm of several."""

    label: str
    columns: tuple[str, ...]
    colour: str
    style: str = "-"


class Panel(NamedTuple):
    """Curves that share their axes."""

    label: str
    curves: list[Curve]
    share: bool = False  # from 0 to 1


class Picture:
    """Collects an analysis piece by piece and draws it.

    Raises
    ------
    MissingExtra
        If matplotlib is missing.
    """

    def __init__(self, title: str):
        try:
            import matplotlib.figure  # noqa: F401
        except ImportError as error:
            raise MissingExtra("the picture of the time series", "analysis") from error
        self._title = title
        self._panels: list[Panel] = []
        self._envelope = Envelope()
        self._axis = _Axis()

    def add(self, recording: Recording, analysis: Analysis) -> None:
        """Append rows."""
        if not self._panels:
            dimension = recording.grips.shape[-1]
            self._panels = panels(recording.num_effectors, dimension, recording.twist is not None)
        curves = [curve for panel in self._panels for curve in panel.curves]
        values = np.stack([_values(analysis, curve) for curve in curves])
        self._envelope.add(self._axis.of(recording), values)

    def draw(self, path: Path) -> None:
        """Write the PNG."""
        from matplotlib.figure import Figure

        rows = (len(self._panels) + 1) // 2
        height = 1.0 + 1.5 * rows  # [inch]
        figure = Figure(figsize=(10, height))
        room = {"bottom": 0.55 / height, "top": 1 - 0.45 / height, "left": 0.09, "right": 0.99}
        every = self._envelope.rows_a_bin
        note = f"; lines: means, bands: extremes of {every} rows each" * (every > 1)
        figure.suptitle(
            self._title + note, fontsize="medium", y=1 - 0.12 / height, va="top", parse_math=False
        )  # a $ in the name of a file is no formula
        grid: Any = figure.subplots(
            rows, 2, sharex=True, squeeze=False, gridspec_kw={**room, "hspace": 0.1, "wspace": 0.27}
        )
        x, low, high, mean = self._envelope.curves()
        at = 0
        for axes, panel in zip(grid.flat, self._panels, strict=False):
            chosen = slice(at, at + len(panel.curves))
            _draw(axes, panel, x, low[chosen], high[chosen], mean[chosen], every > 1)
            for start in self._axis.starts if len(self._axis.starts) <= MARKED_TRIALS else ():
                axes.axvline(start, color="0.6", linewidth=0.6, zorder=0)
            at = chosen.stop
        for axes in grid[-1]:
            axes.set_xlabel(self._axis.label)
        figure.savefig(path, format="png", dpi=DPI)


def panels(num_effectors: int, dimension: int, twist: bool) -> list[Panel]:
    """All panels: forces on the left, torques on the right."""
    made = []
    for prefix, name in (
        ("", "applied"),
        ("manipulation_", "manipulation"),
        ("internal_", "internal"),
    ):
        for kind, unit in (("f", "force [N]"), ("t", "torque [N·m]")):
            curves = _wrench_curves(prefix, kind, num_effectors, dimension)
            made.append(Panel(f"{name}\n{unit}", curves))
    made.append(Panel("F_I [N]", [Curve("", ("internal_force_level",), INTERNAL)]))
    made.append(Panel("T_I [N·m]", [Curve("", ("internal_torque_level",), INTERNAL)]))
    made.append(Panel("force load share", _shares("force_load_share", num_effectors), True))
    made.append(Panel("torque load share", _shares("torque_load_share", num_effectors), True))
    made.append(Panel("relative cost γ", [Curve("", ("relative_cost",), INTERNAL)], True))
    costs = [
        Curve("J(h), applied", ("applied_cost",), "0.5"),
        Curve("J(h_M)", ("cost",), INTERNAL),
        Curve("wasted", ("wasted_cost",), COLOURS[0]),
    ]
    made.append(Panel("cost [N]", costs))
    if twist:
        made.append(Panel("energy share", _shares("energy_share", num_effectors), True))
        made.append(Panel("internal power [W]", [Curve("", ("internal_power",), INTERNAL)]))
    return made


def _wrench_curves(prefix: str, kind: str, num_effectors: int, dimension: int) -> list[Curve]:
    """Components, or norms where there would be too many of them."""
    groups = effector_names(kind, num_effectors, dimension)
    if sum(map(len, groups)) > COMPONENTS:
        return [
            Curve(f"‖{kind}{i + 1}‖", tuple(prefix + name for name in group), _colour(i))
            for i, group in enumerate(groups)
        ]
    return [
        Curve(name, (prefix + name,), _colour(i), STYLES[j])
        for i, group in enumerate(groups)
        for j, name in enumerate(group)
    ]


def _colour(effector: int) -> str:
    return COLOURS[effector % len(COLOURS)]


def _shares(name: str, num_effectors: int) -> list[Curve]:
    return [
        Curve(f"effector {i + 1}", (f"{name}_{i + 1}",), _colour(i)) for i in range(num_effectors)
    ]


def _values(analysis: Analysis, curve: Curve) -> FloatArray:
    if len(curve.columns) == 1:
        return analysis[curve.columns[0]]
    return np.linalg.norm([analysis[name] for name in curve.columns], axis=0)


def _draw(
    axes: "Axes",
    panel: Panel,
    x: FloatArray,
    low: FloatArray,
    high: FloatArray,
    mean: FloatArray,
    thinned: bool,
) -> None:
    """Mean lines, and the bands they come from."""
    for j, curve in enumerate(panel.curves):
        if thinned:
            band: Any = axes.fill_between
            band(x, low[j], high[j], color=curve.colour, alpha=0.2, linewidth=0)
        axes.plot(x, mean[j], color=curve.colour, linestyle=curve.style, linewidth=1.1,
                  label=curve.label or None)  # fmt: skip
    axes.set_ylabel(panel.label)
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    if panel.share and not (low < -0.01).any() and not (high > 1.01).any():
        axes.set_ylim(-0.04, 1.04)
    if axes.get_legend_handles_labels()[0] and len(panel.curves) <= 10:
        columns = 2 if len(panel.curves) > 3 else 1
        axes.legend(fontsize="x-small", loc="upper right", ncols=columns, framealpha=0.7)


class _Axis:
    """Where a row is drawn: at its time, later trials after earlier ones; else at its number."""

    def __init__(self):
        self.starts: list[float] = []  # where trials after the first begin
        self.label = "row"
        self._rows = 0
        self._trial = 0
        self._end = 0.0  # where the last row was drawn
        self._shift = 0.0  # of the current trial's time

    def of(self, recording: Recording) -> FloatArray:
        """``(T,)`` places of the next rows."""
        rows = len(recording)
        time = recording.time
        if time is None:
            x = self._rows + np.arange(1.0, rows + 1)
        else:
            x = time.copy()
            self.label = "time [s]"
        first = np.flatnonzero(np.diff(recording.trial, prepend=self._trial))
        for start, end in zip([0, *first], [*first, rows], strict=True):
            if start == end:
                continue
            part = x[start:end]
            known = part[np.isfinite(part)]
            if start in first and time is not None:
                self.label = "time of the trials, one after the other [s]"
                self._shift = self._end - (known[0] if len(known) else 0.0)
            part += self._shift
            if start in first:
                self.starts.append(float(self._end if time is not None else part[0]))
            if len(known):
                self._end = float(known[-1] + self._shift)
        self._rows += rows
        self._trial = int(recording.trial[-1])
        return x
