"""Scripted controller of the lift: straight up, over the obstacle, and down onto the shelf."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import wrapped
from coopenv.tasks import hurdle
from coopenv.transition import Transition

from .impedance import ImpedanceController

_LINED_UP = 0.15  # [m] beside its place or below its height within which it goes on
_SPEED = 1.0  # [m/s]; a brisk fall counts as a drop
_SINK = 0.4  # [m/s] down onto the shelf
_PRESS = 0.02  # [m] into it that is aimed for, so that the shelf bears the object


class LiftController(ImpedanceController):
    """`ImpedanceController` on a `coopenv.LiftTask`, over way points, the object kept level.

    Before the obstacle and below its top: back from it and up; high enough: along; over its place:
    down, the slower the nearer. The layout is read from the episode's plan. Obstacles of the scene
    are not avoided.
    """

    def wanted_motion(self, transition: Transition) -> tuple[FloatArray, FloatArray | float]:
        """Twist ``(world, 3)`` [m/s, rad/s] to aim for, world frame."""
        state, plan = transition.next_state, transition.conditions.plan
        pose, goal = state.pose, state.goal
        clear, over = plan[:, hurdle.CLEAR_Y], plan[:, hurdle.OVER_X]
        high = pose[:, 1] >= clear - plan[:, hurdle.MARGIN] / 2
        beyond = pose[:, 0] >= over
        away = np.abs(goal[:, 0] - pose[:, 0])
        down = beyond & (away <= _LINED_UP)
        beside = np.minimum(pose[:, 0], plan[:, hurdle.RISE_X])  # keeps off the obstacle's side
        target_x = np.where(high | beyond, goal[:, 0], beside)
        target_y = np.where(down, goal[:, 1] - _PRESS, clear)
        speed = min(self.gains.speed, _SPEED)
        wanted = np.empty_like(pose)
        wanted[:, 0] = np.clip(self.gains.approach * (target_x - pose[:, 0]), -speed, speed)
        rise = np.clip(self.gains.approach * (target_y - pose[:, 1]), -speed, speed)
        wanted[:, 1] = np.where(down, np.maximum(rise, -_SINK), rise)
        turn = self.gains.approach * wrapped(goal[:, 2] - pose[:, 2])
        wanted[:, 2] = np.clip(turn, -self.gains.spin, self.gains.spin)
        return wanted, 0.0
