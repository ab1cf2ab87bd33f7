"""The object that is carried: what it weighs, how it drags, where it is held."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from coopenv.arrays import FloatArray, finite_array, positive
from coopenv.errors import InvalidInput

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

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "mass", positive(self.mass, "body.mass", unit="kg"))
        for name, unit in (("linear_drag", "N·s/m"), ("angular_drag", "N·m·s"), ("friction", "")):
            value = positive(getattr(self, name), f"body.{name}", unit=unit, or_zero=True)
            _set(self, name, value)
        _set(self, "outline", _points(self.outline, "body.outline", at_least=3))
        _set(self, "grips", _points(self.grips, "body.grips", at_least=1))
        second_moment = _second_moment(np.array(self.outline))  # [m²] per unit mass
        inertia = self.mass * second_moment if self.inertia is None else self.inertia
        _set(self, "inertia", positive(inertia, "body.inertia", unit="kg·m²"))
        if not isinstance(self.nonholonomic, bool | np.bool_):
            raise InvalidInput(
                f"body.nonholonomic must be True or False, got {self.nonholonomic!r}; "
                "True puts it on wheels"
            )
        _set(self, "nonholonomic", bool(self.nonholonomic))

    @classmethod
    def beam(cls, *, length: float = 2.0, width: float = 0.1, **values) -> Self:
        """A rectangular beam of the given size [m], held 5 % of its length inside its ends.

        ``values`` are the other fields of `Body`; ``grips`` among them overrides the ends.
        """
        half = positive(length, "body.length", unit="m") / 2
        side = positive(width, "body.width", unit="m") / 2
        outline = ((-half, -side), (half, -side), (half, side), (-half, side))
        grips = values.pop("grips", ((-0.9 * half, 0.0), (0.9 * half, 0.0)))
        return cls(outline=outline, grips=grips, **values)

    @classmethod
    def walker(cls, **values) -> Self:
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

    @property
    def num_agents(self) -> int:
        """Number of effectors."""
        return len(self.grips)

    @property
    def reach(self) -> float:
        """Distance of the outline's farthest point from the centre of mass [m]."""
        return float(np.linalg.norm(self.outline, axis=-1).max())


def _points(value: object, name: str, *, at_least: int) -> Points:
    array = finite_array(value, name)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) < at_least:
        raise InvalidInput(
            f"{name} must be at least {at_least} points (x, y), got shape {array.shape}; "
            "pass ((x, y), (x, y), ...) in metres"
        )
    return tuple((float(x), float(y)) for x, y in array)


def _second_moment(outline: FloatArray) -> float:
    """Second moment of area about the origin over the area, for a convex outline [m²]."""
    following = np.roll(outline, -1, axis=0)
    doubled = outline[:, 0] * following[:, 1] - outline[:, 1] * following[:, 0]  # triangle areas ×2
    if not ((doubled > 0).all() or (doubled < 0).all()) or not _is_convex(outline):
        raise InvalidInput(
            f"body.outline must be a convex polygon around the centre of mass (0, 0), got "
            f"{outline.tolist()}; list its vertices in order and shift it onto the centre of mass"
        )
    squares = (outline**2 + outline * following + following**2).sum(axis=1)
    return float((doubled * squares).sum() / doubled.sum() / 6)


def _is_convex(outline: FloatArray) -> bool:
    edges = np.roll(outline, -1, axis=0) - outline
    following = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
    along = (edges * following).sum(axis=1)
    once = abs(np.arctan2(turns, along).sum()) < 3 * np.pi  # a star turns twice or more
    return bool(once and ((turns >= 0).all() or (turns <= 0).all()))
