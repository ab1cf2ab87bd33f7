"""Scripted leaders of hands: each hand straight to its own place, or along the object's way."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import rotated, wrapped
from coopenv.transition import Transition

from .impedance import ImpedanceController
from .velocities import HandPolicy, carried, gain, levers
from .walker import WalkerController


class Straight(HandPolicy):
    """Each hand goes straight to where its grip is at the goal: who is told the goal, and no more.

        v = k (place at the goal − place),    ω = k_t (angle at the goal − angle)

    from the grip as it is, at most as fast as the hand can. Two of them agree about the end alone:
    in between their straight ways pull the object apart and press it together. Walls and obstacles
    are not avoided. Stateless.

    Parameters
    ----------
    config
        Of an environment with hands.
    approach, turning
        k and k_t [1/s]. On the default beam one such hand by itself comes to rest with the default
        ones, now and then after swinging about the goal for long; with a heavier beam it swings on.
    firmness
        See `HandPolicy`.
    """

    def __init__(
        self,
        config: TransportConfig,
        *,
        approach: float = 1.2,
        turning: float = 1.5,
        firmness: float = 0.0,
    ):
        super().__init__(config, firmness=firmness)
        self.approach = gain(approach, "approach", "1/s")
        self.turning = gain(turning, "turning", "1/s")

    def velocities(self, transition: Transition) -> FloatArray:
        """See `HandPolicy.velocities`."""
        state, grips = transition.next_state, transition.team.grips
        pose, goal, lever = state.pose, state.goal, levers(transition)
        angle = goal[:, 2, None]
        x, y = rotated(np.cos(angle), np.sin(angle), grips[..., 0], grips[..., 1])
        away = np.stack([x, y], axis=-1) - lever + (goal - pose)[:, None, :2]
        turn = np.broadcast_to(wrapped(goal[:, 2] - pose[:, 2])[:, None, None], (*x.shape, 1))
        return np.concatenate([self.approach * away, self.turning * turn], axis=-1)


class Along(HandPolicy):
    """Each hand goes as its grip does where the object moves as a guide would have it.

    For tasks in which the straight way is none: round a wall, over an obstacle. Stateless.

    Parameters
    ----------
    config
        Of an environment with hands.
    guide
        Who knows the object's way; see `coopenv.agents.controllers.find_guide`.
    firmness
        See `HandPolicy`.

    Raises
    ------
    InvalidInput
        If ``guide`` knows no way; beside what `HandPolicy` raises.
    """

    def __init__(
        self,
        config: TransportConfig,
        guide: ImpedanceController | WalkerController,
        *,
        firmness: float = 0.0,
    ):
        super().__init__(config, firmness=firmness)
        if not callable(getattr(guide, "wanted_motion", None)):
            raise InvalidInput(
                f"guide must know the object's way by wanted_motion, got {guide!r:.80}; pass "
                "find_guide(config)"
            )
        self.guide = guide

    def velocities(self, transition: Transition) -> FloatArray:
        """See `HandPolicy.velocities`."""
        twist, _ = self.guide.wanted_motion(transition)
        return carried(twist, levers(transition))
