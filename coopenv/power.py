"""Power of a step: the part of it that each agent supplies, and what passes between agents."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import compiled
from coopenv.geometry.displacement import mean_twist
from coopenv.wrench.shares import is_defined, power_of, share_power


class Power(NamedTuple):
    """Power of the agents over a control step: of the mean wrench at the mean twist."""

    twist: FloatArray  # (world, 3): see `coopenv.geometry.displacement.mean_twist`
    share: FloatArray  # (world, agent): β (eq. 26), dimensionless; 1/n where undefined
    defined: BoolArray  # (world,): whether there is a power to share
    internal: FloatArray  # (world,): Ė_I = ½(Σ|Ė_i| − |ΣĖ_i|) [W]


def power_over(
    applied: FloatArray,
    grips: FloatArray,
    before: tuple[FloatArray, FloatArray],
    after: tuple[FloatArray, FloatArray],
    dt: float,
) -> Power:
    """Power over a control step.

    Parameters
    ----------
    applied, grips
        ``(world, agent, 3)`` and ``(world, agent, 2)``, object frame [N, N·m] and [m].
    before, after
        Pose and twist ``(world, 3)`` at the step's ends, world frame.
    dt
        Of the step [s].
    """
    num_worlds, num_agents = applied.shape[:2]
    power = Power(  # NumPy makes arrays in less time than compiled code hands them out
        np.empty((num_worlds, 3)),
        np.empty((num_worlds, num_agents)),
        np.empty(num_worlds, dtype=np.bool_),
        np.empty(num_worlds),
    )
    _write(applied, grips, *before, *after, dt, *power)
    return power


@compiled
def _write(applied, grips, pose, twist, next_pose, next_twist, dt, mean, share, defined, internal):
    """Write the fields of `Power`, of arguments as in `power_over`."""
    for k in range(len(applied)):
        wrenches, places, parts = applied[k], grips[k], share[k]
        motion = mean_twist(pose, twist, next_pose, next_twist, k, dt)
        mean[k, 0], mean[k, 1], mean[k, 2] = motion
        for i in range(len(parts)):
            linear, angular = power_of(wrenches, places, i, motion, None)
            parts[i] = linear + angular
        passed = share_power(parts)
        internal[k] = 0.0 if passed < 0.0 else passed  # below by rounding
        defined[k] = is_defined(parts)
        if not defined[k]:
            for i in range(len(parts)):
                parts[i] = 1 / len(parts)
