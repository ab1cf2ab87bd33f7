"""Turning vectors between the object's frame, the agents' and the world's.

An agent's frame has its origin at its grip and x towards the centre of mass (at the centre of
mass: the object's x). ``frame`` holds the cosine and sine of its angle in the object frame.
"""

import numpy as np
from numba import njit

from coopenv.arrays import FloatArray


def agent_frames(grips: FloatArray) -> FloatArray:
    """``(..., agent, 2)``: cosine and sine of each agent frame's angle in the object frame."""
    distance = np.linalg.norm(grips, axis=-1, keepdims=True)
    at_center = distance <= 1e-12
    return np.where(at_center, [1.0, 0.0], -grips / np.where(at_center, 1.0, distance))


@njit(cache=True)
def wrap_pose(pose):  # pragma: no cover - compiled
    """Pose ``(world, 3)`` with its angle wrapped to (−π, π]; a fresh array."""
    wrapped = pose.copy()
    for k in range(len(pose)):
        wrapped[k, 2] = np.pi - (np.pi - pose[k, 2]) % (2 * np.pi)
    return wrapped


@njit(cache=True)
def wrenches_from_actions(action, frame, limit):  # pragma: no cover - compiled
    """Clip actions to [−1, 1], scale them to the agents' limits and turn them to the object frame.

    Parameters
    ----------
    action
        ``(world, agent, 2 or 3)``; two columns mean forces without torque.
    frame, limit
        ``(world, agent, 2)``; limits of force [N] and torque [N·m].

    Returns
    -------
    ``(clipped, applied, finite)``: ``(world, agent, a)``, ``(world, agent, 3)`` and whether every
    action was finite.
    """
    num_worlds, num_agents, width = action.shape
    clipped = np.empty((num_worlds, num_agents, width))
    applied = np.zeros((num_worlds, num_agents, 3))
    finite = True
    for k in range(num_worlds):
        for i in range(num_agents):
            for j in range(width):
                finite = finite and np.isfinite(action[k, i, j])
                clipped[k, i, j] = min(max(action[k, i, j], -1.0), 1.0)
            x, y = limit[k, i, 0] * clipped[k, i, 0], limit[k, i, 0] * clipped[k, i, 1]
            c, s = frame[k, i, 0], frame[k, i, 1]
            applied[k, i, 0], applied[k, i, 1] = c * x - s * y, s * x + c * y
            if width == 3:
                applied[k, i, 2] = limit[k, i, 1] * clipped[k, i, 2]
    return clipped, applied, finite


@njit(cache=True)
def actions_from_wrenches(applied, frame, limit, width):  # pragma: no cover - compiled
    """The inverse of `wrenches_from_actions`, unclipped; ``width`` 2 leaves the torque out."""
    num_worlds, num_agents, _ = applied.shape
    action = np.empty((num_worlds, num_agents, width))
    for k in range(num_worlds):
        for i in range(num_agents):
            c, s = frame[k, i, 0], frame[k, i, 1]
            x, y = applied[k, i, 0], applied[k, i, 1]
            action[k, i, 0] = (c * x + s * y) / limit[k, i, 0]
            action[k, i, 1] = (c * y - s * x) / limit[k, i, 0]
            if width == 3:
                torque = applied[k, i, 2]
                action[k, i, 2] = 0.0 if torque == 0.0 else torque / limit[k, i, 1]
    return action


@njit(cache=True)
def to_agents(wrench, frame):  # pragma: no cover - compiled
    """Each agent's own wrench ``(world, agent, 3)`` from the object frame to its own frame."""
    turned = np.empty(wrench.shape)
    for k in range(wrench.shape[0]):
        for i in range(wrench.shape[1]):
            c, s = frame[k, i, 0], frame[k, i, 1]
            x, y, torque = wrench[k, i]
            turned[k, i, 0], turned[k, i, 1], turned[k, i, 2] = c * x + s * y, c * y - s * x, torque
    return turned


@njit(cache=True)
def others_to_agents(wrench, frame):  # pragma: no cover - compiled
    """The other agents' wrenches in each agent's frame ``(world, agent, 3·(agents − 1))``."""
    num_worlds, num_agents, _ = wrench.shape
    turned = np.empty((num_worlds, num_agents, 3 * (num_agents - 1)))
    for k in range(num_worlds):
        for i in range(num_agents):
            c, s = frame[k, i, 0], frame[k, i, 1]
            for step in range(1, num_agents):
                x, y, torque = wrench[k, (i + step) % num_agents]
                out = turned[k, i, 3 * (step - 1) : 3 * step]
                out[0], out[1], out[2] = c * x + s * y, c * y - s * x, torque
    return turned


@njit(cache=True)
def rates_to_agents(twist, pose, frame):  # pragma: no cover - compiled
    """The object's twist ``(world, 3)``, world frame, in each agent's ``(world, agent, 3)``."""
    num_worlds, num_agents = frame.shape[:2]
    turned = np.empty((num_worlds, num_agents, 3))
    for k in range(num_worlds):
        c_object, s_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            c = c_object * frame[k, i, 0] - s_object * frame[k, i, 1]
            s = s_object * frame[k, i, 0] + c_object * frame[k, i, 1]
            turned[k, i, 0] = c * twist[k, 0] + s * twist[k, 1]
            turned[k, i, 1] = c * twist[k, 1] - s * twist[k, 0]
            turned[k, i, 2] = twist[k, 2]
    return turned


@njit(cache=True)
def goals_to_agents(goal, pose, frame):  # pragma: no cover - compiled
    """Way to the goal pose in each agent's frame ``(world, agent, 4)``: Δx, Δy, cos Δθ, sin Δθ."""
    num_worlds, num_agents = frame.shape[:2]
    away = goal - pose
    seen = np.empty((num_worlds, num_agents, 4))
    seen[:, :, :3] = rates_to_agents(away, pose, frame)
    for k in range(num_worlds):
        seen[k, :, 2], seen[k, :, 3] = np.cos(away[k, 2]), np.sin(away[k, 2])
    return seen
