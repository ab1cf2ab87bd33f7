"""Twist from pose, and acceleration from twist, by polynomials fitted to some samples around."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import wrapped
from coopenv.logs.calibration.orientation import rotation_matrix

DEGREE = 3  # of the polynomials: velocities and accelerations of jerks that do not change are exact


def derivative(values: FloatArray, rate: float, window: float) -> FloatArray:
    """Derivative of values by time, from cubic polynomials over a window (Savitzky and Golay).

    Parameters
    ----------
    values
        ``(T, ...)``, at equal steps.
    rate
        Of the samples [Hz].
    window
        Over which they are fitted [s]; at least five samples.

    Returns
    -------
    ``(T, ...)``; at the ends, the derivative of the first and of the last polynomial.

    Raises
    ------
    InvalidInput
        If there are fewer than two samples.
    """
    from scipy.signal import savgol_filter

    if len(values) < 2:
        raise InvalidInput(f"values must be at least two, got {len(values)}; record some more")
    count = min(window_rows(rate, window), (len(values) - 1) // 2 * 2 + 1)
    if count < 3:
        return np.gradient(values, 1 / rate, axis=0)
    degree = min(DEGREE, count - 1)
    made = savgol_filter(values, count, degree, deriv=1, delta=1 / rate, axis=0, mode="interp")
    return np.asarray(made)


def window_rows(rate: float, window: float) -> int:
    """How many samples a window has: an odd number, at least five."""
    return max(5, 2 * round(rate * window / 2) + 1)


def twist_from_pose(
    position: FloatArray, orientation: FloatArray, rate: float, window: float
) -> FloatArray:
    """Linear and angular velocity of a pose, in the object frame.

    Parameters
    ----------
    position
        ``(T, 2)`` or ``(T, 3)``, world frame [m], at equal steps.
    orientation
        ``(T,)`` angles [rad], which may jump by 2π, or quaternions ``(T, 4)`` w, x, y, z.
    rate, window
        See `derivative`.

    Returns
    -------
    ``(T, 3)`` or ``(T, 6)`` [m/s, rad/s].
    """
    velocity = derivative(position, rate, window)
    if orientation.ndim == 1:
        spin = derivative(unwound(orientation), rate, window)[:, None]
        c, s = np.cos(orientation), np.sin(orientation)
        own = [c * velocity[:, 0] + s * velocity[:, 1], c * velocity[:, 1] - s * velocity[:, 0]]
        return np.concatenate([np.stack(own, axis=-1), spin], axis=-1)
    quaternion = unwound(orientation)
    rate_of_change = derivative(quaternion, rate, window)
    w, v = quaternion[:, :1], quaternion[:, 1:]
    change, turning = rate_of_change[:, :1], rate_of_change[:, 1:]
    spin = 2 * (w * turning - change * v - np.cross(v, turning))  # 2 q* q̇
    own = np.einsum("tji,tj->ti", rotation_matrix(quaternion), velocity)
    return np.concatenate([own, spin], axis=-1)


def acceleration(twist: FloatArray, rate: float, window: float) -> FloatArray:
    """Acceleration of the centre of mass, and angular acceleration, in the object frame.

    a = dv/dt + ω × v,  α = dω/dt,  all components being those along the object's axes.

    Parameters
    ----------
    twist
        ``(T, 3)`` or ``(T, 6)``, object frame [m/s, rad/s], at equal steps.
    rate, window
        See `derivative`.

    Returns
    -------
    As ``twist`` [m/s², rad/s²].
    """
    made = derivative(twist, rate, window)
    if twist.shape[-1] == 3:
        made[:, 0] -= twist[:, 2] * twist[:, 1]
        made[:, 1] += twist[:, 2] * twist[:, 0]
    else:
        made[:, :3] += np.cross(twist[:, 3:], twist[:, :3])
    return made


def unwound(orientation: FloatArray) -> FloatArray:
    """Angles ``(T,)`` without jumps by 2π, or quaternions ``(T, 4)`` without changes of sign."""
    if orientation.ndim == 1:
        steps = wrapped(np.diff(orientation))
        return orientation[0] + np.concatenate([[0.0], np.cumsum(steps)])
    turned = (orientation[1:] * orientation[:-1]).sum(axis=-1) < 0
    sign = np.concatenate([[1.0], np.cumprod(np.where(turned, -1.0, 1.0))])
    return orientation * sign[:, None]
