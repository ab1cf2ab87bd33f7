"""Angles and frames: wrapping, rotation, and changes between object, agent and world frame.

An agent's frame has its origin at its grip and x towards the centre of mass (at the centre of
mass: the object's x). ``frame`` holds the cosine and sine of its angle in the object frame.

The functions of angles and of rotations take numbers, arrays that broadcast, and what kernels have;
a rotation is given by its cosine and sine.
"""

from collections.abc import Sequence
from math import cos, sin
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.compiled import anywhere, compiled, inlined

Angle = TypeVar("Angle", float, FloatArray)


@anywhere
def wrapped(angle: Angle) -> Angle:
    """The same angle in (−π, π] [rad]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


@anywhere
def turn_between(angle, other):
    """The short way round from one angle to the other, in [0, π] [rad]."""
    return abs(np.pi - (np.pi + other - angle) % (2 * np.pi))  # `wrapped` rounds otherwise


@anywhere
def rotated(c, s, x, y):
    """The vector (x, y) of a frame as seen from outside, where its x axis has the direction (c, s).

    With the direction of a second frame's axis for (x, y), the rotation by both angles.
    """
    return c * x - s * y, s * x + c * y


@anywhere
def rotated_back(c, s, x, y):
    """The vector (x, y) as seen from a frame whose x axis has the direction (c, s)."""
    return c * x + s * y, c * y - s * x


@anywhere
def placed(at_x, at_y, c, s, x, y):
    """The point (x, y) of a frame with this origin and direction of its x axis, seen from outside.

    The inverse of `seen_from`; `moved` places many points at one pose.
    """
    return at_x + c * x - s * y, at_y + s * x + c * y


@anywhere
def seen_from(at_x, at_y, c, s, x, y):
    """The point (x, y) as seen from a frame with this origin and direction of its x axis."""
    return rotated_back(c, s, x - at_x, y - at_y)


def moved(points: npt.ArrayLike, pose: Sequence[float] | FloatArray) -> FloatArray:
    """Points ``(..., 2)`` [m] of a frame at ``pose`` (x, y [m], θ [rad]), seen from outside."""
    c, s = cos(pose[2]), sin(pose[2])
    return np.asarray(points) @ np.array([(c, s), (-s, c)]) + np.asarray(pose[:2])


def agent_frames(grips: FloatArray) -> FloatArray:
    """``(..., agent, 2)``: cosine and sine of each agent frame's angle in the object frame."""
    distance = np.linalg.norm(grips, axis=-1, keepdims=True)
    at_center = distance <= 1e-12
    return np.where(at_center, [1.0, 0.0], -grips / np.where(at_center, 1.0, distance))


def wrap_pose(pose: FloatArray) -> FloatArray:
    """Pose ``(world, 3)`` with its angle wrapped to (−π, π]; a fresh array."""
    out = np.empty(pose.shape)
    _wrap(pose, out)
    return out


@compiled
def _wrap(pose, out):
    for k in range(len(pose)):
        out[k, 0], out[k, 1], out[k, 2] = pose[k, 0], pose[k, 1], wrapped(pose[k, 2])


def wrenches_from_actions(
    action: FloatArray, frame: FloatArray, limit: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Clip actions to [−1, 1], scale them to the agents' limits and turn them to the object frame.

    Parameters
    ----------
    action
        ``(world, agent, 2 or 3)``; two columns mean forces without torque.
    frame, limit
        ``(world, agent, 2)``; limits of force [N] and torque [N·m].

    Returns
    -------
    ``(clipped, applied)``: ``(world, agent, a)`` and ``(world, agent, 3)``.
    """
    clipped, applied = np.empty(action.shape), np.empty((*action.shape[:2], 3))
    _write_wrenches(action, frame, limit, clipped, applied)
    return clipped, applied


@compiled
def _write_wrenches(action, frame, limit, clipped, applied):
    for k in range(len(action)):
        write_wrench(action, frame, limit, k, clipped, applied)


@inlined
def write_wrench(action, frame, limit, k, clipped, applied):
    """`wrenches_from_actions` of one world."""
    _, num_agents, width = action.shape
    for i in range(num_agents):
        for j in range(width):
            clipped[k, i, j] = min(max(action[k, i, j], -1.0), 1.0)
        x, y = limit[k, i, 0] * clipped[k, i, 0], limit[k, i, 0] * clipped[k, i, 1]
        applied[k, i, 0], applied[k, i, 1] = rotated(frame[k, i, 0], frame[k, i, 1], x, y)
        applied[k, i, 2] = limit[k, i, 1] * clipped[k, i, 2] if width == 3 else 0.0


@inlined
def action_of(c, s, force_limit, torque_limit, x, y, torque):
    """The action that stands for a wrench of the object frame, unclipped; no torque needs none."""
    along, across = rotated_back(c, s, x, y)
    turning = 0.0 if torque == 0.0 else torque / torque_limit
    return along / force_limit, across / force_limit, turning


@compiled
def actions_from_wrenches(applied, frame, limit, width):
    """The inverse of `wrenches_from_actions`, unclipped; ``width`` 2 leaves the torque out."""
    num_worlds, num_agents, _ = applied.shape
    action = np.empty((num_worlds, num_agents, width))
    for k in range(num_worlds):
        for i in range(num_agents):
            x, y, torque = action_of(
                frame[k, i, 0], frame[k, i, 1], limit[k, i, 0], limit[k, i, 1],
                applied[k, i, 0], applied[k, i, 1], applied[k, i, 2],
            )  # fmt: skip
            action[k, i, 0], action[k, i, 1] = x, y
            if width == 3:
                action[k, i, 2] = torque
    return action


def repeated(value: npt.NDArray[Any], count: int, scale: float) -> FloatArray:
    """``scale`` × one value a world ``(world,)``, for each of ``count`` agents."""
    out = np.empty((len(value), count))
    _repeat(value, scale, out)
    return out


@compiled
def _repeat(value, scale, out):
    for k in range(len(value)):
        out[k, :] = scale * value[k]
