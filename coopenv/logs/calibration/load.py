"""Load of a sensor: weight and inertia of what hangs between it and the hand, or the object."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, positive, stated_array
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.stated import LARGEST, choice, vector_or_nothing
from coopenv.wrench.grasp import moment

SIDES = ("hand", "object")
MOST_WINDOW = 10.0  # [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Load:
    """What a sensor carries, in SI units and the sensor's axes."""

    mass: float  # [kg]
    center: tuple[float, ...] = ()  # of mass, from the sensor's origin [unit of lengths]; () is 0
    inertia: Any = None  # about its centre of mass: J in the plane, (3, 3) in space [kg m²]
    side: str = "hand"  # it is on: "hand", as a handle; "object", as a gripper
    window: float | None = None  # [s] over which acceleration is found; without it weight alone

    def checked(self, key: str) -> "Load":
        """With every field checked; ``key`` names it in errors."""
        inertia = self.inertia
        if inertia is not None:
            inertia = checked_inertia(inertia, f"{key}.inertia")
        window = self.window
        if window is not None:
            window = positive(window, f"{key}.window", unit="s", at_most=MOST_WINDOW)
        elif inertia is not None:
            raise InvalidInput(
                f"{key}.window must be said where there is an inertia, got none; say over how many "
                "seconds acceleration is found, such as 0.1"
            )
        return Load(
            mass=positive(self.mass, f"{key}.mass", unit="kg", or_zero=True, at_most=LARGEST),
            center=vector_or_nothing(self.center, f"{key}.center"),
            inertia=inertia,
            side=choice(self.side, f"{key}.side", SIDES),
            window=window,
        )


def load_wrench(
    mass: float,
    center: FloatArray,
    pull: FloatArray,
    *,
    inertia: FloatArray | None = None,
    spin: FloatArray | None = None,
    spin_rate: FloatArray | None = None,
) -> FloatArray:
    """Wrench with which a body that is carried along hangs on a sensor, about its origin.

    f = m (g − a),  t = c × f − (J ω̇ + ω × J ω)

    Parameters
    ----------
    mass
        m [kg].
    center
        c, ``(d,)`` from the sensor's origin to the body's centre of mass [m].
    pull
        g − a there, ``(T, d)``: gravity less acceleration [m/s²], in the axes of ``center``.
    inertia, spin, spin_rate
        J, ω, ω̇ in the same axes: in the plane a number and ``(T, 1)``, in space ``(3, 3)`` and
        ``(T, 3)``; none of them where the body's inertia about its centre is nothing.

    Returns
    -------
    ``(T, 3)`` or ``(T, 6)`` [N, N·m]. Where the sensor stands between object and handle, the hand
    gives what the sensor feels **less** this; where it stands between robot and gripper, the object
    gets what the sensor feels **and** this.
    """
    force = mass * pull
    torque = moment(np.broadcast_to(center, force.shape), force)
    if inertia is not None and spin is not None and spin_rate is not None:
        if force.shape[-1] == 2:
            torque = torque - inertia * spin_rate
        else:
            torque = torque - (spin_rate @ inertia.T + np.cross(spin, spin @ inertia.T))
    return np.concatenate([force, torque], axis=-1)


def checked_inertia(value: Any, key: str) -> Any:
    """A number, or a symmetric matrix of three by three that is not negative; three numbers are it.

    Returns
    -------
    A float, or a tuple of rows.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        return positive(value, key, unit="kg m²", or_zero=True, at_most=LARGEST)
    matrix = stated_array(value, key)
    matrix = np.diag(matrix) if matrix.shape == (3,) else matrix
    fits = matrix.shape == (3, 3) and np.abs(matrix).max() <= LARGEST
    fits = fits and np.allclose(matrix, matrix.T, rtol=1e-6, atol=1e-12)
    if not fits or np.linalg.eigvalsh(matrix)[0] < -1e-12:
        raise InvalidInput(
            f"{key} must be a number in the plane, in space three or a symmetric matrix of 3 by 3 "
            f"that is not negative, got {value!r}; give it in kg m²"
        )
    return tuple(map(tuple, matrix.tolist()))
