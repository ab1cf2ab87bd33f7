"""Wished-for shares of any number of effectors, with nothing internal.

f_i = α_f,i f_o: parallel forces leave nothing to compensate. The torque that remains for pure
torques is T = t_o − Σ r_i × f_i, and t_i = β_i T with β_i ≥ 0 leaves nothing either. The torque
shares say what part of T each must supply:

    β_i = (α_t,i ‖t_o‖ − (r_i × f_i)·t_o/‖t_o‖) / (T·t_o/‖t_o‖)
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.grasp import moment

ROUNDING = 1e-12  # of a torque, relative to the wrench


def find(
    wanted: FloatArray, grips: FloatArray, force_share: FloatArray, torque_share: FloatArray
) -> FloatArray:
    """Applied wrenches ``(batch, n, k)`` with these shares; NaN where forces along f_o won't do.

    Parameters
    ----------
    wanted
        Object wrenches ``(batch, 3)`` or ``(batch, 6)`` [N, N·m].
    grips
        ``(batch, n, 2)`` or ``(batch, n, 3)`` [m].
    force_share, torque_share
        ``(batch, n)``, rows of NaN where open. Open force shares are equal, or as near to it as
        the torque shares allow; open torque shares follow from equal pure torques.
    """
    dimension = grips.shape[-1]
    resultant, torque = wanted[:, None, :dimension], wanted[:, None, dimension:]
    length = np.linalg.norm(torque, axis=-1, keepdims=True)
    direction = torque / np.where(length > 0, length, 1.0)
    lever = (moment(grips, np.broadcast_to(resultant, grips.shape)) * direction).sum(axis=-1)
    asked = torque_share * length[..., 0]  # [N·m] along t_o
    share = np.where(np.isnan(force_share), _free_share(lever, asked), force_share)
    applied = np.zeros((*grips.shape[:-1], wanted.shape[-1]))
    applied[..., :dimension] = share[..., None] * resultant
    left = wanted[:, dimension:] - moment(grips, applied).sum(axis=-2)  # T (batch, 1 or 3)
    supply = asked - share * lever
    total = supply.sum(axis=-1, keepdims=True)
    size = np.abs(supply).sum(axis=-1, keepdims=True) + np.abs(share * lever).sum(-1, keepdims=True)
    nothing = np.abs(total) <= ROUNDING * size
    part = np.where(nothing, 1.0 / grips.shape[-2], supply / np.where(nothing, 1.0, total))
    part = np.where(np.isnan(torque_share), 1.0 / grips.shape[-2], part)
    applied[..., dimension:] = part[..., None] * left[:, None]
    blocked = (part < -ROUNDING) | (nothing & (np.abs(supply) > ROUNDING * size))
    applied[blocked.any(axis=-1)] = np.nan
    return applied


def _free_share(lever: FloatArray, asked: FloatArray) -> FloatArray:
    """Force shares, near to equal, that let each effector's torque α_i lever_i be at most asked.

    Where the caps leave no room the shares are equal, and `find` will say that this won't do.
    """
    num_effectors = lever.shape[-1]
    limited: BoolArray = ~np.isnan(asked) & (lever > 0.0)
    cap = np.where(limited, np.nan_to_num(asked) / np.where(limited, lever, 1.0), np.inf)
    possible = cap.sum(axis=-1, keepdims=True) >= 1.0
    low, high = np.zeros((len(lever), 1)), np.ones((len(lever), 1))
    for _ in range(60):  # shares min(cap, level) that sum to 1
        level = 0.5 * (low + high)
        enough = np.minimum(cap, level).sum(axis=-1, keepdims=True) >= 1.0
        low, high = np.where(enough, low, level), np.where(enough, level, high)
    share = np.minimum(cap, high)
    share /= share.sum(axis=-1, keepdims=True)
    return np.where(possible, share, 1.0 / num_effectors)
