"""Two planar effectors off the axis: the optimum to rounding, by a search on one number.

`pair` is for grips on a line through the centre of mass, this for all others. In the frame whose x
axis runs along r_1 − r_2 let g = (u, v) be the internal force on effector 1, −g that on effector 2.
Plausible are the g in the lens between the discs with diameters [0, f_1] and [0, −f_2] and in two
strips along the levers (induced torques); v alone decides the torque T(v) left to the effectors'
pure torques. At a given v the feasible u are an interval, on which the cost is convex; the sign of
the derivative along the path of the best u says on which side the minimum lies. Closing in on where
it changes is exact to rounding in v, however flat the cost and however thin the set. Where costs
tie the answer is that of `pair`.

Source: Donner, Endo & Buss 2018, eqs. 17-21; the reduction to one dimension is our own.
"""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench import measures
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.cores import on_all_cores
from coopenv.wrench.measure_kernels import level_kernel
from coopenv.wrench.pair.off_axis_kernel import ROUNDING, decompose_off_axis
from coopenv.wrench.settings import Settings

WORTH_A_THREAD = 1000  # samples that occupy a core long enough for one to be started


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., 2, 2)``, none of them on one line through the centre of mass [m].
    settings
        Torque weight and whether induced torque is costed.
    """
    axis = frame(grips)
    weights = np.array([settings.torque_weight, float(settings.include_induced)])
    parameters = measures.level_parameters(*weights, plausible=True)
    worth = ROUNDING * np.abs(axis[..., 2:]).max(axis=-1) / np.abs(axis[..., 4])

    def solve(applied: FloatArray) -> Answer:
        """Manipulation wrenches and gaps.

        The minimum of a convex function is bracketed: the gap is how wide the bracket can be in the
        end times how steep the cost. Near the axis a small change of v changes u a lot along the
        levers.
        """
        if axis.ndim == 1 and applied.ndim == 3:
            manipulation = np.empty(applied.shape)
            on_all_cores(
                lambda part: write(part, manipulation, applied), len(applied), WORTH_A_THREAD
            )
        else:
            manipulation = decompose_off_axis(applied, axis, weights)
        cost = level_kernel(applied, manipulation, grips, parameters)[..., 1]
        return Answer(manipulation, worth * cost)

    def write(part: slice, manipulation: FloatArray, applied: FloatArray) -> None:
        decompose_off_axis(applied[part], axis, weights, manipulation[part])

    return solve


def frame(grips: FloatArray) -> FloatArray:
    """Direction of r_1 − r_2, both grips along it, and their distance from the centre of mass.

    ``(..., 5)`` [1, 1, m, m, m], of grips ``(..., 2, 2)`` not on a line through the centre of mass.
    """
    along = grips[..., 0, :] - grips[..., 1, :]
    c, s = np.moveaxis(along / np.hypot(along[..., 0], along[..., 1])[..., None], -1, 0)
    x, y = grips[..., 0], grips[..., 1]
    levers = c[..., None] * x + s[..., None] * y
    height = c * y[..., 0] - s * x[..., 0]
    return np.stack([c, s, levers[..., 0], levers[..., 1], height], axis=-1)
