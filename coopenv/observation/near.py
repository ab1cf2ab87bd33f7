"""Block of the way that is left to the goal, on a scale that is fine close to it."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import rotated_back, wrapped
from coopenv.observation.block import Block
from coopenv.transition import Transition

_PLACE, _ANGLE = 0.1, 0.1  # [m], [rad]: of what is left there, half of the scale is used


def _near_goal(transition: Transition) -> FloatArray:
    """Way over what it is plus 0.1 m, turn over what it is plus 0.1 rad; 0 where not told."""
    pose, goal = transition.next_state.pose[:, None], transition.next_state.goal[:, None]
    frame, told = transition.team.frame, transition.conditions.told
    cos_object, sin_object = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    left = goal - pose
    x, y = rotated_back(cos_object, sin_object, left[..., 0], left[..., 1])
    x, y = rotated_back(frame[..., 0], frame[..., 1], x, y)
    turn = wrapped(left[..., 2]) * np.ones_like(x)
    away = _PLACE + np.hypot(x, y)
    seen = np.stack([x / away, y / away, turn / (_ANGLE + np.abs(turn))], axis=-1)
    return np.where(told[..., [0, 0, 1]], seen, 0.0)


NEAR_GOAL = Block(
    name="near_goal",
    size=3,
    describe="way to the goal over its length plus 0.1 m, and turn over its size plus 0.1 rad: "
    "fine where little is left; 0 where not told",
    read=_near_goal,
    low=-1.0,
    high=1.0,
    unit="1, 1, 1",
    frame="agent",
    needs_told=(0, 0, 1),
)
