"""Domain randomisation: what of the body and the team every episode draws anew."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import product
from typing import Any, TypeAlias

import numpy as np

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput, UnknownName
from coopenv.physics.body import Body

Range: TypeAlias = tuple[float, float]  # lowest and highest; both may be the same

_RIM = 1e-9  # [m²] edge by distance that counts as on the rim
_MAY_BE_ZERO = ("linear_drag", "angular_drag", "friction")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ranges:
    """Ranges (low, high) from which every episode of every world draws, each number on its own.

    Uniform, unless named in ``logarithmic``. What has no range stays as the body or the
    configuration has it; without one of its own, the moment of inertia keeps the body's share of
    what mass and outline make of it.

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
    length: Range | None = None  # [m] of the outline along x, which stretches the grips' x as well
    # [m] added to each grip along x and across; one at the centre of mass, a drive, stays there
    grips: tuple[Range, Range] | None = None
    force_limit: Range | None = None  # [N], each agent its own
    torque_limit: Range | None = None  # [N·m], each agent its own
    logarithmic: tuple[str, ...] = ()  # names of parameters that are drawn log-uniformly

    def __post_init__(self) -> None:
        for entry in fields(self):
            name, value = entry.name, getattr(self, entry.name)
            if value is None or name == "logarithmic":
                continue
            label = f"randomise.{name}"
            given = _grips(value, label) if name == "grips" else _positive(value, label)
            object.__setattr__(self, name, given)
        self._check_logarithmic()

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
            if entry.name not in ("grips", "logarithmic") and getattr(self, entry.name) is not None
        ]
        for name in names:
            if name not in known:
                raise UnknownName("randomise.logarithmic", name, known)
            if getattr(self, name)[0] == 0:
                raise InvalidInput(
                    f"randomise.{name} must begin above zero to be drawn log-uniformly, got "
                    f"{getattr(self, name)}; raise its low end"
                )


def _positive(value: Any, name: str) -> Range:
    low, high = _range(value, name)
    or_zero = name.rpartition(".")[2] in _MAY_BE_ZERO
    if low < 0 or (low == 0 and not or_zero):
        rule = "not begin below zero" if or_zero else "begin above zero"
        raise InvalidInput(f"{name} must {rule}, got {value!r}; raise its low end")
    return low, high


def _grips(value: Any, name: str) -> tuple[Range, Range]:
    if np.shape(value) != (2, 2):
        raise InvalidInput(
            f"{name} must be two ranges, along x and across, got {value!r}; "
            "pass for example ((-0.05, 0.05), (0.0, 0.0)) in metres"
        )
    return _range(value[0], f"{name} along x"), _range(value[1], f"{name} across")


def _range(value: Any, name: str) -> Range:
    ends = finite_array(value, name)
    if ends.shape != (2,):
        raise InvalidInput(f"{name} must be (low, high), got {value!r}; give two numbers")
    low, high = ends.tolist()
    if low > high:
        raise InvalidInput(f"{name} must be (low, high), got {value!r}; swap them")
    return low, high


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
