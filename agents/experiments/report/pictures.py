"""Pictures of an experiment: intervals, performance profiles, learning curves, Pareto front."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra
from coopenv.files import written

from ...curves import Row
from .measures import DISAGREEMENT, MEASURES, SUCCESS, TIME
from .statistics import Scores, bootstrap_interval, interquartile_mean, performance_profile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 110
STEPS = 101  # thresholds of a profile, and places of a curve
RESAMPLES = 500  # for the bands of curves and profiles
FEW = 6  # settings up to which bands are drawn; more would hide each other
HEIGHT = 0.19  # [in] of a line of a legend, at least
MARKS = ("o", "s", "D", "^")  # after ten settings colours come again
LINES = ("-", "--", ":", "-.")
CURVES = (SUCCESS, DISAGREEMENT, "internal_force_level")  # panels of the learning curves
NAMES = {SUCCESS: "success"}  # of measures in curves, where it is another


class Interval(Protocol):
    """A value with its interval."""

    @property
    def value(self) -> float: ...  # noqa: D102
    @property
    def low(self) -> float: ...  # noqa: D102
    @property
    def high(self) -> float: ...  # noqa: D102


Found = Mapping[str, Mapping[str, "Interval | None"]]
"""Title of a setting -> measure -> estimate."""


def draw_intervals(found: Found, path: Path) -> None:
    """A panel a measure, a row a setting.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    figure = _figure(2.4 * len(MEASURES) + 2.5, 1.1 + 0.28 * len(found))
    panels: list[Axes] = list(figure.subplots(1, len(MEASURES), sharey=True))
    titles = [*found]
    for axes, measure in zip(panels, MEASURES.values(), strict=True):
        for row, title in enumerate(titles):
            estimate = found[title][measure.name]
            if estimate is not None:
                axes.hlines(row, estimate.low, estimate.high, color="C0", linewidth=5, alpha=0.35)
                axes.plot([estimate.value], [row], "|C0", markersize=11, markeredgewidth=2)
        axes.set_title(measure.title, fontsize="medium")
        axes.grid(alpha=0.3)
        axes.set_ylim(len(titles) - 0.5, -0.5)
        axes.margins(x=0.08)
    panels[0].set_yticks(range(len(titles)), titles)
    _save(figure, path)


def draw_profiles(found: Mapping[str, Scores], path: Path) -> None:
    """Part of the runs above each success, a line a setting.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    figure = _figure(8.5, max(4.8, HEIGHT * len(found)))
    axes = figure.subplots()
    thresholds = np.linspace(0.0, 1.0, STEPS)
    for number, (title, scores) in enumerate(found.items()):
        look = _look(number)
        axes.plot(thresholds, performance_profile(scores, thresholds), label=title, **look)
        if len(found) <= FEW:
            low, high = bootstrap_interval(
                lambda drawn: performance_profile(drawn, thresholds), scores, resamples=RESAMPLES
            )
            axes.fill_between(thresholds, low, high, color=look["color"], alpha=0.15, linewidth=0)
    axes.set(xlabel="success τ", ylabel="part of the runs with more than τ", xlim=(0, 1))
    axes.set_ylim(-0.02, 1.02)
    axes.grid(alpha=0.3)
    _legend(axes, len(found))
    _save(figure, path)


def draw_curves(found: Mapping[str, Sequence[Sequence[Sequence[Row]]]], path: Path) -> None:
    """Interquartile mean of the runs over control steps, a line a setting.

    Parameters
    ----------
    found
        Title of a setting -> by problem and run, the rows of its curves.
    path
        Of the picture.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    figure = _figure(4.6 * len(CURVES) + 2.5, max(4.6, HEIGHT * len(found)))
    from matplotlib.ticker import EngFormatter

    panels: list[Axes] = list(figure.subplots(1, len(CURVES)))
    for axes, measure in zip(panels, CURVES, strict=True):
        for number, (title, problems) in enumerate(found.items()):
            steps, scores = _on_one_axis(problems, NAMES.get(measure, measure))
            if scores:
                _band(axes, steps, scores, title, number, bands=len(found) <= FEW)
        axes.set(title=MEASURES[measure].title, xlabel="control steps")
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.grid(alpha=0.3)
        axes.margins(x=0)
    panels[0].set_ylim(-0.02, 1.02)
    for axes in panels[1:]:
        axes.set_ylim(bottom=0)
    _legend(panels[-1], len(found))
    _save(figure, path)


def draw_pareto(found: Found, front: Sequence[str], path: Path) -> None:
    """Time against disagreement with intervals; what lies on the front is joined.

    Parameters
    ----------
    found
        Estimates by setting.
    front
        Titles of those that no other beats, by time.
    path
        Of the picture.

    Raises
    ------
    MissingExtra
        If matplotlib is not installed.
    """
    figure = _figure(9.0, max(5.0, HEIGHT * len(found)))
    axes = figure.subplots()
    ends = []
    for number, (title, estimates) in enumerate(found.items()):
        time, waste = estimates[TIME], estimates[DISAGREEMENT]
        if time is None or waste is None:
            continue
        look = _look(number)
        wide, high = ([time.low, time.high], [waste.low, waste.high])
        axes.plot(wide, [waste.value] * 2, color=look["color"], alpha=0.4)
        axes.plot([time.value] * 2, high, color=look["color"], alpha=0.4)
        success = estimates[SUCCESS]
        said = f"{title} (success {success.value:.2f})" if success is not None else title
        mark = MARKS[number // 10 % len(MARKS)]
        fill = look["color"] if title in front else "none"
        axes.plot([time.value], [waste.value], mark, color=look["color"], mfc=fill, label=said)
        if title in front:
            ends.append((time.value, waste.value))
    if len(ends) > 1:
        axes.plot(*np.transpose(sorted(ends)), color="0.6", linestyle=":", zorder=0)
    axes.set(
        xlabel="time of successful episodes [s]",
        ylabel=MEASURES[DISAGREEMENT].title,
        title="filled: no other setting is better in both",
    )
    axes.grid(alpha=0.3)
    _legend(axes, len(found))
    _save(figure, path)


def _band(
    axes: "Axes", steps: FloatArray, scores: Scores, title: str, number: int, *, bands: bool
) -> None:
    look = _look(number)
    by_step = [np.moveaxis(runs, 0, -1) for runs in scores]  # (step, run)
    axes.plot(steps, interquartile_mean(by_step), label=title, **look)
    if bands:
        ends = [
            bootstrap_interval(
                interquartile_mean, [runs[step] for runs in by_step], resamples=RESAMPLES
            )
            for step in range(len(steps))
        ]
        low, high = np.transpose(ends)
        axes.fill_between(steps, low, high, color=look["color"], alpha=0.15, linewidth=0)


def _on_one_axis(
    problems: Sequence[Sequence[Sequence[Row]]], name: str
) -> tuple[FloatArray, list[FloatArray]]:
    """Steps, and ``(run, step)`` of each problem, up to where the shortest run has come."""
    seen = [
        [
            np.array([(row["steps"], row[name]) for row in rows if name in row])
            for rows in runs
            if any(name in row for row in rows)
        ]
        for runs in problems
    ]
    seen = [runs for runs in seen if runs]
    if not seen:
        return np.empty(0), []
    first = max(rows[0, 0] for runs in seen for rows in runs)
    last = min(rows[-1, 0] for runs in seen for rows in runs)
    steps = np.linspace(first, max(first, last), STEPS)
    return steps, [np.array([np.interp(steps, *rows.T) for rows in runs]) for runs in seen]


def _figure(width: float, height: float) -> "Figure":
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise MissingExtra("the pictures of a report", "train") from error
    return Figure(figsize=(width, height), layout="constrained")


def _look(number: int) -> dict[str, Any]:
    return {"color": f"C{number % 10}", "linestyle": LINES[number // 10 % len(LINES)]}


def _legend(axes: "Axes", count: int) -> None:
    """Beside the panel, where it hides nothing."""
    if axes.get_legend_handles_labels()[0]:
        size = "small" if count <= 20 else "x-small"
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), fontsize=size)


def _save(figure: "Figure", path: Path) -> None:
    with written(path) as part:
        figure.savefig(part, format="png", dpi=DPI, metadata={"Software": None})
