"""Prioritised torque through torque compensation (pTtTC), of two planar effectors on an axis.

Forces compensate as much torque as they can, then as little force as possible is spent: the limit
w → 1 of the optimal decomposition at s = 0. g = (u, v) is the internal force on effector 1 in the
frame of the line, as in `on_axis`. The torque left to pure torques, T(v) = T(0) + (a_1 − a_2) v, is
linear, so its least magnitude on the interval of plausible v is at a known point. Where the grips
coincide it does not depend on v, and the cheapest force is the point mass answer (eqs. 22-23),
clipped to the interval because the cost is convex.

Source: Donner, Endo & Buss 2018, section III-D. Deviation: coinciding grips.
"""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import gufunc
from coopenv.errors import InvalidInput
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.pair import on_axis
from coopenv.wrench.pair.lens import (
    FIRST,
    SECOND,
    heights_on_axis,
    heron_in_lens,
    in_frame,
    remainder,
    vertex,
    write,
)
from coopenv.wrench.settings import Settings


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Check the grips and return the closed form; the cost's weights do not matter to it.

    Parameters
    ----------
    grips
        ``(..., 2, 2)`` on one line through the centre of mass, either possibly at it [m].
    settings
        Unused.

    Raises
    ------
    InvalidInput
        If the grips are not two, not planar, or not on a line through the centre of mass.
    """
    if grips.shape[-2:] != (2, 2) or not on_axis.applies(grips).all():
        raise InvalidInput(
            "grips must be two planar positions on one line through the centre of mass for "
            f"method='prioritized_torque', got {np.array2string(grips, threshold=8)}; use "
            "method='optimal' with a torque_weight close to 1"
        )
    axis = on_axis.frame(grips)

    def solve(applied: FloatArray) -> Answer:
        return Answer(prioritize_torque(applied, axis))

    return Prepared("closed_form", solve)


@gufunc("(n,k),(a)->(n,k)", "void(float64[:,:], float64[:], float64[:,:])")
def prioritize_torque(applied, axis, manipulation):
    """Write the manipulation wrench of one sample; ``axis`` is what `on_axis.frame` says."""
    forces, torques, scale = in_frame(applied, axis)
    f1x, f1y, f2x, f2y = forces
    a1, a2 = axis[FIRST], axis[SECOND]
    lever, torque = a1 - a2, torques[0] + torques[1]
    low, high = heights_on_axis(forces, torques, a1, a2)
    if lever == 0.0:  # the point mass answer: for f_o = 0 all of the force is internal
        resultant = (f1x + f2x) * (f1x + f2x) + (f1y + f2y) * (f1y + f2y)
        v = vertex(forces) if resultant > 0.0 else f1y
        v = min(max(v, min(f1y, -f2y)), max(f1y, -f2y))
    else:
        v = -torque / lever
    v = min(max(v, low), high)
    left = remainder(torque, lever * v)
    write(applied, axis, heron_in_lens(v, forces), v, torques, left, scale, manipulation)
