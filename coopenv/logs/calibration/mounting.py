"""Mounting of a sensor: its wrench in other axes, about another point, without cross-talk."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.wrench.grasp import moment


def turned(wrench: FloatArray, rotation: FloatArray) -> FloatArray:
    """The same wrench in other axes: R f, R t.

    Parameters
    ----------
    wrench
        ``(..., 3)`` planar or ``(..., 6)`` spatial [N, N·m], in the sensor's axes.
    rotation
        ``(2, 2)`` or ``(3, 3)``: its columns are the sensor's axes as the object sees them.

    Returns
    -------
    As ``wrench``, in the object's axes; a planar torque is what it was, or the other way round of a
    sensor that is upside down.
    """
    d = rotation.shape[-1]
    force = wrench[..., :d] @ rotation.T
    torque = wrench[..., d:]
    torque = torque @ rotation.T if d == 3 else torque * np.sign(np.linalg.det(rotation))
    return np.concatenate([force, torque], axis=-1)


def moved(wrench: FloatArray, offset: npt.ArrayLike) -> FloatArray:
    """The same wrench about another point: t − o × f.

    Parameters
    ----------
    wrench
        ``(..., 3)`` or ``(..., 6)`` [N, N·m], about the sensor's origin.
    offset
        o, from there to the point, ``(..., 2)`` or ``(..., 3)`` in the axes of ``wrench`` [m]. Seen
        from the point the sensor is at r = −o, and t + r × f is the same thing.
    """
    offset = np.asarray(offset, dtype=np.float64)
    d = offset.shape[-1]
    torque = wrench[..., d:] - moment(offset, wrench[..., :d])
    return np.concatenate([wrench[..., :d], torque], axis=-1)


def uncoupled(wrench: FloatArray, matrix: FloatArray) -> FloatArray:
    """The wrench C h of a reading h, with a matrix ``(3, 3)`` or ``(6, 6)`` against cross-talk.

    In SI units: rows and columns are forces [N], then torques [N·m].
    """
    return wrench @ matrix.T
