"""Scripted controller of tracking: feed-forward along a moving reference."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import wrapped
from coopenv.tasks import TrackingTask
from coopenv.transition import Transition

from .impedance import ImpedanceController


class TrackingController(ImpedanceController):
    """`ImpedanceController` on a `coopenv.TrackingTask`, with the reference fed forward.

        v_d = v_ref + k_p (reference − pose),    v̇_d = v̇_ref

    The acceleration is that of the middle of the coming control step.
    """

    def wanted_motion(self, transition: Transition) -> tuple[FloatArray, FloatArray]:
        """Twist ``(world, 3)`` [m/s, rad/s] and acceleration to aim for, world frame."""
        state, conditions = transition.next_state, transition.conditions
        task: TrackingTask = conditions.task
        now = task.motion(conditions.plan, state.time)
        soon = task.motion(conditions.plan, state.time + transition.dt / 2)
        error = now[:, :3] - state.pose
        error[:, 2] = wrapped(error[:, 2])
        own = state.goal - now[:, :3]  # of who is led beside the reference, as partners may be
        own[:, 2] = wrapped(state.goal[:, 2] - wrapped(now[:, 2]))  # so that none is exactly zero
        error += own
        bound = np.array([self.gains.speed, self.gains.speed, self.gains.spin])
        correction = np.clip(self.gains.approach * error, -bound, bound)
        return now[:, 3:6] + correction, soon[:, 6:9]
