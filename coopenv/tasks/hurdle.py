"""Geometry of a lift over an obstacle onto a shelf, in an upright plane: the way, and the sight."""

import numpy as np

from coopenv.compiled import compiled
from coopenv.geometry.frames import rotated, rotated_back, turn_between

# What a layout is, one row a world; the way leads along x, from the floor to the shelf.
RISE_X = 0  # [m] x of the centre from which on the level object would touch the obstacle
OVER_X = 1  # [m] x from which on all of it is behind the obstacle and over the shelf
CLEAR_Y = 2  # [m] height of the centre at which the level object clears obstacle and shelf
HURDLE_X, HURDLE_Y = 3, 4  # [m] the middle of the obstacle's top
SHELF_X, SHELF_Y = 5, 6  # [m] the shelf's edge
MARGIN = 7  # [m] within which, before OVER_X, the way goes over to the straight one


@compiled
def way_over(plan, pose, goal, angle_weight):
    """Length [m] of the way from poses over the obstacle to goals, ``(world,)``.

    Before the obstacle and below its top: to the place beside it from which the level object
    clears it, along to the shelf, on to the goal; over the obstacle but too low: up first. And
    ``angle_weight`` [m/rad] times the turn. Over the shelf: the straight way and turn. On the last
    `MARGIN` before the shelf it passes from one to the other, so that it has no step.

    ``plan`` is ``(world, number)``, ``pose`` and ``goal`` are ``(world, 3)``.
    """
    way = np.empty(len(pose))
    for k in range(len(pose)):
        x, y, clear = pose[k, 0], pose[k, 1], plan[k, CLEAR_Y]
        rise, over = plan[k, RISE_X], plan[k, OVER_X]
        along = max(over - x, 0.0)
        if y >= clear:
            led = np.hypot(along, y - clear)
        elif x < rise:
            led = np.hypot(rise - x, clear - y) + over - rise
        else:
            led = clear - y + along
        led += np.hypot(goal[k, 0] - over, goal[k, 1] - clear)
        straight = np.hypot(goal[k, 0] - x, goal[k, 1] - y)
        passed = min(max((x - over) / plan[k, MARGIN] + 1.0, 0.0), 1.0)
        turn = angle_weight * turn_between(pose[k, 2], goal[k, 2])
        way[k] = (1 - passed) * led + passed * straight + turn
    return way


@compiled
def seen_hurdle(plan, pose, frame):
    """Obstacle and shelf from each agent's frame, ``(world, agent, 4)`` [m].

    Ways from the object's centre to the middle of the obstacle's top and to the shelf's edge.
    """
    num_worlds, num_agents = frame.shape[:2]
    seen = np.empty((num_worlds, num_agents, 4))
    for k in range(num_worlds):
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            c, s = rotated(cos_object, sin_object, frame[k, i, 0], frame[k, i, 1])
            out = seen[k, i]
            dx, dy = plan[k, HURDLE_X] - pose[k, 0], plan[k, HURDLE_Y] - pose[k, 1]
            out[0], out[1] = rotated_back(c, s, dx, dy)
            dx, dy = plan[k, SHELF_X] - pose[k, 0], plan[k, SHELF_Y] - pose[k, 1]
            out[2], out[3] = rotated_back(c, s, dx, dy)
    return seen


@compiled
def seen_down(pose, gravity, frame):
    """The direction of gravity in each agent's frame, ``(world, agent, 2)``; 0 without any."""
    num_worlds, num_agents = frame.shape[:2]
    seen = np.zeros((num_worlds, num_agents, 2))
    for k in range(num_worlds):
        strength = np.hypot(gravity[k, 0], gravity[k, 1])
        if strength == 0.0:
            continue
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            c, s = rotated(cos_object, sin_object, frame[k, i, 0], frame[k, i, 1])
            x, y = gravity[k, 0] / strength, gravity[k, 1] / strength
            seen[k, i, 0], seen[k, i, 1] = rotated_back(c, s, x, y)
    return seen


@compiled
def laid_down(pose, twist, goal, tolerances):
    """Whether bodies rest at their goals, which touch what bears them, ``(world,)``.

    ``tolerances`` are of x and of y below the goal [m], angle [rad], speed [m/s] and spin [rad/s].
    """
    along, below, angle, speed, spin = tolerances
    done = np.empty(len(pose), dtype=np.bool_)
    for k in range(len(pose)):
        done[k] = (
            abs(goal[k, 0] - pose[k, 0]) <= along
            and 0.0 <= goal[k, 1] - pose[k, 1] <= below
            and turn_between(pose[k, 2], goal[k, 2]) <= angle
            and np.hypot(twist[k, 0], twist[k, 1]) <= speed
            and abs(twist[k, 2]) <= spin
        )
    return done


@compiled
def let_down(pose, twist, goal, tilt, fall):
    """Whether bodies lean more than ``tilt`` [rad] or fall faster than ``fall`` [m/s]."""
    failed = np.empty(len(pose), dtype=np.bool_)
    for k in range(len(pose)):
        failed[k] = turn_between(pose[k, 2], goal[k, 2]) > tilt or twist[k, 1] < -fall
    return failed
