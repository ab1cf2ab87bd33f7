"""Leash: references that go no farther from their grips than hands have strength to hold."""

from coopenv.compiled import TINY
from coopenv.compiled.kinds import fused_inlined
from coopenv.compiled.lanes.vectors import larger, root, size, splat, where
from coopenv.geometry.frames import rotated
from coopenv.physics.compliance.block import (
    AGENT_FIELDS,
    BASE,
    COSINE,
    GRIP,
    LIMIT,
    POSE,
    REFERENCE,
    SINE,
    SLOPE,
    SPRING,
    VELOCITY,
)


@fused_inlined
def stretched(agents, at, world):
    """Draw an agent's reference along that is beyond its leash; the stretch, world frame."""
    x, y = rotated(world[COSINE], world[SINE], agents[at + GRIP], agents[at + GRIP + 1])
    grip_x, grip_y, angle = world[POSE] + x, world[POSE + 1] + y, world[POSE + 2]
    x, y = agents[at + REFERENCE] - grip_x, agents[at + REFERENCE + 1] - grip_y
    part = _held(agents[at + SPRING], root(x * x + y * y), agents[at + LIMIT])
    x, y = part * x, part * y
    agents[at + REFERENCE] = where(part < 1.0, grip_x + x, agents[at + REFERENCE])
    agents[at + REFERENCE + 1] = where(part < 1.0, grip_y + y, agents[at + REFERENCE + 1])
    turn = agents[at + REFERENCE + 2] - angle
    part = _held(agents[at + SPRING + 1], size(turn), agents[at + LIMIT + 1])
    turn = part * turn
    agents[at + REFERENCE + 2] = where(part < 1.0, angle + turn, agents[at + REFERENCE + 2])
    return x, y, turn


@fused_inlined
def _held(stiff, stretch, most):
    """The part of a stretch that a hand has the strength for; 0 without a spring."""
    force = stiff * stretch
    part = where(force > most, most / larger(force, splat(TINY)), splat(1.0))
    return where(stiff > 0.0, part, splat(0.0))


@fused_inlined
def let_go_on(agents, num_agents, world, step, rate):
    """Draw references along, move them on by a substep, and write what hands give for it."""
    for i in range(num_agents):
        at = i * AGENT_FIELDS
        stretch = stretched(agents, at, world)
        for j in range(3):
            spring, damper = agents[at + SPRING + j // 2], agents[at + SPRING + 2 + j // 2]
            slope, way = spring * 0.5 + damper * rate, step * agents[at + VELOCITY + j]
            agents[at + BASE + j] = spring * stretch[j] + slope * way
            agents[at + REFERENCE + j] += way
            agents[at + SLOPE + j // 2] = slope
