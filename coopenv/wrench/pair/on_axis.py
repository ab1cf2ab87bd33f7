"""Two planar effectors on one line through the centre of mass: the optimum to rounding.

Let g = (u, v) be the internal force on effector 1 in the frame of the line, −g that on effector 2.
Plausible are the g in the lens between the discs with diameters [0, f_1] and [0, −f_2]; v alone
decides the induced torques and the torque T(v) left to the effectors' pure torques, and the best u
for a given v is known in closed form. What remains is a convex function of v on an interval that
contains 0. It is cut at its kinks; the derivative at both ends of each piece says whether the
minimum lies on a kink (exact) or inside a piece (root of the derivative).

Where several answers cost the same, the one with the least pure torque Σ‖t_M‖ is taken, and pure
torques of the sign that is needed are shared in proportion to what was applied (as eq. 23 does).
The internal levels F_I and T_I can jump where costs tie, as at ±1 m with w = 0.5 and s = 0, where
torque costs the same through forces and by itself; the cost never does.

Source: Donner, Endo & Buss 2018, eqs. 17-21; the reduction to one dimension is our own.
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.pair.on_axis_kernel import decompose_pair
from coopenv.wrench.settings import Settings

ON_AXIS = 1e-12  # distance from the line that counts as rounding, relative to the longest lever


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., 2, 2)`` for which this `applies` [m].
    settings
        Torque weight and whether induced torque is costed.
    """
    axis = _axis(grips)
    weights = np.array([settings.torque_weight, float(settings.include_induced)])

    def solve(applied: FloatArray) -> Answer:
        return Answer(decompose_pair(applied, axis, weights))

    return solve


def applies(grips: FloatArray) -> BoolArray:
    """Whether each set of grips is two planar positions on a line through the centre of mass."""
    if grips.shape[-2:] != (2, 2):
        return np.zeros(grips.shape[:-2], dtype=np.bool_)
    length = np.hypot(grips[..., 0], grips[..., 1])
    first, second = grips[..., 0, :], grips[..., 1, :]
    area = np.abs(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
    return np.asarray(area <= ON_AXIS * length.max(axis=-1) ** 2)


def _axis(grips: FloatArray) -> FloatArray:
    """Direction of the line (towards the farther grip) and both signed levers ``(..., 4)`` [m]."""
    length = np.hypot(grips[..., 0], grips[..., 1])
    longest = length.max(axis=-1, keepdims=True)
    farther = np.take_along_axis(grips, length.argmax(axis=-1)[..., None, None], axis=-2)
    direction = farther[..., 0, :] / np.where(longest > 0, longest, 1.0)
    direction = np.where(longest > 0, direction, [1.0, 0.0])
    lever = (grips * direction[..., None, :]).sum(axis=-1)
    lever = np.where(length <= ON_AXIS * longest, 0.0, lever)
    return np.concatenate([direction, lever], axis=-1)
