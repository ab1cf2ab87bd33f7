"""A substep of bodies that hands hold: four worlds at a time, gathered, solved and written back."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled, inlined
from coopenv.compiled.lanes.memory import four_at
from coopenv.compiled.lanes.vectors import LANES
from coopenv.geometry.frames import rotated_back
from coopenv.physics.coefficients import HEAVY
from coopenv.physics.compliance.bearing import ROUNDS, borne_on, unborne
from coopenv.physics.compliance.block import (
    AGENT_FIELDS,
    BORNE,
    CHORD,
    FORCE,
    MIDDLE,
    MOVED,
    POSE,
    REACHED,
    REFERENCE,
    ROLLING,
    RUBBING,
    SLIDING,
    TOTAL,
    TWIST,
    WORLD_FIELDS,
    coast,
    gather,
    ground,
)
from coopenv.physics.compliance.equilibrium import met, rolled
from coopenv.physics.compliance.leash import let_go_on
from coopenv.physics.compliance.sliding import slid
from coopenv.physics.motion import Motion, command_to, roll, roll_on


class Hold(NamedTuple):
    """What hands do in a control step, and where they are; ``(world, agent, …)`` each.

    Agents without a hand have zeros for ``spring`` and give what they hold.
    """

    velocity: FloatArray  # (…, 3) of the references, world frame [m/s, rad/s]
    spring: FloatArray  # (…, 4): K [N/m], κ [N·m/rad], B [N·s/m], β [N·m·s/rad]
    limit: FloatArray  # (…, 2): force [N] and torque [N·m]
    grips: FloatArray  # (…, 2) object frame [m]
    held: FloatArray  # (…, 3) wrench without a hand, object frame [N, N·m]
    reference: FloatArray  # (…, 3) world frame [m, rad], goes on
    stretch: FloatArray  # (…, 3) written: from grip to reference, object frame [m, rad]
    applied: FloatArray  # (…, 3) written: mean wrench, object frame [N, N·m]
    felt: FloatArray  # (…, 3) written: wrench at the end, object frame [N, N·m]
    energy: FloatArray  # (…) written: stored at the end [J]


@compiled
def hold(rows, table, pose, twist, hands, step, share, command, expected, around):
    """`coopenv.physics.motion.drive` for bodies that hands hold.

    ``hands`` are the fields of a `Hold`, of which references go on by a substep and the mean wrench
    grows by ``share`` of what is given in it. What wheels hold is added to ``around``
    (`coopenv.physics.surroundings`).
    """
    num_agents = hands[3].shape[1]
    world, agents = np.empty((WORLD_FIELDS, LANES)), np.empty((num_agents, AGENT_FIELDS, LANES))
    four, each = four_at(world.ctypes.data), four_at(agents.ctypes.data)
    for first in range(0, len(rows), LANES):
        count = min(LANES, len(rows) - first)
        gather(first, count, pose, twist, hands, world, agents)
        coast(first, count, table, world)
        let_go_on(each, num_agents, four, step, 1 / step)
        for kind in range(3):
            found = 0
            for k in range(first, first + count):
                found += ground(table, k) == kind
            if found == 0:
                continue
            _solve(kind, first, count, each, num_agents, four, world, table, expected, step)
            for at in range(count):
                k = first + at
                if ground(table, k) == kind:
                    free = _moved(kind, table, k, world, at, agents)
                    along, across = _give(k, at, world, agents, hands, share)
                    if kind == ROLLING:
                        start = pose[k, 2], twist[k, 0], twist[k, 1], twist[k, 2]
                        motion = Motion(*start, along, across, 0.0)
                        roll_on(table, k, motion, free[5], step, around)
                    command_to(table, k, rows[k], pose, step, free, command, expected)


@inlined
def _solve(kind, first, count, each, num_agents, four, world, table, expected, step):
    """Find what a substep comes to in the worlds of a block with one kind of ground.

    What the contact that lasts (`coopenv.physics.motion.lasting_part`) bears depends on what hands
    give, and that on how far it bears the body: solved in turn.
    """
    rounds = 0
    while True:
        if kind == ROLLING:
            rolled(each, num_agents, four)
        elif kind == RUBBING:
            slid(each, num_agents, four)
        else:
            met(each, num_agents, four)
        rounds += 1
        changed = False
        for at in range(count):
            k = first + at
            if table[k, HEAVY] and ground(table, k) == kind and rounds < ROUNDS:
                changed |= borne_on(table, k, at, world, expected, step)
        if not changed:
            break


@inlined
def _moved(kind, table, k, world, at, agents):
    """Pose change and twist of a world, as `coopenv.physics.motion.advance` returns them.

    On wheels, references are moved by what the chord leaves of the path.
    """
    if kind == RUBBING:
        return (
            world[MOVED, at], world[MOVED + 1, at], world[MOVED + 2, at],
            world[REACHED, at], world[REACHED + 1, at], world[REACHED + 2, at],
        )  # fmt: skip
    fx, fy, torque = world[TOTAL, at], world[TOTAL + 1, at], world[TOTAL + 2, at]
    if kind == SLIDING:
        x, y, turn, vx, vy, spin = unborne(table, k, world, at)
        x, y, turn = x + world[BORNE, at], y + world[BORNE + 1, at], turn + world[BORNE + 2, at]
        return x, y, turn, vx, vy, spin
    thrust = world[CHORD, at] * (world[MIDDLE, at] * fx + world[MIDDLE + 1, at] * fy)
    vx, vy, spin = world[TWIST, at], world[TWIST + 1, at], world[TWIST + 2, at]
    free = roll(table, k, Motion(world[POSE + 2, at], vx, vy, spin, thrust, 0.0, torque))
    for i in range(len(agents)):
        agents[i, REFERENCE, at] += free[0] - world[MOVED, at]
        agents[i, REFERENCE + 1, at] += free[1] - world[MOVED + 1, at]
    return free


@inlined
def _give(k, at, world, agents, hands, share):
    """Add what hands give in a substep to their mean wrench, and write where references are.

    Returns the sum of their forces, object frame [N].
    """
    _, _, _, _, held, reference, _, applied, _, _ = hands
    c, s, chord = world[MIDDLE, at], world[MIDDLE + 1, at], world[CHORD, at]
    along = across = 0.0
    for i in range(len(agents)):
        x, y = rotated_back(c, s, agents[i, FORCE, at], agents[i, FORCE + 1, at])
        x, y = chord * x + held[k, i, 0], chord * y + held[k, i, 1]
        along, across = along + x, across + y
        applied[k, i, 0] += share * x
        applied[k, i, 1] += share * y
        applied[k, i, 2] += share * (agents[i, FORCE + 2, at] + held[k, i, 2])
        for j in range(3):
            reference[k, i, j] = agents[i, REFERENCE + j, at]
    return along, across
