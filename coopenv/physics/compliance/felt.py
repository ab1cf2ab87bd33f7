"""Felt: what hands feel and store at the end of a step."""

import numpy as np

from coopenv.compiled import TINY, compiled
from coopenv.compiled.kinds import fused
from coopenv.compiled.lanes.memory import four_at
from coopenv.compiled.lanes.vectors import LANES, larger, root, smaller, splat
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.physics.compliance.block import (
    AGENT_FIELDS,
    BASE,
    COSINE,
    FORCE,
    GIVEN,
    GRIP,
    LIMIT,
    REFERENCE,
    SINE,
    SLOPE,
    SPRING,
    TWIST,
    VELOCITY,
    WORLD_FIELDS,
    gather,
)
from coopenv.physics.compliance.leash import stretched


@compiled
def feel(pose, twist, hands):
    """Draw references along; writes ``stretch``, ``felt`` and ``energy`` of a `Hold`.

    ``pose``, ``twist`` are ``(world, 3)``, world frame; ``hands`` the fields of a
    `coopenv.physics.compliance.Hold`.
    """
    _, _, _, _, _, reference, stretch, _, felt, energy = hands
    num_agents = felt.shape[1]
    world, agents = np.empty((WORLD_FIELDS, LANES)), np.empty((num_agents, AGENT_FIELDS, LANES))
    four, each = four_at(world.ctypes.data), four_at(agents.ctypes.data)
    for first in range(0, len(pose), LANES):
        count = min(LANES, len(pose) - first)
        gather(first, count, pose, twist, hands, world, agents)
        _read(each, num_agents, four)
        for at in range(count):
            for i in range(num_agents):
                for j in range(3):
                    reference[first + at, i, j] = agents[i, REFERENCE + j, at]
                    stretch[first + at, i, j] = agents[i, BASE + j, at]
                    felt[first + at, i, j] = agents[i, FORCE + j, at]
                energy[first + at, i] = agents[i, SLOPE, at]


@fused
def _read(agents, num_agents, world):
    """Write stretch, wrench and energy of a block into ``BASE``, ``FORCE`` and ``SLOPE``."""
    c, s, spin = world[COSINE], world[SINE], world[TWIST + 2]
    for i in range(num_agents):
        at = i * AGENT_FIELDS
        x, y, turn = stretched(agents, at, world)
        across, along = rotated(c, s, -agents[at + GRIP + 1], agents[at + GRIP])  # a unit of spin
        vx = agents[at + VELOCITY] - world[TWIST] - spin * across
        vy = agents[at + VELOCITY + 1] - world[TWIST + 1] - spin * along
        stiff, damp = agents[at + SPRING], agents[at + SPRING + 2]
        fx, fy = stiff * x + damp * vx, stiff * y + damp * vy
        size = larger(root(fx * fx + fy * fy), splat(TINY))
        part = smaller(agents[at + LIMIT] / size, splat(1.0))
        stiff_turn, most = agents[at + SPRING + 1], agents[at + LIMIT + 1]
        torque = stiff_turn * turn + agents[at + SPRING + 3] * (agents[at + VELOCITY + 2] - spin)
        torque = larger(smaller(torque, most), -most)
        fx, fy = rotated_back(c, s, part * fx, part * fy)
        agents[at + FORCE] = fx + agents[at + GIVEN]
        agents[at + FORCE + 1] = fy + agents[at + GIVEN + 1]
        agents[at + FORCE + 2] = torque + agents[at + GIVEN + 2]
        agents[at + SLOPE] = 0.5 * (stiff * (x * x + y * y) + stiff_turn * turn * turn)
        agents[at + BASE], agents[at + BASE + 1] = rotated_back(c, s, x, y)
        agents[at + BASE + 2] = turn
