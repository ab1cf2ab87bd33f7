"""Point mass approximation: share force and torque along the resultants, as if uncoupled."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.grasp import moment
from coopenv.wrench.settings import Settings
from coopenv.wrench.shares import load_share_kernel


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Share the resultants in proportion to each effector's part along them.

    f_M,i = θ max(f_iᵀf_o / ‖f_o‖², 0) f_o    (eqs. 22-23), t_oM,i alike with t_o,i and t_o;
    the effector's own torque is t_M,i = t_oM,i − r_i × f_M,i, so that G h_M = G h.

    Source: Donner, Endo & Buss 2018, section III-C and V. Deviation: a resultant that vanishes
    (1e-9 of its parts) is shared equally.
    """
    dimension = grips.shape[-1]

    def solve(applied: FloatArray) -> Answer:
        at_centre = applied.copy() if grips.ndim == 2 else _broadcast_copy(applied, grips)
        at_centre[..., dimension:] += moment(grips, applied)
        resultant = at_centre.sum(axis=-2, keepdims=True)
        force, torque = load_share_kernel(applied, grips)
        equal = 1.0 / grips.shape[-2]
        manipulation = np.empty_like(at_centre)
        for share, part in ((force, slice(dimension)), (torque, slice(dimension, None))):
            share = np.where(np.isnan(share), equal, share)[..., None]
            manipulation[..., part] = share * resultant[..., part]
        manipulation[..., dimension:] -= moment(grips, manipulation)
        return Answer(manipulation)

    return Prepared("closed_form", solve)


def _broadcast_copy(applied: FloatArray, grips: FloatArray) -> FloatArray:
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    return np.broadcast_to(applied, (*batch, *applied.shape[-2:])).copy()
