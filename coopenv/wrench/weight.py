"""Where the torque weight of the cost matters: the paper's eq. 24."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import InvalidInput
from coopenv.wrench.grasp import checked_applied, checked_grips, moment

SYMMETRIC = 1e-9  # of the lever: by how much grips may miss the centre of mass in their middle


def weight_matters(
    applied: npt.ArrayLike, grips: npt.ArrayLike, *, include_induced: bool = False
) -> BoolArray:
    """Whether the optimal split of a symmetric planar pair depends on the torque weight w.

    It does for s = 0 exactly where both forces turn the object one way, the pure torque of one
    effector, k, that way too, that of the other, j, against it, and |2 t_fI,max + t_k| > |t_j| with
    t_fI,max the induced torque of smaller magnitude (eq. 24). For s = 1 it never does.

    Parameters
    ----------
    applied
        ``(..., 2, 3)`` [fx, fy, tz], object frame [N, N·m].
    grips
        ``(..., 2, 2)``, r and −r, broadcast against it [m].
    include_induced
        s: whether the cost counts induced torques.

    Returns
    -------
    ``(...)`` bool. Where it is false, one answer is best for all w in ]0, 1[.

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong or the centre of mass is not in the middle of the grips:
        then w may matter elsewhere too, for s = 1 as well.

    Source: Donner, Endo & Buss 2018, eq. 24. Deviations: the sign of t_fI,max is kept and t_j is
    the torque that opposes, as numerical optima at several w ask for.
    """
    grips = checked_grips(grips)
    applied = checked_applied(applied, grips)
    if grips.shape[-2:] != (2, 2):
        raise InvalidInput(
            f"grips must be of shape (..., 2, 2), two in the plane, got {grips.shape}; compare "
            "decompose(..., torque_weight=...) at several weights instead"
        )
    off = np.linalg.norm(grips.sum(axis=-2), axis=-1)
    lever = np.linalg.norm(grips, axis=-1).max(axis=-1)
    if (off > SYMMETRIC * lever).any():
        raise InvalidInput(
            "grips must be r and −r, with the centre of mass in their middle, got "
            f"{grips.tolist()}; compare decompose(..., torque_weight=...) at several weights"
        )
    induced, torque = moment(grips, applied)[..., 0], applied[..., 2]
    if include_induced:
        return np.zeros(np.broadcast_shapes(induced.shape, torque.shape)[:-1], dtype=np.bool_)
    first, second = torque[..., 0], torque[..., 1]
    return _opposes(induced, first, second) | _opposes(induced, second, first)


def _opposes(induced: FloatArray, along: FloatArray, against: FloatArray) -> BoolArray:
    """Eq. 24 with ``along`` as t_k and ``against`` as t_j."""
    first, second = induced[..., 0], induced[..., 1]
    sign = np.sign(first)
    smaller = np.where(np.abs(first) <= np.abs(second), first, second)
    one_way = (sign != 0) & (np.sign(second) == sign) & (np.sign(along) == sign)
    return one_way & (np.sign(against) == -sign) & (np.abs(2 * smaller + along) > np.abs(against))
