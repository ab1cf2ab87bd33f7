"""Block: four worlds whose hands are solved side by side, and where their numbers lie.

The numbers of a world, and those of each agent in it, lie in lanes (`coopenv.compiled.lanes`),
field after field. Where fewer than four worlds are left, the last one fills the block; what becomes
of it there is not read. What comes of a world depends on no other in its block.
"""

import numpy as np

from coopenv.compiled import inlined
from coopenv.compiled.lanes.vectors import LANES
from coopenv.geometry.frames import rotated_back
from coopenv.physics.coefficients import (
    COAST,
    DECAY,
    FALL_PATH,
    FALL_SPEED,
    GROUND_FORCE,
    GROUND_TORQUE,
    INERTIA,
    MASS,
    NODE_PATH,
    PATH_GAIN,
    RUBS,
    SPEED_GAIN,
    SPIN_COAST,
    SPIN_DECAY,
    SPIN_GAIN,
    TURN_GAIN,
    WHEELS,
)

# Fields of an agent, as many in a row as a vector has components.
VELOCITY, SPRING, LIMIT, GRIP, GIVEN, REFERENCE = 0, 3, 7, 9, 11, 14  # as in a `Hold`
BASE, SLOPE, FORCE = 17, 20, 22  # given if the body stays, its fall a unit of way; what is given
AGENT_FIELDS = 25

# Fields of a world: what is known of it,
POSE, TWIST, COSINE, SINE = 0, 3, 6, 7
FREE, FREE_TWIST = 8, 11  # pose change and twist at the end without hands
LIGHT, AGILE = 14, 15  # pose change a unit of force, of torque
LATER, LATER_TURN = 16, 17  # [s] the path of a unit of velocity gained, and of spin
HOLD, HOLD_TURN = 18, 19  # the most that friction on the ground can hold
WEIGHT, HEFT, BULK = 20, 22, 23  # force of gravity, mass and moment of inertia
# what bears it over the path,
BORNE, PART = 24, 27  # pose change, and the part of the contact that is taken to last
LOW, HIGH, BEFORE, GAP = 28, 29, 30, 31  # bounds of the part; the part before and what it was off
# and what is found: direction in the middle, chord by arc, wrench of hands, pose change and twist.
MIDDLE, CHORD, TOTAL, MOVED, REACHED = 32, 34, 35, 38, 41
WORLD_FIELDS = 44

SLIDING, ROLLING, RUBBING = 0, 1, 2  # kinds of ground


@inlined
def ground(table, k):
    """The kind of ground that a world's body is on."""
    return ROLLING if table[k, WHEELS] else RUBBING if table[k, RUBS] else SLIDING


@inlined
def gather(first, count, pose, twist, hands, world, agents):
    """Fill a block with bodies and hands of the ``count`` worlds from ``first`` on."""
    velocity, spring, limit, grips, held, reference, _, _, _, _ = hands
    for at in range(LANES):
        k = first + min(at, count - 1)
        world[COSINE, at], world[SINE, at] = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        for j in range(3):
            world[POSE + j, at], world[TWIST + j, at] = pose[k, j], twist[k, j]
        for i in range(grips.shape[1]):
            for j in range(3):
                agents[i, VELOCITY + j, at] = velocity[k, i, j]
                agents[i, GIVEN + j, at] = held[k, i, j]
                agents[i, REFERENCE + j, at] = reference[k, i, j]
            for j in range(4):
                agents[i, SPRING + j, at] = spring[k, i, j]
            for j in range(2):
                agents[i, LIMIT + j, at] = limit[k, i, j]
                agents[i, GRIP + j, at] = grips[k, i, j]


@inlined
def coast(first, count, table, world):
    """Write how the bodies of a block would move without hands, and how much a wrench changes."""
    for at in range(LANES):
        k = first + min(at, count - 1)
        vx, vy, spin = world[TWIST, at], world[TWIST + 1, at], world[TWIST + 2, at]
        gain = table[k, PATH_GAIN]
        if table[k, WHEELS]:
            vx, _ = rotated_back(world[COSINE, at], world[SINE, at], vx, vy)
            vy, gain = 0.0, table[k, NODE_PATH] + table[k, NODE_PATH + 1] + table[k, NODE_PATH + 2]
        world[FREE, at] = table[k, COAST] * vx + table[k, FALL_PATH]
        world[FREE + 1, at] = table[k, COAST] * vy + table[k, FALL_PATH + 1]
        world[FREE + 2, at] = table[k, SPIN_COAST] * spin
        world[FREE_TWIST, at] = table[k, DECAY] * vx + table[k, FALL_SPEED]
        world[FREE_TWIST + 1, at] = table[k, DECAY] * vy + table[k, FALL_SPEED + 1]
        world[FREE_TWIST + 2, at] = table[k, SPIN_DECAY] * spin
        world[LIGHT, at], world[AGILE, at] = gain, table[k, TURN_GAIN]
        for j in range(3):
            world[BORNE + j, at] = 0.0
        world[PART, at], world[LOW, at], world[HIGH, at], world[GAP, at] = 0.0, 0.0, 1.0, 0.0
        if table[k, RUBS]:
            _rub(k, at, table, world)


@inlined
def _rub(k, at, table, world):
    """Write what only friction on the ground asks for."""
    world[LATER, at] = table[k, PATH_GAIN] / table[k, SPEED_GAIN]
    world[LATER_TURN, at] = table[k, TURN_GAIN] / table[k, SPIN_GAIN]
    world[HOLD, at], world[HOLD_TURN, at] = table[k, GROUND_FORCE], table[k, GROUND_TORQUE]
    world[HEFT, at], world[BULK, at] = table[k, MASS], table[k, INERTIA]
    for j in range(2):
        world[WEIGHT + j, at] = table[k, FALL_SPEED + j] / table[k, SPEED_GAIN]
