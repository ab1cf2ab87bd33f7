"""Domain randomisation: ranges from which every episode draws body, team and gravity."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import product
from math import exp, floor, log
from typing import Any

import numpy as np

from coopenv.arrays import (
    FARTHEST,
    LARGEST,
    FloatArray,
    Range,
    between,
    number_range,
    positive_range,
    whole,
)
from coopenv.errors import InvalidInput, UnknownName
from coopenv.physics.actuators import LONGEST_DELAY
from coopenv.physics.body import LEAST, Body, Points, copied, second_moments
from coopenv.physics.scene import Scene
from coopenv.physics.strengths import columns

_FIELDS = ("mass", "inertia", "linear_drag", "angular_drag", "friction", "ground_friction")
# Columns of a team's strengths that keep their share of one that is drawn.
_SHARES = {"stiffness": "torque_stiffness", "damping": "torque_damping"}
_RIM = 1e-9  # [m²] edge by distance that counts as on the rim
_MAY_BE_ZERO = (
    "linear_drag", "angular_drag", "friction", "ground_friction", "gravity", "damping",
    "time_constant",
)  # fmt: skip
_NO_LOGARITHM = ("grips", "delay", "logarithmic")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranges:
    """Ranges (low, high) from which every episode of every world draws, each number on its own.

    Uniform, unless named in ``logarithmic``. What has no range stays as the body or the
    configuration has it; without one of its own, the moment of inertia keeps the body's share of
    what mass and outline make of it. Torque stiffness and torque damping of hands keep their
    proportion to stiffness and damping.

    Raises
    ------
    InvalidInput
        If a range is the wrong way round, or reaches where its parameter may not.
    UnknownName
        If ``logarithmic`` names what has no range.
    """

    mass: Range | None = None  # [kg]
    inertia: Range | None = None  # [kg·m²]
    linear_drag: Range | None = None  # [N·s/m]
    angular_drag: Range | None = None  # [N·m·s]
    friction: Range | None = None
    ground_friction: Range | None = None  # times `coopenv.Scene.normal_gravity`, which stays
    length: Range | None = None  # [m] of the outline along x, which stretches the grips' x as well
    # [m] added to each grip along x and across; one at the centre of mass, a drive, stays there
    grips: tuple[Range, Range] | None = None
    force_limit: Range | None = None  # [N], each agent its own
    torque_limit: Range | None = None  # [N·m], each agent its own
    stiffness: Range | None = None  # [N/m] of hands, each agent its own
    damping: Range | None = None  # [N·s/m] of hands, each agent its own
    gravity: Range | None = None  # [m/s²] in the plane, along that of the scene
    delay: tuple[int, int] | None = None  # [control steps], whole, each agent its own
    time_constant: Range | None = None  # [s] of actuators, each agent its own
    rate_limit: Range | None = None  # [1/s] of actuators, each agent its own
    logarithmic: tuple[str, ...] = ()  # names of parameters that are drawn log-uniformly

    def __post_init__(self) -> None:
        for entry in fields(self):
            name, value = entry.name, getattr(self, entry.name)
            if value is None or name == "logarithmic":
                continue
            label = f"randomise.{name}"
            if name == "grips":
                given = _grips(value, label)
            elif name == "delay":
                given = _delays(value, label)
            else:
                least = LEAST if name in ("mass", "inertia") else 0.0
                given = positive_range(
                    value,
                    label,
                    or_zero=name in _MAY_BE_ZERO,
                    at_least=least,
                    at_most=FARTHEST if name == "gravity" else LARGEST,
                )
            object.__setattr__(self, name, given)
        self._check_logarithmic()

    def scene(self, scene: Scene, fraction: float) -> Scene:
        """``scene`` with the gravity that a number in [0, 1] stands for; as it is without range.

        Raises `InvalidInput` where there is no gravity in the scene.
        """
        if self.gravity is None:
            return scene
        return scene.with_gravity(_drawn(self.gravity, fraction, self.logs("gravity")))

    def scenes(self, scene: Scene) -> tuple[Scene, ...]:
        """``scene`` with the least and the most gravity; itself alone without a range."""
        if self.gravity is None:
            return (scene,)
        return self.scene(scene, 0.0), self.scene(scene, 1.0)

    def logs(self, name: str) -> Range | None:
        """The logarithms of a range's ends, ``None`` where it is drawn uniformly."""
        ends = getattr(self, name)
        return (log(ends[0]), log(ends[1])) if name in self.logarithmic else None

    def check(self, body: Body) -> None:
        """Raise `InvalidInput` where a grip inside the body might be drawn off it.

        Grips on the rim and off the body are handles, which may be anywhere.
        """
        if self.grips is None:
            return
        held = [grip for grip in body.grips if _holds(body.outline, grip, strictly=True)]
        for length in self.length or (body.length,):
            stretch = length / body.length
            outline = [(stretch * x, y) for x, y in body.outline]
            for x, y in held:
                corners = [(stretch * x + dx, y + dy) for dx, dy in product(*self.grips)]
                if not all(_holds(outline, corner) for corner in corners):
                    raise InvalidInput(
                        f"randomise.grips must keep every grip on the body, got {self.grips} m "
                        f"about the grip at {(stretch * x, y)} m; narrow the ranges"
                    )

    def _check_logarithmic(self) -> None:
        names = self.logarithmic
        if isinstance(names, str) or not isinstance(names, Sequence):
            raise InvalidInput(
                f"randomise.logarithmic must be a sequence of names, got {names!r}; "
                "pass for example ('mass',)"
            )
        object.__setattr__(self, "logarithmic", tuple(names))
        known = [
            entry.name
            for entry in fields(self)
            if entry.name not in _NO_LOGARITHM and getattr(self, entry.name) is not None
        ]
        for name in names:
            if name in _NO_LOGARITHM:
                raise InvalidInput(
                    f"randomise.logarithmic must name what may be drawn log-uniformly, got {name!r}"
                    ", which is drawn uniformly; leave it out"
                )
            if not known:
                raise InvalidInput(
                    f"randomise.logarithmic must name ranges that are given, got {name!r} without "
                    "any; give its range, or leave it out"
                )
            if name not in known:
                raise UnknownName("randomise.logarithmic", name, known)
            if getattr(self, name)[0] == 0:
                raise InvalidInput(
                    f"randomise.{name} must begin above zero to be drawn log-uniformly, got "
                    f"{getattr(self, name)}; raise its low end"
                )


class Variations:
    """What `Ranges` make of one body and its team.

    Parameters
    ----------
    ranges
        From which is drawn.
    body
        What is varied.
    strengths
        ``(agent, column)``, where nothing else is drawn
        (`coopenv.config.TransportConfig.strengths`). Of hands and actuators that are not in it
        nothing is drawn.

    Attributes
    ----------
    count
        How many numbers in [0, 1] make one variation.
    """

    def __init__(self, ranges: Ranges, body: Body, strengths: FloatArray):
        self._body, self._strengths = body, strengths
        agents = range(body.num_agents)
        single = [name for name in (*_FIELDS, "length") if getattr(ranges, name) is not None]
        plan: list[tuple[str, int, Range]] = [(name, 0, getattr(ranges, name)) for name in single]
        if ranges.grips is not None:
            plan += [("grips", i, ends) for i in agents for ends in ranges.grips]
        self._columns = {name: j for j, name in enumerate(columns(strengths.shape[1]))}
        self._drawn = [name for name in self._columns if getattr(ranges, name, None) is not None]
        plan += [(name, i, getattr(ranges, name)) for name in self._drawn for i in agents]
        self.count = len(plan)
        self._single, self._moves_grips = single, ranges.grips is not None
        self._ends = [ends for *_, ends in plan]
        self._whole = [name == "delay" for name, *_ in plan]
        self._logs = [ranges.logs(name) if name != "grips" else None for name, *_ in plan]
        self._moments = second_moments(body.outline)

    def __call__(self, fractions: Sequence[float]) -> tuple[Body, FloatArray]:
        """The body and the strengths ``(agent, …)`` that `count` numbers in [0, 1] stand for."""
        numbers = [
            _steps(ends, fraction) if whole else _drawn(ends, fraction, logs)
            for ends, fraction, logs, whole in zip(
                self._ends, fractions, self._logs, self._whole, strict=True
            )
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
        strengths = self._strengths.copy()
        for number, name in enumerate(self._drawn):
            column = self._columns[name]
            strengths[:, column] = rest[number * num_agents : (number + 1) * num_agents]
            if name in _SHARES:
                strengths[:, self._columns[_SHARES[name]]] *= self._grown(strengths, column)
        return copied(self._body, values), strengths

    def _grown(self, strengths: FloatArray, column: int) -> FloatArray:
        """``(agent,)``: the factor by which a column was drawn larger; 1 where it was zero."""
        own = self._strengths[:, column]
        return np.where(own > 0, strengths[:, column] / np.where(own > 0, own, 1.0), 1.0)

    def ends(self) -> tuple[tuple[Body, FloatArray], tuple[Body, FloatArray]]:
        """Body and strengths with everything at its lowest, and with everything at its highest."""
        return self([0.0] * self.count), self([1.0] * self.count)

    def extremes(self) -> tuple[Body, Body]:
        """The body with everything at its lowest, and with everything at its highest."""
        (lowest, _), (highest, _) = self.ends()
        return lowest, highest

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


def _drawn(ends: Range, fraction: float, logs: Range | None) -> float:
    """The number between ``ends``, or log-uniformly between them where their ``logs`` are given."""
    if logs is None:
        return between(ends, fraction)
    return min(max(exp(logs[0] + fraction * (logs[1] - logs[0])), ends[0]), ends[1])


def _steps(ends: Range, fraction: float) -> float:
    """Any whole number from the low end to the high one, each as often as the others."""
    low, high = ends
    return min(low + floor(fraction * (high - low + 1)), high)


def _delays(value: Any, name: str) -> tuple[int, int]:
    low, high = number_range(value, name)
    most = {"at_least": 0, "at_most": LONGEST_DELAY}
    return whole(low, name, **most), whole(high, name, **most)


def _grips(value: Any, name: str) -> tuple[Range, Range]:
    if np.shape(value) != (2, 2):
        raise InvalidInput(
            f"{name} must be two ranges, along x and across, got {value!r}; "
            "pass for example ((-0.05, 0.05), (0.0, 0.0)) in metres"
        )
    return number_range(value[0], f"{name} along x"), number_range(value[1], f"{name} across")


def _holds(
    outline: Sequence[tuple[float, float]], point: tuple[float, float], *, strictly: bool = False
) -> bool:
    """Whether a convex outline has a point in it or, unless ``strictly``, on its rim."""
    corners: FloatArray = np.array(outline)
    edges = np.roll(corners, -1, axis=0) - corners
    away = np.array(point) - corners
    side = edges[:, 0] * away[:, 1] - edges[:, 1] * away[:, 0]
    least = _RIM if strictly else -_RIM
    return bool((side >= least).all() or (-side >= least).all())
