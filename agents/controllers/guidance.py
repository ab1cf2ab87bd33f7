"""Guidance to a goal within walls: the twist to aim for and its wrench, compiled."""

from dataclasses import astuple, dataclass
from math import cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated, rotated_back, wrapped

LOOKS = 9  # angles looked at between here and the end of the look-ahead

# Places of the `Gains` in a row
APPROACH, DAMPING, SPEED, SPIN, MARGIN, LOOK_AHEAD = range(6)
NUM_GAINS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """How briskly the object is led; the defaults use the default beam's strength.

    The object is to move towards its goal with a velocity proportional to the way that is left,
    up to ``speed`` and ``spin``; an impedance makes it do so.
    """

    approach: float = 3.0  # [1/s] wanted velocity per unit of way left
    damping: float = 10.0  # [1/s] wanted acceleration per unit of velocity error
    speed: float = 2.5  # [m/s] at most
    spin: float = 3.0  # [rad/s] at most
    margin: float = 0.05  # [m] kept from the walls
    look_ahead: float = 0.8  # [rad] of the turn for which room is made in advance


def gains_row(gains: Gains) -> tuple[float, ...]:
    """The six numbers as the kernels take them: at `APPROACH` and so on."""
    return tuple(map(float, astuple(gains)))


class Outline(NamedTuple):
    """The outline of one object among those of all worlds."""

    corners: FloatArray  # (world, vertex, 2), object frame [m]
    world: int
    reach: float  # [m] from the object's origin to its farthest vertex


@inlined
def triple(rows, k):
    """Row ``k`` of three numbers as a tuple, which is cheaper to make than a view of the row."""
    return rows[k, 0], rows[k, 1], rows[k, 2]


@inlined
def object_wrench(gains, pose, twist, wanted, dragged, load):
    """Wrench (fx, fy, t) [N, N·m] that makes an object take up a ``wanted`` twist, object frame.

    Parameters
    ----------
    gains
        Six, see `gains_row`.
    pose, twist, wanted
        Three each, world frame.
    dragged
        The twist whose drag is met: that of the object or the wanted one.
    load
        Mass, inertia, linear and angular drag of the object, and gravity x and y [m/s²].
    """
    mass, inertia, linear_drag, angular_drag, down_x, down_y = load
    damping = gains[DAMPING]
    c, s = cos(pose[2]), sin(pose[2])
    fx = mass * (damping * (wanted[0] - twist[0]) - down_x) + linear_drag * dragged[0]
    fy = mass * (damping * (wanted[1] - twist[1]) - down_y) + linear_drag * dragged[1]
    torque = inertia * damping * (wanted[2] - twist[2]) + angular_drag * dragged[2]
    along, across = rotated_back(c, s, fx, fy)
    return along, across, torque


@inlined
def guiding_twist(gains, pose, goal, size, outline):
    """Twist (vx, vy, ω) that leads an object to ``goal`` in a room, world frame.

    ``size`` are two, of the room [m]; ``outline`` is the object's `Outline`.
    """
    half_x, half_y = size[0] / 2, size[1] / 2
    free = (-half_x, half_x, -half_y, half_y)
    return _wanted_twist(gains, pose, (cos(pose[2]), sin(pose[2])), goal, free, outline)


@compiled
def wanted_twists(gains, pose, goal, outline, low, high):
    """Twists ``(world, 3)`` (vx, vy, ω) that lead objects to a goal in a rectangle, world frame.

    ``low`` and ``high`` are the corners ``(world, 2)`` [m] of what is free.
    """
    wanted = np.empty((len(pose), 3))
    for k in range(len(pose)):
        reach = 0.0
        for v in range(outline.shape[1]):
            reach = max(reach, np.hypot(outline[k, v, 0], outline[k, v, 1]))
        axis = (cos(pose[k, 2]), sin(pose[k, 2]))
        free = (low[k, 0], high[k, 0], low[k, 1], high[k, 1])
        shape = Outline(outline, k, reach)
        wanted[k] = _wanted_twist(gains, triple(pose, k), axis, triple(goal, k), free, shape)
    return wanted


@inlined
def _wanted_twist(gains, pose, axis, goal, free, outline):
    """The twist of one object; ``free`` are the edges (low x, high x, low y, high y) [m]."""
    approach, speed, spin = gains[APPROACH], gains[SPEED], gains[SPIN]
    turn = goal[2] - pose[2]
    if not -pi < turn <= pi:
        turn = wrapped(turn)
    low_x, high_x, low_y, high_y = _free_box(
        gains[MARGIN], gains[LOOK_AHEAD], turn, pose, axis, goal, free, outline
    )
    free_x = min(max(pose[0], low_x), high_x) - pose[0]
    free_y = min(max(pose[1], low_y), high_y) - pose[1]
    cramped = sqrt(free_x * free_x + free_y * free_y)
    vx = approach * (min(max(goal[0], low_x), high_x) - pose[0])
    vy = approach * (min(max(goal[1], low_y), high_y) - pose[1])
    slower = min(1.0, speed / max(sqrt(vx * vx + vy * vy), 1e-12))
    spin *= min(max(1 - cramped / 0.3, 0.0), 1.0)
    return slower * vx, slower * vy, min(max(approach * turn, -spin), spin)


@compiled
def _free_box(margin, look_ahead, turn, pose, axis, goal, free, outline):
    """Where the centre may be so that the object keeps to the rectangle during the coming turn."""
    corners, k, reach = outline
    low_x, high_x, low_y, high_y = free
    low_x, high_x, low_y, high_y = low_x + margin, high_x - margin, low_y + margin, high_y - margin
    if (
        min(pose[0], goal[0]) >= low_x + reach
        and max(pose[0], goal[0]) <= high_x - reach
        and min(pose[1], goal[1]) >= low_y + reach
        and max(pose[1], goal[1]) <= high_y - reach
    ):  # then no wall matters, whatever the angle
        return low_x + reach, high_x - reach, low_y + reach, high_y - reach
    ahead = min(max(turn, -look_ahead), look_ahead)
    c, s = axis
    c_step, s_step = cos(ahead / (LOOKS - 1)), sin(ahead / (LOOKS - 1))
    left = right = down = up = 0.0
    for look in range(LOOKS):
        for v in range(corners.shape[1]):
            x, y = rotated(c, s, corners[k, v, 0], corners[k, v, 1])
            if look == 0 and v == 0:
                left, right, down, up = x, x, y, y
            left, right, down, up = min(left, x), max(right, x), min(down, y), max(up, y)
        c, s = rotated(c, s, c_step, s_step)
    low_x, high_x, low_y, high_y = low_x - left, high_x - right, low_y - down, high_y - up
    middle_x, middle_y = (low_x + high_x) / 2, (low_y + high_y) / 2
    return (
        min(low_x, middle_x), max(high_x, middle_x), min(low_y, middle_y), max(high_y, middle_y)
    )  # fmt: skip
