"""The inverse dynamics of `coopenv.agents.controllers.ImpedanceController`, compiled.

It has to run for a whole batch beside the physics in every step. A test holds the two together.
"""

import numpy as np
from numba import njit

from coopenv.arrays import FloatArray

from .controllers import Gains

LOOKS = 9  # angles looked at between here and the end of the look-ahead
NUM_GAINS = 6


def gains_row(gains: Gains) -> FloatArray:
    """``(6,)`` as `object_wrench` takes them."""
    return np.array(
        [gains.approach, gains.damping, gains.speed, gains.spin, gains.margin, gains.look_ahead]
    )


@njit(cache=True, error_model="numpy")
def object_wrench(
    gains, pose, twist, goal, mass, inertia, linear_drag, angular_drag, outline, size, reach
):  # pragma: no cover - compiled
    """Wrench (fx, fy, t) [N, N·m] that one object needs on its way to ``goal``, object frame.

    Parameters
    ----------
    gains
        ``(6,)``, see `gains_row`.
    pose, twist, goal
        ``(3,)``, world frame.
    mass, inertia, linear_drag, angular_drag
        Of the object.
    outline
        ``(vertex, 2)``, object frame [m].
    size
        ``(2,)`` of the room [m].
    reach
        From the object's origin to its farthest vertex [m].
    """
    approach, damping, speed, spin = gains[0], gains[1], gains[2], gains[3]
    turn = np.pi - (np.pi - (goal[2] - pose[2])) % (2 * np.pi)
    low_x, high_x, low_y, high_y = _free_box(
        gains[4], gains[5], turn, pose, goal, outline, size, reach
    )
    free_x = min(max(pose[0], low_x), high_x) - pose[0]
    free_y = min(max(pose[1], low_y), high_y) - pose[1]
    cramped = np.hypot(free_x, free_y)
    vx = approach * (min(max(goal[0], low_x), high_x) - pose[0])
    vy = approach * (min(max(goal[1], low_y), high_y) - pose[1])
    slower = min(1.0, speed / max(np.hypot(vx, vy), 1e-12))
    spin *= min(max(1 - cramped / 0.3, 0.0), 1.0)
    omega = min(max(approach * turn, -spin), spin)
    fx = mass * damping * (slower * vx - twist[0]) + linear_drag * twist[0]
    fy = mass * damping * (slower * vy - twist[1]) + linear_drag * twist[1]
    torque = inertia * damping * (omega - twist[2]) + angular_drag * twist[2]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return c * fx + s * fy, c * fy - s * fx, torque


@njit(cache=True, error_model="numpy")
def _free_box(
    margin, look_ahead, turn, pose, goal, outline, size, reach
):  # pragma: no cover - compiled
    """Where the centre may be so that the object clears the walls during the coming turn."""
    near_x, near_y = size[0] / 2 - margin - reach, size[1] / 2 - margin - reach
    far = max(abs(pose[0]), abs(goal[0])) > near_x or max(abs(pose[1]), abs(goal[1])) > near_y
    if not far:  # then no wall matters, whatever the angle
        return -near_x, near_x, -near_y, near_y
    ahead = min(max(turn, -look_ahead), look_ahead)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    c_step, s_step = np.cos(ahead / (LOOKS - 1)), np.sin(ahead / (LOOKS - 1))
    left = right = down = up = 0.0
    for look in range(LOOKS):
        for v in range(len(outline)):
            x = c * outline[v, 0] - s * outline[v, 1]
            y = s * outline[v, 0] + c * outline[v, 1]
            if look == 0 and v == 0:
                left, right, down, up = x, x, y, y
            left, right, down, up = min(left, x), max(right, x), min(down, y), max(up, y)
        c, s = c * c_step - s * s_step, s * c_step + c * s_step
    low_x, high_x = -size[0] / 2 + margin - left, size[0] / 2 - margin - right
    low_y, high_y = -size[1] / 2 + margin - down, size[1] / 2 - margin - up
    middle_x, middle_y = (low_x + high_x) / 2, (low_y + high_y) / 2
    return (
        min(low_x, middle_x), max(high_x, middle_x), min(low_y, middle_y), max(high_y, middle_y)
    )  # fmt: skip
