"""An observation block that shows the obstacle nearest to the body."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.geometry.clearance import ways_to_boxes
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.observation import Block
from coopenv.transition import Transition

RANGE = 3.0  # [m] farther obstacles are not seen


def nearest_obstacle(transition: Transition) -> FloatArray:
    """``(world, agent, 3)``: its nearest point from the centre of mass, and the clearance [m].

    In the agent's frame; of an obstacle farther than ``RANGE`` from the outline, or none, the
    point reads 0 and the clearance ``RANGE``.
    """
    pose, room = transition.next_state.pose, transition.conditions.room
    frame = transition.team.frame
    seen = np.zeros((*frame.shape[:2], 3))
    seen[..., 2] = RANGE
    if not room.boxes.shape[1]:
        return seen
    ways = ways_to_boxes(transition.conditions.load.outline, pose, room.boxes, room.count)
    chosen = ways[np.arange(len(pose)), ways[:, :, 0].argmin(axis=1)]  # (world, 5)
    near = chosen[:, 0] < RANGE
    away = chosen[:, 3:] - pose[:, :2]
    c_body, s_body = np.cos(pose[:, 2, None]), np.sin(pose[:, 2, None])
    c, s = rotated(c_body, s_body, frame[..., 0], frame[..., 1])
    point = np.stack(rotated_back(c, s, away[:, 0, None], away[:, 1, None]), axis=-1)
    seen[near, :, :2], seen[near, :, 2] = point[near], chosen[near, 0, None]
    return seen


NEAREST = Block(
    name="nearest",
    size=3,
    describe="from the centre of mass to the nearest point of the nearest obstacle, walls left "
    f"out, and that point's distance from the outline; 0, 0, {RANGE:g} beyond {RANGE:g} m",
    read=nearest_obstacle,
    unit="m",
    frame="agent",
)
