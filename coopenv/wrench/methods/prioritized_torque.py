"""pTtTC: let forces compensate as much torque as they can, then spend as little force as possible.

"Prioritised torque through torque compensation" is the limit w → 1 of the optimal decomposition at
s = 0. Two planar effectors on one line through the centre of mass; g = (u, v) is the internal force
on effector 1 in the frame of the line, as in `pair`. The torque left to pure torques, T(v) = T(0) +
(a_1 − a_2) v, is linear, so its least magnitude on the interval of plausible v is at a known point;
where the grips coincide it does not depend on v, and the cheapest force is the point mass answer
(eqs. 22-23), clipped to the interval because the cost is convex.

Source: Donner, Endo & Buss 2018, section III-D. Deviation: coinciding grips.
"""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import gufunc
from coopenv.errors import InvalidInput
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.pair import on_axis as pair
from coopenv.wrench.pair.on_axis_kernel import _best_u, _in_line, _interval, _left, _vertex, _write
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
    if not bool(np.all(pair.applies(grips))):
        raise InvalidInput(
            "grips must be two planar positions on one line through the centre of mass for "
            f"method='prioritized_torque', got {np.array2string(grips, threshold=8)}; use "
            "method='optimal' with a torque_weight close to 1"
        )
    axis = pair._axis(grips)

    def solve(applied: FloatArray) -> Answer:
        return Answer(prioritize_torque(applied, axis))

    return Prepared("closed_form", solve)


@gufunc("(n,k),(a)->(n,k)", "void(float64[:,:], float64[:], float64[:,:])")
def prioritize_torque(applied, axis, manipulation):
    """Write the manipulation wrench of one sample; ``axis`` is direction and levers [m]."""
    forces, torques, scale = _in_line(applied, axis)
    f1x, f1y, f2x, f2y = forces
    t1, t2 = torques
    a1, a2 = axis[2], axis[3]
    lever, torque = a1 - a2, t1 + t2
    low, high = _interval(forces, t1, t2, a1, a2, lever)
    if lever == 0.0:  # the point mass answer: for f_o = 0 all of the force is internal
        resultant = (f1x + f2x) * (f1x + f2x) + (f1y + f2y) * (f1y + f2y)
        v = _vertex(forces) if resultant > 0.0 else f1y
        v = min(max(v, min(f1y, -f2y)), max(f1y, -f2y))
    else:
        v = -torque / lever
    v = min(max(v, low), high)
    left = _left(torque, lever * v)
    _write(applied, axis, _best_u(forces, v), v, torques, left, scale, manipulation)
