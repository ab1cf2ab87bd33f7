"""Synthesis without internal wrench in closed form: forces along the resultant.

f_i = α_f,i f_o: parallel forces leave nothing to compensate. The torque that remains for pure
torques is T = t_o − Σ r_i × f_i, and t_i = β_i T with β_i ≥ 0 leaves nothing either. The torque
shares say what part of T each must supply:

    β_i = (c_i − (r_i × f_i)·t_o/‖t_o‖) / (T·t_o/‖t_o‖),  c_i = κ α_t,i ‖t_o‖

where κ = 1, unless effectors of share 0 turn against t_o, c_i < 0, and the others make up for it.
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
    supply = _contributions(asked, share * lever, length[..., 0]) - share * lever
    total = supply.sum(axis=-1, keepdims=True)
    size = np.abs(supply).sum(axis=-1, keepdims=True) + np.abs(share * lever).sum(-1, keepdims=True)
    nothing = np.abs(total) <= ROUNDING * size
    part = np.where(nothing, 1.0 / grips.shape[-2], supply / np.where(nothing, 1.0, total))
    part = np.where(np.isnan(torque_share), 1.0 / grips.shape[-2], part)
    applied[..., dimension:] = part[..., None] * left[:, None]
    blocked = (part < -ROUNDING) | (nothing & (np.abs(supply) > ROUNDING * size))
    applied[blocked.any(axis=-1)] = np.nan
    return applied


def _contributions(asked: FloatArray, induced: FloatArray, torque: FloatArray) -> FloatArray:
    """What each effector supplies along t_o, c_i ``(batch, n)`` [N·m]; of sum ‖t_o‖.

    What is left for pure torques, c_i − induced_i, is to have the same sign everywhere.
    """
    none = asked <= 0.0  # False where open
    against = np.where(none, np.maximum(-induced, 0.0), 0.0)
    room = against.sum(axis=-1, keepdims=True)
    needed = np.where(asked > 0.0, induced / np.where(asked > 0.0, asked, 1.0), 1.0)
    scale = np.where(room > 0, np.maximum(needed.max(axis=-1, keepdims=True), 1.0), 1.0)
    excess = (scale - 1.0) * torque / np.where(room > 0, room, 1.0)
    same = np.where(none, -against * excess, scale * asked)  # T along t_o
    scale = 1.0 + room / np.where(torque > 0, torque, 1.0)
    other = np.where(none, -against, scale * asked)  # T against t_o
    return np.where(torque >= induced.sum(axis=-1, keepdims=True), same, other)


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
