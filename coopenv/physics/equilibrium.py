"""Equilibrium: the displacement of a body in a substep at which hands give what brings it there."""

from coopenv.compiled.kinds import fused
from coopenv.compiled.lanes.vectors import larger, size, some, where
from coopenv.physics.block import (
    AGILE,
    BORNE,
    CHORD,
    COSINE,
    FREE,
    LIGHT,
    MIDDLE,
    MOVED,
    SINE,
    TOTAL,
)
from coopenv.physics.pull import pulled, turned_by

NEWTON, MOST = 12, 60  # iterations by Newton's method, and at all
CLOSE = 1e-9  # of forces and torques, that in equilibrium are out by so much at most


@fused
def met(agents, num_agents, world):
    """Newton's method for the displacement of free bodies."""
    c, s, heavy, slow = world[COSINE], world[SINE], 1.0 / world[LIGHT], 1.0 / world[AGILE]
    free_x, free_y = world[FREE] + world[BORNE], world[FREE + 1] + world[BORNE + 1]
    free_turn = world[FREE + 2] + world[BORNE + 2]
    x, y, turn = free_x, free_y, free_turn
    attempt = 0
    while True:
        attempt += 1
        arc = turned_by(c, s, turn)
        pull = pulled(agents, num_agents, x, y, arc, attempt <= NEWTON)
        fx, fy = pull.fx - heavy * (x - free_x), pull.fy - heavy * (y - free_y)
        torque = pull.torque - slow * (turn - free_turn)
        out = size(fx) + size(fy) - CLOSE * (pull.load + heavy * (size(x) + size(y)))
        out = larger(out, size(torque) - CLOSE * (pull.turning + slow * size(turn)))
        if attempt == MOST or not some(out > 0.0):
            break
        dx, dy, dt = solved(
            heavy + pull.xx, pull.xy, pull.xt, heavy + pull.yy, pull.yt, slow + pull.tt,
            fx, fy, torque,
        )  # fmt: skip
        x, y = where(out > 0.0, x + dx, x), where(out > 0.0, y + dy, y)
        turn = where(out > 0.0, turn + dt, turn)
    keep(world, arc, pull)


@fused
def rolled(agents, num_agents, world):
    """`met` for bodies on wheels, which go along the chord of a circle."""
    c, s, heavy, slow = world[COSINE], world[SINE], 1.0 / world[LIGHT], 1.0 / world[AGILE]
    way, turn = world[FREE], world[FREE + 2]
    attempt = 0
    while True:
        attempt += 1
        arc = turned_by(c, s, turn)
        ux, uy = arc.chord * arc.c, arc.chord * arc.s  # displacement for a unit of way
        pull = pulled(agents, num_agents, way * ux, way * uy, arc, attempt <= NEWTON)
        force = ux * pull.fx + uy * pull.fy - heavy * (way - world[FREE])
        torque = pull.torque - slow * (turn - world[FREE + 2])
        out = size(force) - CLOSE * (pull.load + heavy * size(way))
        out = larger(out, size(torque) - CLOSE * (pull.turning + slow * size(turn)))
        if attempt == MOST or not some(out > 0.0):
            break
        ww = heavy + ux * (ux * pull.xx + uy * pull.xy) + uy * (ux * pull.xy + uy * pull.yy)
        wt, tt = ux * pull.xt + uy * pull.yt, slow + pull.tt
        inverse = 1.0 / (ww * tt - wt * wt)
        way = where(out > 0.0, way + (tt * force - wt * torque) * inverse, way)
        turn = where(out > 0.0, turn + (ww * torque - wt * force) * inverse, turn)
    keep(world, arc, pull)
    world[MOVED], world[MOVED + 1] = way * ux, way * uy


@fused
def keep(world, arc, pull):
    """Write what was found into a block."""
    world[MIDDLE], world[MIDDLE + 1], world[CHORD] = arc.c, arc.s, arc.chord
    world[TOTAL], world[TOTAL + 1], world[TOTAL + 2] = pull.fx, pull.fy, pull.torque


@fused
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
