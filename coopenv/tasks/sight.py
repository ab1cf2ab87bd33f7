"""Observation of a moving reference: its preview and its twist in each agent's frame."""

import numpy as np

from coopenv.compiled import compiled
from coopenv.geometry.frames import rotated, rotated_back


@compiled
def ahead_in_agent_frames(pose, later, frame, told):
    """Ways from poses ``(world, 3)`` to later goals ``(world, time, 3)``.

    Returns ``(world, agent, 4 · time)``: Δx, Δy [m], cos Δθ, sin Δθ for each time; 0 where
    ``told`` ``(world, agent, 2)``, place and angle, says no.
    """
    num_worlds, num_agents = frame.shape[:2]
    count = later.shape[1]
    seen = np.zeros((num_worlds, num_agents, 4 * count))
    for k in range(num_worlds):
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            c, s = rotated(cos_object, sin_object, frame[k, i, 0], frame[k, i, 1])
            for j in range(count):
                out = seen[k, i, 4 * j : 4 * j + 4]
                if told[k, i, 0]:
                    dx, dy = later[k, j, 0] - pose[k, 0], later[k, j, 1] - pose[k, 1]
                    out[0], out[1] = rotated_back(c, s, dx, dy)
                if told[k, i, 1]:
                    turn = later[k, j, 2] - pose[k, 2]
                    out[2], out[3] = np.cos(turn), np.sin(turn)
    return seen


@compiled
def twist_in_agent_frames(pose, twist, frame, told):
    """A twist ``(world, 3)`` of the world frame in each agent's, ``(world, agent, 3)``.

    Velocities read 0 where ``told`` says that the agent does not know the place, spins where it
    does not know the angle.
    """
    num_worlds, num_agents = frame.shape[:2]
    seen = np.zeros((num_worlds, num_agents, 3))
    for k in range(num_worlds):
        cos_object, sin_object = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for i in range(num_agents):
            c, s = rotated(cos_object, sin_object, frame[k, i, 0], frame[k, i, 1])
            if told[k, i, 0]:
                seen[k, i, 0], seen[k, i, 1] = rotated_back(c, s, twist[k, 0], twist[k, 1])
            if told[k, i, 1]:
                seen[k, i, 2] = twist[k, 2]
    return seen
