"""Equilibrium: the displacement of a body in a substep at which hands give what brings it there."""

from typing import NamedTuple

from coopenv.arrays import FloatArray
from coopenv.compiled.kinds import fused, fused_inlined
from coopenv.compiled.lanes.vectors import larger, size, some, splat, where
from coopenv.physics.compliance.block import (
    AGILE,
    BORNE,
    CHORD,
    FREE,
    LIGHT,
    MIDDLE,
    MOVED,
    TOTAL,
)
from coopenv.physics.compliance.pull import pulled, turned_by

MOST = 60  # iterations; see docs/accuracy.md
CLOSE = 1e-9  # of forces and torques, that in equilibrium are out by so much at most
_PRESSED = 0.75  # part of inertia's slope that levers may take away
_OVERSHOT = 0.5  # of what a step would gain at first, that it may lose at its end


class Search(NamedTuple):
    """Where Newton's method is, and the step that brought it there; lanes each."""

    x: FloatArray  # [m]
    y: FloatArray
    turn: FloatArray  # [rad]
    dx: FloatArray
    dy: FloatArray
    dt: FloatArray
    gain: FloatArray  # that force and torque at the step's beginning promise of it [J]


@fused
def met(agents, num_agents, world):
    """Newton's method for the displacement of free bodies; how many iterations it took."""
    heavy, slow = 1.0 / world[LIGHT], 1.0 / world[AGILE]
    free_x, free_y = world[FREE] + world[BORNE], world[FREE + 1] + world[BORNE + 1]
    free_turn = world[FREE + 2] + world[BORNE + 2]
    at = search_from(free_x, free_y, free_turn)
    attempt = 0
    while True:
        attempt += 1
        arc = turned_by(world, at.turn)
        pull = pulled(agents, num_agents, at.x, at.y, arc)
        fx, fy = pull.fx - heavy * (at.x - free_x), pull.fy - heavy * (at.y - free_y)
        torque = pull.torque - slow * (at.turn - free_turn)
        out = size(fx) + size(fy) - CLOSE * (pull.load + heavy * (size(at.x) + size(at.y)))
        out = larger(out, size(torque) - CLOSE * (pull.turning + slow * size(at.turn)))
        if attempt == MOST or not some(out > 0.0):
            break
        slopes = (
            heavy + pull.xx,
            pull.xy,
            pull.xt,
            heavy + pull.yy,
            pull.yt,
            turn_slope(pull, slow),
        )
        at = searched(at, out, (fx, fy, torque), slopes)
    keep(world, arc, pull)
    return attempt


@fused
def rolled(agents, num_agents, world):
    """`met` for bodies on wheels, which go along the chord of a circle."""
    heavy, slow = 1.0 / world[LIGHT], 1.0 / world[AGILE]
    zero = splat(0.0)
    at = search_from(world[FREE], zero, world[FREE + 2])
    attempt = 0
    while True:
        attempt += 1
        arc = turned_by(world, at.turn)
        ux, uy = arc.chord * arc.c, arc.chord * arc.s  # displacement for a unit of way
        pull = pulled(agents, num_agents, at.x * ux, at.x * uy, arc)
        force = ux * pull.fx + uy * pull.fy - heavy * (at.x - world[FREE])
        torque = pull.torque - slow * (at.turn - world[FREE + 2])
        out = size(force) - CLOSE * (pull.load + heavy * size(at.x))
        out = larger(out, size(torque) - CLOSE * (pull.turning + slow * size(at.turn)))
        if attempt == MOST or not some(out > 0.0):
            break
        along = heavy + ux * (ux * pull.xx + uy * pull.xy) + uy * (ux * pull.xy + uy * pull.yy)
        mixed, one = ux * pull.xt + uy * pull.yt, splat(1.0)
        slopes = along, zero, mixed, one, zero, turn_slope(pull, slow)
        at = searched(at, out, (force, zero, torque), slopes)
    keep(world, arc, pull)
    world[MOVED], world[MOVED + 1] = at.x * ux, at.x * uy
    return attempt


@fused_inlined
def turn_slope(pull, slow):
    """−∂torque/∂turn, that of inertia included.

    Levers that turn take part as far as they leave the slopes positive definite: hands that press
    on a body from its ends would turn it over.
    """
    return slow + pull.tt + larger(pull.lean, -_PRESSED * slow)


@fused_inlined
def search_from(x, y, turn):
    """A `Search` that begins."""
    zero = splat(0.0)
    return Search(x, y, turn, zero, zero, zero, zero)


@fused_inlined
def searched(at, out, force, slopes):
    """Go on by a step of Newton's method, or part of the last one back, where ``out`` is positive.

    What hands, inertia and friction give together is, but for the turning of levers, the fall of a
    convex function; its corners, where hands reach their limits, Newton's method may jump between
    for ever. So a step at whose end the force points back, by more than a part of what it was
    ahead at the beginning, is shortened to where the straight line between the two is zero.
    """
    fx, fy, torque = force
    ahead = fx * at.dx + fy * at.dy + torque * at.dt
    over = ahead < -_OVERSHOT * at.gain
    part = where(over, at.gain / (at.gain - ahead), splat(1.0))
    dx, dy, dt = solved(*slopes, fx, fy, torque)
    gain = fx * dx + fy * dy + torque * dt
    dx, dy, dt = (
        where(over, part * at.dx, dx), where(over, part * at.dy, dy), where(over, part * at.dt, dt),
    )  # fmt: skip
    less, open_ = part - 1.0, out > 0.0
    return Search(
        where(open_, at.x + where(over, less * at.dx, dx), at.x),
        where(open_, at.y + where(over, less * at.dy, dy), at.y),
        where(open_, at.turn + where(over, less * at.dt, dt), at.turn),
        dx, dy, dt,
        where(over, part * at.gain, gain),
    )  # fmt: skip


@fused
def keep(world, arc, pull):
    """Write what was found into a block."""
    world[MIDDLE], world[MIDDLE + 1], world[CHORD] = arc.c, arc.s, arc.chord
    world[TOTAL], world[TOTAL + 1], world[TOTAL + 2] = pull.fx, pull.fy, pull.torque


@fused_inlined
def solved(xx, xy, xt, yy, yt, tt, ex, ey, et):
    """Solution of a symmetric positive definite system of three, by its cofactors.

    They ask for one division, which takes longer than all the rest.
    """
    first, second, third = yy * tt - yt * yt, xt * yt - xy * tt, xy * yt - xt * yy
    inverse = 1.0 / (xx * first + xy * second + xt * third)
    middle, last, mixed = xx * tt - xt * xt, xx * yy - xy * xy, xt * xy - xx * yt
    return (
        inverse * (first * ex + second * ey + third * et),
        inverse * (second * ex + middle * ey + mixed * et),
        inverse * (third * ex + mixed * ey + last * et),
    )
