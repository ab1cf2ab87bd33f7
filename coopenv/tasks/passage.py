"""Geometry of a gap in a wall: the way through it, and the sight of it."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from coopenv.compiled import compiled
from coopenv.geometry.frames import rotated, rotated_back, turn_between
from coopenv.physics.body import Points

# What a layout is, one row a world; the passage leads along x.
WALL_X, GAP_Y, GAP = 0, 1, 2  # [m] the wall's middle, the gap's, the gap's width
HALF_DEPTH = 3  # [m] half the wall's thickness
STANDOFF = 4  # [m] from the wall's middle, where the object may turn freely before the gap
THROUGH = 5  # [rad] angle at which the object is narrowest, in the direction of the passage
ANY_ANGLE = 6  # whether it passes at any angle
WIDTH, AHEAD = 7, 8  # [m] how narrow the object then is, how far it reaches ahead


class Shape(NamedTuple):
    """How narrow a body can be made."""

    width: float  # [m] the least that it has
    along: float  # [rad] its long direction then, object frame
    ahead: float  # [m] how far it reaches from its centre along that


@lru_cache
def narrowest(outline: Points) -> Shape:
    """The least width of a convex outline, which it has across one of its edges."""
    corners = np.array(outline)
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    along = edges[lengths > 0] / lengths[lengths > 0, None]
    across = corners @ np.stack([-along[:, 1], along[:, 0]])  # (vertex, edge)
    widths = across.max(axis=0) - across.min(axis=0)
    best = int(np.argmax(widths <= widths.min() * (1 + 1e-9)))  # the first of equals
    return Shape(
        width=float(widths[best]),
        along=float(np.arctan2(along[best, 1], along[best, 0])),
        ahead=float(np.abs(corners @ along[best]).max()),
    )


@compiled
def heading(plan, angle, goal_angle):
    """The angle at which to pass, of the two half a turn apart, and the turns it takes [rad]."""
    best, turns = plan[THROUGH], np.inf
    for half_turn in (0.0, np.pi):
        through = plan[THROUGH] + half_turn
        needed = turn_between(angle, through) + turn_between(through, goal_angle)
        if needed < turns - 1e-12:
            best, turns = through, needed
    return best, turns


@compiled
def headings(plan, pose, goal):
    """The angle at which each world is to pass, ``(world,)`` [rad]; the fewer turns, the better."""
    angles = np.empty(len(pose))
    for k in range(len(pose)):
        angles[k] = heading(plan[k], pose[k, 2], goal[k, 2])[0]
    return angles


@compiled
def way_through(plan, pose, goal, angle_weight):
    """Length [m] of the way from poses through the gap to goals, ``(world,)``.

    Before the gap: to the standoff on its axis, along the axis to the standoff behind, on to the
    goal; and ``angle_weight`` [m/rad] times the turns to the passing angle and on to the goal's.
    Beside the goal: the straight way and turn. In between, from the wall's middle to the standoff
    behind it, it passes from one to the other; the way through is never shorter than the straight
    one, so it falls steadily all along.

    ``plan`` is ``(world, number)``, ``pose`` and ``goal`` are ``(world, 3)``.
    """
    way = np.empty(len(pose))
    for k in range(len(pose)):
        wall, gap_y, standoff = plan[k, WALL_X], plan[k, GAP_Y], plan[k, STANDOFF]
        side = 1.0 if goal[k, 0] >= wall else -1.0
        along = side * (pose[k, 0] - wall)  # [m] negative before the wall
        ahead = abs(goal[k, 0] - wall)
        beyond = min(standoff, ahead)
        off_axis = abs(pose[k, 1] - gap_y)
        if along < -standoff:
            to_wall = np.hypot(along + standoff, off_axis) + standoff
        else:
            to_wall = off_axis - along
        led = to_wall + beyond + np.hypot(ahead - beyond, goal[k, 1] - gap_y)
        direct = np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1])
        turn = turn_between(pose[k, 2], goal[k, 2])
        turns = turn if plan[k, ANY_ANGLE] else heading(plan[k], pose[k, 2], goal[k, 2])[1]
        passed = min(max(along / max(beyond, 1e-9), 0.0), 1.0)
        way[k] = (1 - passed) * (led + angle_weight * turns) + passed * (
            direct + angle_weight * turn
        )
    return way


@compiled
def seen_gap(plan, pose, frame):
    """The gap from each agent's frame, ``(world, agent, 5)``.

    Way from the object's centre to the gap's [m], cosine and sine of the passage's direction, and
    the gap's width [m].
    """
    num_worlds, num_agents = frame.shape[:2]
    seen = np.empty((num_worlds, num_agents, 5))
    for k in range(num_worlds):
        dx, dy = plan[k, WALL_X] - pose[k, 0], plan[k, GAP_Y] - pose[k, 1]
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            c, s = rotated(cos_object, sin_object, frame[k, i, 0], frame[k, i, 1])
            seen[k, i, 0], seen[k, i, 1] = rotated_back(c, s, dx, dy)
            seen[k, i, 2], seen[k, i, 3] = c, -s
            seen[k, i, 4] = plan[k, GAP]
    return seen
