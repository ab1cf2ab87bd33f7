"""An observation block of the way that a body on wheels has to take: how far, and its turns."""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled
from coopenv.geometry.frames import wrapped
from coopenv.observation import Block
from coopenv.transition import Transition

RANGE = 3.0  # [m] of a longer way no more is told


def read_course(transition: Transition) -> FloatArray:
    """``(world, agent, 3)``: the way that is left [m], the turn to it and the one at its end [rad].

    The way is below 0 where the body is to drive it backwards, which is wherever that takes fewer
    turns. Within the tolerance of the place there is hardly a way to turn to: there the first turn
    becomes the one to the goal's angle, and the second 0, by the share s of
    `coopenv.tasks.rolling.RollingTask.distance`.
    """
    task, conditions = transition.conditions.task, transition.conditions
    pose, goal = transition.next_state.pose, transition.next_state.goal
    stop, way = task.stops(conditions.plan, pose, goal)
    course = np.empty((len(pose), 3))
    _write_course(pose, goal, stop, way, task.position_tolerance, course)
    told = conditions.told[..., 0] & conditions.told[..., 1]  # place and angle: a way ends in both
    return np.where(told[..., None], course[:, None], 0.0)


COURSE = Block(
    name="course",
    size=3,
    describe="the shortest way round the obstacles: how far to drive, below 0 backwards, at most "
    f"{RANGE:g} m; the turn to make first and the one at its end; 0 where the goal is not told",
    read=read_course,
    low=(-RANGE, -np.pi, -np.pi),
    high=(RANGE, np.pi, np.pi),
    unit="m, rad, rad",
    needs_told=(1, 1, 1),
    is_sense=False,
)


@compiled
def _write_course(pose, goal, stop, way, blur, course):
    """See `read_course`; ``stop`` and ``way`` are of `coopenv.geometry.routes.next_stops`."""
    for k in range(len(pose)):
        straight = np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1])
        length = way[k, 0] if way[k, 0] < np.inf else straight
        between, before, after = wrapped(goal[k, 2] - pose[k, 2]), 0.0, 0.0
        if straight > 0.0:
            first = np.arctan2(stop[k, 1] - pose[k, 1], stop[k, 0] - pose[k, 0])
            before, after = wrapped(first - pose[k, 2]), wrapped(goal[k, 2] - way[k, 2])
        ahead = 1.0
        if abs(before) + abs(after) > np.pi:
            ahead = -1.0
            before, after = wrapped(before + np.pi), wrapped(after + np.pi)
        share = length * length / (length * length + blur * blur)
        course[k, 0] = ahead * min(length, RANGE)
        course[k, 1] = share * before + (1.0 - share) * between
        course[k, 2] = share * after
