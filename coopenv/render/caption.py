"""Caption of a rendered picture: time, γ, F_I, T_I, legend, and a load share bar for each agent."""

from collections.abc import Sequence
from math import isfinite

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.render.canvas import Canvas, Pen, arrow, text_width
from coopenv.render.look import APPLIED, CORE, EDGE, GRID, INTERNAL, SHAFT, TEXT, agent_color, ghost
from coopenv.transition import Transition

READOUTS = (  # and a number for which there is to be room
    ("t {:.2f} s", 88.88),
    ("γ {:.2f}", 8.88),
    ("F_I {:.1f} N", 88.8),
    ("T_I {:.1f} N·m", 88.8),
)
LEGEND = ("applied", "internal", "goal")
SPAN = (-0.25, 1.25)  # load shares that a bar shows; it stops there, the number does not


class Caption:
    """Lays the lines out for a width and a number of agents, and fills them in.

    Parameters
    ----------
    left, right, top
        The room there is [px]; how far down it goes, follows: `bottom`.
    num_agents
        Each gets a bar.
    unit
        Width of a line that is just well visible [px].
    """

    def __init__(self, *, left: int, right: int, top: int, num_agents: int, unit: float):
        self._unit, self._size = unit, max(12, round(17 * unit))
        size, room = self._size, right - left
        gap, row = round(14 * unit), round(1.4 * size)
        self._key, self._bar = round(32 * unit), round(60 * unit)
        readouts = [text_width(text.format(widest), size) for text, widest in READOUTS]
        legend = [self._key + text_width(name, size) for name in LEGEND]
        places, rows = _flow(readouts + legend, gap, room)
        readout_places, legend_places = places[: len(readouts)], places[len(readouts) :]
        if rows == 1:
            spare = room - legend_places[-1][0] - legend[-1]  # the legend goes to the right
            legend_places = [(x + spare, 0) for x, _ in legend_places]
        label = text_width("load share", size) + gap // 2
        self._number = text_width("−8.88", size)
        share = round(18 * unit) + self._bar + self._number
        share_places, more = _flow([share] * num_agents, gap, room - label)
        middle = top + round(0.75 * row)
        self._readouts = [(left + x, middle + row * k) for x, k in readout_places]
        self._legend = [(left + x, middle + row * k) for x, k in legend_places]
        self._label = (left, middle + row * rows)
        self._shares = [(left + label + x, middle + row * (rows + k)) for x, k in share_places]
        self._area = (left, top, right, middle + row * (rows + more) - round(0.25 * row))

    @property
    def bottom(self) -> int:
        """Where it ends [px]."""
        return self._area[3]

    def paint(self, canvas: Canvas) -> None:
        """Draw what never changes."""
        unit, length = self._unit, self._key - 7 * self._unit
        with canvas.fine(self._area) as pen:
            for (x, y), name in zip(self._legend, LEGEND, strict=True):
                start, along = np.array([x, y]), np.array([length, 0.0])
                if name == "goal":
                    ghost(pen, _bar(x + 0.1 * length, x + length, y, 0.2 * length), EDGE, unit)
                else:
                    pen.polygon(arrow(start, along, SHAFT * unit), APPLIED)
                if name == "internal":
                    pen.polygon(arrow(start, along, CORE * unit), INTERNAL)
                pen.text(x + self._key, y, name, self._size, TEXT)
            pen.text(*self._label, "load share", self._size, TEXT)
            for agent, (x, y) in enumerate(self._shares):
                pen.disc((x + 4.5 * unit, y), 4.5 * unit, agent_color(agent))
                pen.polygon(_bar(self._at(x, 0.0), self._at(x, 1.0), y, 3.5 * unit), GRID)

    def write(self, canvas: Canvas, transition: Transition, world: int) -> None:
        """Fill in one world's numbers."""
        decomposition = transition.decomposition
        values = (
            transition.next_state.time,
            decomposition.relative_cost,
            decomposition.internal_force_level,
            decomposition.internal_torque_level,
        )
        for (x, y), (text, _), value in zip(self._readouts, READOUTS, values, strict=True):
            line = text.format(value[world])
            end = x + text_width(line, self._size) + 1
            with canvas.fine((x, y - 0.7 * self._size, end, y + 0.7 * self._size)) as pen:
                pen.text(x, y, line, self._size, TEXT)
        shares = transition.load_share.force[world]
        for agent, (x, y) in enumerate(self._shares):
            start, end = self._at(x, SPAN[0]), self._at(x, SPAN[1]) + 6 * self._unit + self._number
            with canvas.fine((start, y - 0.7 * self._size, end, y + 0.7 * self._size)) as pen:
                self._write_share(pen, agent, x, y, shares[agent])

    def _write_share(self, pen: Pen, agent: int, x: float, y: float, share: float) -> None:
        unit, defined = self._unit, isfinite(share)
        if defined:
            pen.polygon(
                _bar(self._at(x, 0.0), self._at(x, share), y, 3.5 * unit), agent_color(agent)
            )
        for tick in (self._at(x, 0.0), self._at(x, 1.0)):
            pen.polygon(_bar(tick - unit / 2, tick + unit / 2, y, 5 * unit), TEXT)
        text = f"{share:.2f}".replace("-", "−") if defined else "–"
        pen.text(self._at(x, SPAN[1]) + 4 * unit, y, text, self._size, TEXT)

    def _at(self, x: float, share: float) -> float:
        """Where a load share lies in the bar of the agent whose entry starts at ``x``."""
        low, high = SPAN
        part = (min(max(share, low), high) - low) / (high - low)
        return x + 12 * self._unit + self._bar * part


def _flow(widths: Sequence[int], gap: int, room: int) -> tuple[list[tuple[int, int]], int]:
    """Set items of the given widths in rows: ``(x, row)`` of each, and how many rows there are."""
    places, x, row = [], 0, 0
    for width in widths:
        if x and x + width > room:
            x, row = 0, row + 1
        places.append((x, row))
        x += width + gap
    return places, row + 1


def _bar(left: float, right: float, y: float, half: float) -> FloatArray:
    return np.array([(left, y - half), (right, y - half), (right, y + half), (left, y + half)])
