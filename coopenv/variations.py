"""Draws bodies and teams' limits from declared ranges, prepared once for what they vary."""

from collections.abc import Sequence
from math import exp, log
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.physics.body import Body, Points, copied, second_moments
from coopenv.randomisation import Range, Ranges

_FIELDS = ("mass", "inertia", "linear_drag", "angular_drag", "friction")
_LIMITS = ("force_limit", "torque_limit")


class Variations:
    """What `Ranges` make of one body and its team.

    Parameters
    ----------
    ranges
        From which is drawn.
    body
        What is varied.
    limits
        ``(agent, 2)``: force [N] and torque [N·m] an action of 1 stands for where nothing else is
        drawn.

    Attributes
    ----------
    count
        How many numbers in [0, 1] make one variation.
    """

    def __init__(self, ranges: Ranges, body: Body, limits: FloatArray):
        self._body, self._limits = body, limits
        agents = range(body.num_agents)
        single = [name for name in (*_FIELDS, "length") if getattr(ranges, name) is not None]
        plan: list[tuple[str, int, Range]] = [(name, 0, getattr(ranges, name)) for name in single]
        if ranges.grips is not None:
            plan += [("grips", i, ends) for i in agents for ends in ranges.grips]
        for name in _LIMITS:
            ends = getattr(ranges, name)
            plan += [(name, i, ends) for i in agents if ends is not None]
        self.count = len(plan)
        self._single, self._moves_grips = single, ranges.grips is not None
        self._columns = [column for column, name in enumerate(_LIMITS) if getattr(ranges, name)]
        self._ends = [ends for *_, ends in plan]
        self._logs = [
            (log(ends[0]), log(ends[1])) if name in ranges.logarithmic else None
            for name, _, ends in plan
        ]
        self._moments = second_moments(body.outline)

    def __call__(self, fractions: Sequence[float]) -> tuple[Body, FloatArray]:
        """The body and the limits ``(agent, 2)`` that `count` numbers in [0, 1] stand for."""
        numbers = [
            _between(ends, fraction, logs)
            for ends, fraction, logs in zip(self._ends, fractions, self._logs, strict=True)
        ]
        values: dict[str, Any] = dict(zip(self._single, numbers, strict=False))
        rest, num_agents = numbers[len(self._single) :], self._body.num_agents
        self._stretch(values)
        if self._moves_grips:
            grips: Points = values.get("grips", self._body.grips)
            values["grips"] = tuple(
                (x + rest[2 * i], y + rest[2 * i + 1]) if x or y else (x, y)
                for i, (x, y) in enumerate(grips)
            )
            rest = rest[2 * num_agents :]
        limits = self._limits.copy()
        for number, column in enumerate(self._columns):
            limits[:, column] = rest[number * num_agents : (number + 1) * num_agents]
        return copied(self._body, values), limits

    def extremes(self) -> tuple[Body, Body]:
        """The body with everything at its lowest, and with everything at its highest."""
        return self([0.0] * self.count)[0], self([1.0] * self.count)[0]

    def samples(self) -> list[Body]:
        """Bodies from the ends and the inside of the ranges, without a generator."""
        golden = (np.arange(1, self.count + 1) * 0.618 % 1).tolist()  # on no simple pattern
        return [*self.extremes(), self(golden)[0]]

    def _stretch(self, values: dict[str, Any]) -> None:
        """Put outline, grips and inertia that go with the drawn length and mass into ``values``."""
        body, along, across = self._body, *self._moments
        stretch = 1.0
        if "length" in values:
            stretch = values.pop("length") / body.length
            values["outline"] = tuple((stretch * x, y) for x, y in body.outline)
            values["grips"] = tuple((stretch * x, y) for x, y in body.grips)
        if "inertia" not in values and values.keys() & {"mass", "outline"}:
            grown = (stretch * stretch * along + across) / (along + across)
            heavier = values.get("mass", body.mass) / body.mass
            values["inertia"] = (body.inertia or 0.0) * heavier * grown


def _between(ends: Range, fraction: float, logs: Range | None) -> float:
    low, high = ends
    if logs is None:
        return min(low + fraction * (high - low), high)
    return min(max(exp(logs[0] + fraction * (logs[1] - logs[0])), low), high)
