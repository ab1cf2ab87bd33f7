"""Resampling: values at other times than those at which they were recorded."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.differentiation import unwound


def resampled(time: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Values on the straight lines between samples; NaN at times outside them.

    Parameters
    ----------
    time
        ``(T,)``, increasing.
    values
        ``(T, ...)``.
    at
        ``(S,)`` new times.

    Returns
    -------
    ``(S, ...)``; a time that was recorded gives what was recorded, to the last bit.
    """
    flat = values.reshape(len(values), -1)
    made = [np.interp(at, time, column, left=np.nan, right=np.nan) for column in flat.T]
    return np.stack(made, axis=-1).reshape(len(at), *values.shape[1:])


def resampled_orientation(time: FloatArray, orientation: FloatArray, at: FloatArray) -> FloatArray:
    """Orientations between samples, turned evenly from one to the next (slerp).

    Parameters
    ----------
    time, at
        See `resampled`.
    orientation
        ``(T,)`` angles [rad], which may jump by 2π, or unit quaternions ``(T, 4)`` w, x, y, z.

    Returns
    -------
    ``(S,)`` or ``(S, 4)``.
    """
    if orientation.ndim == 1:
        return resampled(time, unwound(orientation), at)
    quaternion = unwound(orientation)
    last = np.clip(np.searchsorted(time, at, side="right"), 1, len(time) - 1)
    before, after = quaternion[last - 1], quaternion[last]
    step = time[last] - time[last - 1]  # 0 at the end, where two rows have the last time
    share = np.where(step > 0, (at - time[last - 1]) / np.where(step > 0, step, 1.0), 1.0)[:, None]
    apart = np.arctan2(
        np.linalg.norm(after - before, axis=-1), np.linalg.norm(after + before, axis=-1)
    )[:, None]
    angle = 2 * apart  # between the two, in the space of quaternions
    small = angle < 1e-9
    size = np.sin(np.where(small, 1.0, angle))
    weights = [np.sin((1 - share) * angle) / size, np.sin(share * angle) / size]
    mixed = np.where(small, 1 - share, weights[0]) * before
    mixed += np.where(small, share, weights[1]) * after
    outside = (at < time[0]) | (at > time[-1])
    mixed[outside] = np.nan
    return mixed
