"""Body: mass, inertia, drag, outline and grips of the object that is carried."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Any

import numpy as np

from coopenv.arrays import FARTHEST, FloatArray, positive, stated_array
from coopenv.errors import InvalidInput
from coopenv.geometry import rim

LEAST = 1e-15  # of mass [kg] and inertia [kg·m²]

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """A rigid planar object and the grips on it; the default is a 2 m beam of 7.7 kg.

    The object frame has its origin at the centre of mass, x along the beam.

    Parameters
    ----------
    mass
        Mass [kg].
    inertia
        Moment of inertia about the centre of mass [kg·m²]; ``None`` takes that of the outline
        filled with uniform density.
    linear_drag, angular_drag
        Viscous drag against velocity [N·s/m] and angular velocity [N·m·s].
    outline
        Vertices of a convex polygon, object frame [m]; it has to hold the centre of mass.
    grips
        Where each effector holds, object frame [m]; one entry an agent. The default keeps off
        ±1 m, where a lever of exactly one metre makes the split of force and torque ambiguous
        at the default torque weight.
    friction
        Coulomb coefficient of the outline; a contact takes the product with the wall's.
    ground_friction
        Coulomb coefficient of the ground that the body lies on, all of it; see
        `coopenv.physics.friction`. What presses it on is ``Scene.normal_gravity``.
    nonholonomic
        Whether wheels at the centre of mass keep it from moving sideways: it rolls along its x
        and turns. Forces across it then only turn it, by their lever.

    Raises
    ------
    InvalidInput
        If a value breaks its rule.
    """

    mass: float = 7.7  # [kg]
    inertia: float | None = None  # [kg·m²]
    linear_drag: float = 8.0  # [N·s/m]
    angular_drag: float = 8.0  # [N·m·s]
    outline: Points = ((-1.0, -0.05), (1.0, -0.05), (1.0, 0.05), (-1.0, 0.05))  # [m]
    grips: Points = ((-0.9, 0.0), (0.9, 0.0))  # [m]
    friction: float = 0.3
    nonholonomic: bool = False
    ground_friction: float = 0.0

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "mass", positive(self.mass, "body.mass", unit="kg", at_least=LEAST))
        units = {
            "linear_drag": "N·s/m",
            "angular_drag": "N·m·s",
            "friction": "",
            "ground_friction": "",
        }
        for name, unit in units.items():
            value = positive(getattr(self, name), f"body.{name}", unit=unit, or_zero=True)
            _set(self, name, value)
        _set(self, "outline", _points(self.outline, "body.outline", at_least=3))
        _set(self, "grips", _points(self.grips, "body.grips", at_least=1))
        second_moment = _second_moment(np.array(self.outline))  # [m²] per unit mass
        inertia = self.mass * second_moment if self.inertia is None else self.inertia
        inertia = positive(inertia, "body.inertia", unit="kg·m²", at_least=LEAST)
        _set(self, "inertia", inertia)
        if not isinstance(self.nonholonomic, bool | np.bool_):
            raise InvalidInput(
                f"body.nonholonomic must be True or False, got {self.nonholonomic!r}; "
                "True puts it on wheels"
            )
        _set(self, "nonholonomic", bool(self.nonholonomic))
        if self.nonholonomic and self.ground_friction > 0:
            raise InvalidInput(
                f"body.ground_friction must be 0 on wheels, got {self.ground_friction}; wheels "
                "roll on the ground: give body.linear_drag and body.angular_drag instead"
            )

    @classmethod
    def beam(cls, *, length: float = 2.0, width: float = 0.1, **values) -> "Body":
        """A rectangular beam of the given size [m], held 5 % of its length inside its ends.

        ``values`` are the other fields of `Body`; ``grips`` among them overrides the ends.
        """
        half = positive(length, "body.length", unit="m", at_most=FARTHEST) / 2
        side = positive(width, "body.width", unit="m", at_most=FARTHEST) / 2
        outline = ((-half, -side), (half, -side), (half, side), (-half, side))
        grips = values.pop("grips", ((-0.9 * half, 0.0), (0.9 * half, 0.0)))
        return cls(outline=outline, grips=grips, **values)

    @classmethod
    def walker(cls, **values) -> "Body":
        """The paper's mobility-assistance walker: a square metre on wheels.

        25 kg, 4.17 kg·m², drag 1 N·s/m and 100 N·m·s; agent 0, the human, holds it at its rear,
        agent 1 is the drive at the centre of mass. ``values`` are other fields of `Body`.

        Source: Donner, Endo & Buss 2018, section V-A.
        """
        return cls(
            **{
                "mass": 25.0,  # [kg]
                "inertia": 4.17,  # [kg·m²]
                "linear_drag": 1.0,  # [N·s/m]
                "angular_drag": 100.0,  # [N·m·s]
                "outline": ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)),  # [m]
                "grips": ((-0.5, 0.0), (0.0, 0.0)),  # [m]
                "nonholonomic": True,
                **values,
            }
        )

    @classmethod
    def plate(
        cls,
        num_agents: int = 4,
        *,
        radius: float | None = None,
        sides: int = 16,
        size: tuple[float, float] | None = None,
        **values,
    ) -> "Body":
        """A plate that ``num_agents`` hold evenly round its rim, 10 % nearer to the centre than it.

        Parameters
        ----------
        num_agents
            How many; the first holds on the x axis, the others follow counter-clockwise at equal
            lengths of rim.
        radius, sides
            Of a regular polygon [m], 0.75 by default.
        size
            Of a rectangle instead, along x and y [m].
        **values
            The other fields of `Body`; ``grips`` among them overrides those round the rim.
        """
        if size is not None and radius is not None:
            raise InvalidInput(
                f"radius must be left out beside size, got {radius!r} and {size!r}; a plate is a "
                "polygon or a rectangle"
            )
        if size is None:
            outline = rim.polygon(0.75 if radius is None else radius, sides)
        else:
            outline = rim.rectangle(size)
        even = rim.even_grips(outline, num_agents)
        return cls(outline=_tuples(outline), **{"grips": _tuples(even), **values})

    def held_by(self, num_agents: int) -> "Body":
        """The same body, held by ``num_agents`` evenly round its rim, as a plate is."""
        even = rim.even_grips(np.array(self.outline), num_agents)
        return replace(self, grips=_tuples(even))

    @property
    def num_agents(self) -> int:
        """Number of effectors."""
        return len(self.grips)

    @property
    def reach(self) -> float:
        """Distance of the outline's farthest point from the centre of mass [m]."""
        return _reach(self.outline)

    @property
    def length(self) -> float:
        """Extent of the outline along x [m]."""
        return max(x for x, _ in self.outline) - min(x for x, _ in self.outline)


@lru_cache(maxsize=256)
def _reach(outline: Points) -> float:
    return float(np.linalg.norm(outline, axis=-1).max())


def copied(body: Body, values: Mapping[str, Any]) -> Body:
    """A copy with other ``values``, which are not checked; pass only what was checked before."""
    made = object.__new__(type(body))
    for name in _FIELDS:
        object.__setattr__(made, name, values[name] if name in values else getattr(body, name))
    return made


def second_moments(outline: Points) -> tuple[float, float]:
    """Second moments of area of a convex outline over its area, of x² and of y² [m²]."""
    area = along = across = 0.0
    for (x, y), (u, v) in zip(outline, outline[1:] + outline[:1], strict=True):
        doubled = x * v - y * u  # area of the triangle with the origin, ×2
        area += doubled
        along += doubled * (x * x + x * u + u * u)
        across += doubled * (y * y + y * v + v * v)
    return along / area / 6, across / area / 6


_FIELDS = tuple(entry.name for entry in fields(Body))


def _points(value: object, name: str, *, at_least: int) -> Points:
    array = stated_array(value, name)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) < at_least:
        raise InvalidInput(
            f"{name} must be at least {at_least} points (x, y), got shape {array.shape}; "
            "pass ((x, y), (x, y), ...) in metres"
        )
    if (np.abs(array) > FARTHEST).any():
        raise InvalidInput(
            f"{name} must lie within {FARTHEST:g} m, got {array.tolist()}; give metres"
        )
    return _tuples(array)


def _second_moment(outline: FloatArray) -> float:
    """Second moment of area about the origin over the area, for a convex outline [m²]."""
    following = np.roll(outline, -1, axis=0)
    doubled = outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]  # triangle areas ×2
    if not ((doubled > 0).all() or (doubled < 0).all()) or not _is_convex(outline):
        raise InvalidInput(
            f"body.outline must be a convex polygon around the centre of mass (0, 0), got "
            f"{outline.tolist()}; list its vertices in order and shift it onto the centre of mass"
        )
    return sum(second_moments(_tuples(outline)))


def _is_convex(outline: FloatArray) -> bool:
    edges = np.roll(outline, -1, axis=0) - outline
    following = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
    along = (edges * following).sum(axis=1)
    once = abs(np.arctan2(turns, along).sum()) < 3 * np.pi  # a star turns twice or more
    return bool(once and ((turns >= 0).all() or (turns <= 0).all()))


def _tuples(points: FloatArray) -> Points:
    return tuple((float(x), float(y)) for x, y in points)
