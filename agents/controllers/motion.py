"""Scripted controller of hands: all follow one plan of the object, as if they were rigid."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.conditions import Conditions
from coopenv.config import TransportConfig
from coopenv.geometry.frames import rotated_back
from coopenv.physics.hands import SPEED
from coopenv.transition import Transition

from .hand_motions import HandMotions, paced
from .impedance import ImpedanceController
from .walker import WalkerController


class MotionController:
    """Moves hands so that the object goes the way of a guide, and nothing loads it from within.

        h_o = M (v̇_d + k_d (v_d − v) − g) + D v_d

    The guide, the scripted controller of the task's wrenches, says where to: v_d is what it aims
    for, slowed down to what every hand can follow (`hand_motions.paced`). Each hand gives the part
    of h_o that it has among hands whose references move as one rigid body (`HandMotions.parts`), by
    the motion that makes it (`HandMotions`). All reckon with the same plan, so no hand needs to
    know what another does in between.

    Where one would exceed a limit, all wrenches are scaled down together.

    Stateless: a transition shows how far references are from their grips.

    Parameters
    ----------
    config
        Of an environment with hands. Beside a partner it moves the learners' hands alone, and
        counts on the partner to do its part.
    guide
        Who knows the way, and how briskly.
    """

    def __init__(self, config: TransportConfig, guide: ImpedanceController | WalkerController):
        self.config, self.guide, self.gains = config, guide, guide.gains
        self._motions = HandMotions(config, config.learners)
        self._learners = list(config.learners)
        self._known: Any = None  # team and bodies of which these are the parts
        self._parts = np.empty(0)

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        state, team = transition.next_state, transition.team
        wrench, acceleration = self._needed(transition)
        applied = np.einsum("kaij,kj->kai", self._parts_of(transition.conditions), wrench)
        sizes = np.hypot(applied[..., 0], applied[..., 1]), np.abs(applied[..., 2])
        largest = (np.stack(sizes, axis=-1) / team.limits).max(axis=(1, 2))
        applied /= np.maximum(largest, 1.0)[:, None, None]
        soon = state.twist + acceleration * transition.dt / 2
        return self._motions(applied[:, self._learners], soon, transition)

    def _parts_of(self, conditions: Conditions) -> FloatArray:
        """`HandMotions.parts`, found anew where others hold, or hold something else."""
        known = conditions.team, conditions.bodies
        if self._known is None or any(a is not b for a, b in zip(known, self._known, strict=True)):
            wheels = np.array([body.nonholonomic for body in conditions.bodies])
            self._parts = self._motions.parts(conditions.team.grips, conditions.team.hands, wheels)
            self._known = known
        return self._parts

    def _needed(self, transition: Transition) -> tuple[FloatArray, FloatArray]:
        """Wrench of the object ``(world, 3)``, object frame, and acceleration, world frame."""
        state, team, load = transition.next_state, transition.team, transition.conditions.load
        twist, acceleration = self.guide.wanted_motion(transition)
        twist = paced(twist, state.pose, team.grips, team.hands[..., SPEED:])
        acceleration = acceleration + self.gains.damping * (twist - state.twist)
        inertia = np.stack([load.mass, load.mass, load.inertia], axis=-1)
        drag = np.stack([load.linear_drag, load.linear_drag, load.angular_drag], axis=-1)
        wrench = inertia * acceleration + drag * twist
        wrench[:, :2] -= load.mass[:, None] * transition.conditions.room.gravity
        c, s = np.cos(state.pose[:, 2]), np.sin(state.pose[:, 2])
        wrench[:, 0], wrench[:, 1] = rotated_back(c, s, wrench[:, 0], wrench[:, 1])
        return wrench, acceleration
