"""Bearing: how far a contact that lasts bears a body that hands hold, found by its part."""

from coopenv.compiled import inlined
from coopenv.physics.coefficients import (
    PATH_GAIN,
    SPEED_GAIN,
    SPIN_GAIN,
    TURN_GAIN,
)
from coopenv.physics.compliance.block import (
    BEFORE,
    BORNE,
    FREE,
    FREE_TWIST,
    GAP,
    HIGH,
    LOW,
    PART,
    TOTAL,
    TWIST,
)
from coopenv.physics.motion import borne, lasting_part

ROUNDS = 60  # solutions beside a contact, of which a halving of the bounds needs no more
_STILL = 1e-12  # change of pose [m, rad] from a solution to the next, below which it is the last


@inlined
def unborne(table, k, world, at):
    """Pose change and twist of a world that hands move, as if nothing bore it."""
    fx, fy, torque = world[TOTAL, at], world[TOTAL + 1, at], world[TOTAL + 2, at]
    return (
        world[FREE, at] + table[k, PATH_GAIN] * fx,
        world[FREE + 1, at] + table[k, PATH_GAIN] * fy,
        world[FREE + 2, at] + table[k, TURN_GAIN] * torque,
        world[FREE_TWIST, at] + table[k, SPEED_GAIN] * fx,
        world[FREE_TWIST + 1, at] + table[k, SPEED_GAIN] * fy,
        world[FREE_TWIST + 2, at] + table[k, SPIN_GAIN] * torque,
    )


@inlined
def borne_on(table, k, at, world, expected, step):
    """Choose how far the contact bears next, from what came of the last choice; whether it changed.

    What is asked of the contact, g(p), is a continuous function of the part p that it was taken to
    bear, and in [0, 1] as p is: so g(p) = p somewhere. The rule is p ← g(p) first, then the secant
    where that stays between bounds on whose sides g(p) − p has either sign, else their middle.
    """
    start = world[TWIST, at], world[TWIST + 1, at], world[TWIST + 2, at]
    part = world[PART, at]
    gap = lasting_part(table, k, start, expected, unborne(table, k, world, at), step) - part
    dx, dy, turn = borne(table, k, expected, gap)
    if abs(dx) + abs(dy) + abs(turn) <= _STILL:
        return False
    if gap > 0.0:
        world[LOW, at] = part
    else:
        world[HIGH, at] = part
    low, high, then = world[LOW, at], world[HIGH, at], part + gap
    if world[GAP, at] != 0.0:
        then = part - gap * (part - world[BEFORE, at]) / (gap - world[GAP, at])
        if not low < then < high:
            then = (low + high) / 2
    world[BEFORE, at], world[GAP, at], world[PART, at] = part, gap, then
    world[BORNE, at], world[BORNE + 1, at], world[BORNE + 2, at] = borne(table, k, expected, then)
    return then != part
