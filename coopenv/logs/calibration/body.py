"""The object itself, where it is known: mass, inertia, drag, gravity; ``[body]`` of a layout."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, positive
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.load import checked_inertia
from coopenv.logs.calibration.stated import LARGEST, vector

STANDARD = 9.80665  # [m/s²]


@dataclass(frozen=True, slots=True, kw_only=True)
class Body:
    """What the recorded motion is compared with; in SI units, whatever the file has."""

    mass: float | None = None  # [kg]
    inertia: Any = None  # about the centre of mass: J, in space (3,) or (3, 3), object axes [kg m²]
    drag: tuple[float, ...] = (0.0, 0.0)  # of translation [N s/m] and rotation [N m s]
    gravity: tuple[float, ...] | None = None  # world frame [m/s²]; see `pull`

    def checked(self, key: str) -> "Body":
        """With every field checked; ``key`` names it in errors."""
        mass, inertia, gravity = self.mass, self.inertia, self.gravity
        if mass is not None:
            mass = positive(mass, f"{key}.mass", unit="kg", at_least=1e-9, at_most=LARGEST)
        if inertia is not None:
            inertia = checked_inertia(inertia, f"{key}.inertia")
        if (mass is None) != (inertia is None):
            raise InvalidInput(
                f"{key} must have both mass and inertia or none of them, got one; add the other to "
                f"[{key}] of the layout, or say --mass and --inertia"
            )
        if gravity is not None:
            gravity = vector(gravity, f"{key}.gravity")
        drag = vector(self.drag, f"{key}.drag", (2,))
        if min(drag) < 0:
            raise InvalidInput(f"{key}.drag must not be negative, got {self.drag!r}; correct it")
        return Body(mass=mass, inertia=inertia, drag=drag, gravity=gravity)

    def pull(self, dimension: int, key: str = "body") -> FloatArray:
        """Gravity ``(d,)`` [m/s²]; by default none in the plane, along −z in space."""
        if self.gravity is None:
            return np.zeros(2) if dimension == 2 else np.array([0.0, 0.0, -STANDARD])
        if len(self.gravity) != dimension:
            raise InvalidInput(
                f"{key}.gravity must be {dimension} numbers here, got {len(self.gravity)}; "
                "give it in the world frame"
            )
        return np.array(self.gravity)

    def inertia_matrix(self, dimension: int, key: str = "body") -> FloatArray:
        """J ``(3, 3)`` [kg m²]; in the plane about z alone."""
        return spatial_inertia(self.inertia, dimension, f"{key}.inertia")


def spatial_inertia(value: Any, dimension: int, key: str) -> FloatArray:
    """A checked inertia as a matrix ``(3, 3)``.

    Raises
    ------
    InvalidInput
        If it is a number in space, or a matrix in the plane.
    """
    if isinstance(value, float) != (dimension == 2):
        rule = "a number in the plane" if dimension == 2 else "3 numbers or 3 by 3 in space"
        raise InvalidInput(f"{key} must be {rule}, got {value!r}; change it")
    return np.diag([0.0, 0.0, value]) if dimension == 2 else np.array(value)
