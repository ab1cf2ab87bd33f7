"""Time series in panels, with a cursor that runs over them: what is past is bright."""

from collections.abc import Iterator, Sequence
from math import ceil, floor, isfinite, log10
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.render.canvas import Canvas, Color, Pen, Picture, text_width
from coopenv.render.caption import SPAN
from coopenv.render.look import EDGE, FLOOR, GRID, INTERNAL, PAGE, TEXT, agent_color

LEAST_PANEL = 62  # [unit] height that still shows a curve
MOST_STEPS = 6  # between numbers of the time axis


class Panel(NamedTuple):
    """Curves that share their axes."""

    label: str
    curves: FloatArray  # (curve, T); NaN leaves gaps
    colors: tuple[Color, ...]
    span: tuple[float, float] | None = None  # that is shown; what lies beyond it is cut off


def measure_panels(
    relative_cost: FloatArray,
    internal_force_level: FloatArray,
    internal_torque_level: FloatArray,
    force_load_share: FloatArray,
    torque_load_share: FloatArray,
) -> list[Panel]:
    """Panels of γ, F_I, T_I ``(T,)`` and load shares ``(T, n)``, in the colours of the pictures."""
    colors = tuple(agent_color(agent) for agent in range(force_load_share.shape[1]))
    return [
        Panel("γ", relative_cost[None], (INTERNAL,), (0.0, 1.0)),
        Panel("F_I [N]", internal_force_level[None], (INTERNAL,)),
        Panel("T_I [N·m]", internal_torque_level[None], (INTERNAL,)),
        Panel("force load share", force_load_share.T, colors, SPAN),
        Panel("torque load share", torque_load_share.T, colors, SPAN),
    ]


class Series:
    """Pictures of the same panels at one row after another.

    Parameters
    ----------
    time
        ``(T,)`` [s], increasing.
    panels
        Top down; every curve has ``T`` values.
    width, height
        Of the picture [px]; it is higher where that is too low for the panels.
    unit
        Width of a line that is just well visible [px].

    Raises
    ------
    InvalidInput
        If there are no rows, or a curve has another number of them.
    """

    def __init__(
        self, time: FloatArray, panels: Sequence[Panel], *, width: int, height: int, unit: float
    ):
        for panel in panels:
            if panel.curves.shape[1] != len(time) or not len(time):
                raise InvalidInput(
                    f"curves must have a value for each time, at least one, got "
                    f"{panel.curves.shape[1]} for {len(time)}; give both of the same rows"
                )
        self._time, self._panels, self._unit = time, panels, unit
        self._size = max(11, round(15 * unit))
        row, edge = round(1.4 * self._size), round(12 * unit)
        foot = row + edge  # numbers of the time axis
        each = max((height - foot - edge // 2) // len(panels), row + round(LEAST_PANEL * unit))
        height = max(height, each * len(panels) + foot + edge // 2)
        left = edge + text_width("−0.25", self._size) + round(4 * unit)
        self._left, self._right = left, width - edge
        self._tops = [edge // 2 + each * k + row for k in range(len(panels))]
        self._bottoms = [top + each - row - round(6 * unit) for top in self._tops]
        self._row = row
        self._spans = [panel.span or _span_of(panel.curves) for panel in panels]
        self._canvas = Canvas(width, height + height % 2)
        self._pale, self._bright = self._paint(0.3), self._paint(1.0)

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of a picture [px]."""
        height, width, _ = self._canvas.pixels.shape
        return height, width

    def picture(self, row: int) -> Picture:
        """With the cursor at a row, ``(height, width, 3)`` uint8."""
        canvas, unit = self._canvas, self._unit
        x = float(self._across(self._time[row : row + 1])[0])
        edge = min(max(round(x), self._left), self._right)
        canvas.pixels[:] = self._pale
        canvas.pixels[:, :edge] = self._bright[:, :edge]
        for k, panel in enumerate(self._panels):
            top, bottom = self._tops[k], self._bottoms[k]
            canvas.fill((edge, top, edge + max(unit, 1), bottom), EDGE)
            values = panel.curves[:, row]
            with canvas.fine((0, top - self._row, self._right + 1, bottom)) as pen:
                self._write(pen, k, values)
            with canvas.fine((edge - 5 * unit, top, edge + 6 * unit, bottom)) as pen:
                for value, color in zip(values, panel.colors, strict=True):
                    if isfinite(value):
                        pen.disc((x, self._up(k, value)), 3.4 * unit, color)
        return canvas.pixels.copy()

    def _paint(self, strength: float) -> Picture:
        """Everything but the cursor, curves as strong as that."""
        canvas, unit = self._canvas, self._unit
        height, width, _ = canvas.pixels.shape
        canvas.fill((0, 0, width, height), PAGE)
        first, last = float(self._time[0]), float(self._time[-1])
        ticks = round_numbers(0.0, last - first, MOST_STEPS)
        places = self._across(np.array(ticks) + first)
        for k, panel in enumerate(self._panels):
            top, bottom = self._tops[k], self._bottoms[k]
            canvas.fill((self._left, top, self._right, bottom), FLOOR)
            for x in places:
                canvas.fill((x, top, x + max(unit, 1), bottom), GRID)
            for level in self._levels(k):
                y = self._up(k, level)
                canvas.fill((self._left, y, self._right, y + max(unit, 1)), GRID)
            with canvas.fine((self._left, top, self._right, bottom)) as pen:
                for values, color in zip(panel.curves, panel.colors, strict=True):
                    faint = _mixed(color, FLOOR, strength)
                    for line in self._lines(k, values):
                        pen.line(line, 1.6 * unit, faint)
            with canvas.fine((0, top - self._row, self._right, bottom + self._size)) as pen:
                pen.text(self._left, top - 0.5 * self._row, panel.label, self._size, TEXT)
                for level in self._levels(k):
                    self._number(pen, self._left - 4 * unit, self._up(k, level), level)
        y = self._bottoms[-1] + 0.75 * self._row
        with canvas.fine((0, y - self._row, width, height)) as pen:
            for tick, x in zip(ticks, places, strict=True):
                text = _text(tick) + (" s" if tick == ticks[-1] else "")
                half = text_width(text, self._size) / 2
                pen.text(min(x - half, width - 2 * half - 2), y, text, self._size, TEXT)
        return canvas.pixels.copy()

    def _write(self, pen: Pen, k: int, values: FloatArray) -> None:
        """The numbers at the cursor, at the right of a panel's title."""
        x = float(self._right)
        for value, color in [*zip(values, self._panels[k].colors, strict=True)][::-1]:
            text = f"{value:.2f}".replace("-", "−") if isfinite(value) else "–"
            x -= text_width(text, self._size)
            if x < self._left + text_width(self._panels[k].label, self._size) + 20 * self._unit:
                return  # no room for more; their curves are there
            y = self._tops[k] - 0.5 * self._row
            pen.text(x, y, text, self._size, TEXT)
            if len(values) > 1:
                x -= 8 * self._unit
                pen.disc((x, y), 3.4 * self._unit, color)
            x -= 12 * self._unit

    def _number(self, pen: Pen, right: float, y: float, value: float) -> None:
        text = _text(value)
        pen.text(right - text_width(text, self._size), y, text, self._size, TEXT)

    def _levels(self, k: int) -> tuple[float, ...]:
        """Values at which a panel has a line and a number: 0, and 1 or the largest."""
        low, high = self._spans[k]
        return (0.0, 1.0) if low < 0 or high == 1.0 else (0.0, high)

    def _across(self, time: FloatArray) -> FloatArray:
        first, last = self._time[0], self._time[-1]
        part = (time - first) / (last - first) if last > first else np.zeros_like(time)
        return self._left + part * (self._right - self._left)

    def _up(self, k: int, value: float) -> float:
        return float(self._heights(k, np.array([value]))[0])

    def _heights(self, k: int, values: FloatArray) -> FloatArray:
        """Where values lie; far beyond the panel they count as one panel's height away."""
        (low, high), top, bottom = self._spans[k], self._tops[k], self._bottoms[k]
        rise = np.clip((values - low) / (high - low), -1.0, 2.0)
        return bottom - 1.5 * self._unit - rise * (bottom - top - 3 * self._unit)

    def _lines(self, k: int, values: FloatArray) -> Iterator[FloatArray]:
        """A curve ``(v, 2)`` [px] for each run of finite values, thinned to what shows."""
        x, y = self._across(self._time), self._heights(k, values)
        for first, last in _runs(np.isfinite(values)):
            rows = _extremes(x[first:last], y[first:last])
            yield np.stack([x[first:last][rows], y[first:last][rows]], axis=-1)


def _runs(marks: FloatArray) -> list[tuple[int, int]]:
    """First and one past the last of each run of marks."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], marks.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in zip(ends[::2], ends[1::2], strict=True)]


def _extremes(x: FloatArray, y: FloatArray) -> IntArray:
    """Rows that show: the first, last, lowest and highest of each pixel."""
    starts = np.flatnonzero(np.diff(np.floor(x), prepend=-np.inf))
    if len(x) <= 4 * len(starts):
        return np.arange(len(x))
    kept: set[int] = set()
    for a, b in zip(starts, [*starts[1:], len(x)], strict=True):
        kept |= {int(a), int(b) - 1, int(a + y[a:b].argmin()), int(a + y[a:b].argmax())}
    return np.array(sorted(kept))


def _span_of(curves: FloatArray) -> tuple[float, float]:
    """From 0 to the next of 1, 2, 5, 10, … above the largest."""
    finite = curves[np.isfinite(curves)]
    largest = float(finite.max()) if finite.size else 0.0
    if largest < 1e-6:
        return 0.0, 1.0
    power = 10.0 ** floor(log10(largest))
    return 0.0, next(n * power for n in (1, 2, 5, 10) if n * power >= largest * (1 - 1e-9))


def round_numbers(low: float, high: float, most: int) -> list[float]:
    """Round numbers from ``low`` to ``high``, at most that many steps."""
    if high <= low:
        return [low]
    raw = (high - low) / most
    power = 10.0 ** floor(log10(raw))
    step = next(n * power for n in (1, 2, 5, 10) if n * power >= raw * (1 - 1e-9))
    return [step * n for n in range(ceil(low / step), floor(high / step + 1e-9) + 1)]


def _text(value: float) -> str:
    return f"{value:.4g}".replace("-", "−")


def _mixed(color: Color, other: Color, strength: float) -> Color:
    red, green, blue = (
        round(strength * c + (1 - strength) * o) for c, o in zip(color, other, strict=True)
    )
    return red, green, blue
