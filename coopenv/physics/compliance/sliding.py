"""Sliding: hands on a body that rubs on its ground, solved together with friction.

Friction is against the twist v at the end of the substep, as in `coopenv.physics.friction`:
w = −(F² v, T² ω) / √(F² ‖v‖² + T² ω²). Where what it would have to hold lies in its ellipsoid, the
body comes to rest, and the path is part of that of a twist that falls evenly to 0.

Along the path friction gives no energy unless forces turn the motion round within the substep.
There the body stops too, no farther on than its kinetic energy takes it against hands and gravity,
and goes on in the next substep. So with friction as without, hands at rest never feed energy in,
also where the equations are not solved: friction is then what is left of the balance of momentum.
"""

from coopenv.compiled import TINY
from coopenv.compiled.kinds import fused, fused_inlined
from coopenv.compiled.lanes.vectors import (
    element,
    larger,
    root,
    size,
    smaller,
    some,
    splat,
    together,
    where,
)
from coopenv.physics.compliance.block import (
    AGILE,
    BORNE,
    BULK,
    FREE,
    FREE_TWIST,
    HEFT,
    HOLD,
    HOLD_TURN,
    LATER,
    LATER_TURN,
    LIGHT,
    MOVED,
    REACHED,
    TWIST,
    WEIGHT,
)
from coopenv.physics.compliance.equilibrium import (
    CLOSE,
    MOST,
    keep,
    search_from,
    searched,
    turn_slope,
)
from coopenv.physics.compliance.pull import pulled, turned_by
from coopenv.physics.friction import until_rest


@fused
def slid(agents, num_agents, world):
    """Newton's method for the displacement of bodies that rub; how many iterations it took."""
    heavy, slow = 1.0 / world[LIGHT], 1.0 / world[AGILE]
    later, later_turn = world[LATER], world[LATER_TURN]
    square, square_turn = world[HOLD] * world[HOLD], world[HOLD_TURN] * world[HOLD_TURN]
    free_x, free_y = world[FREE] + world[BORNE], world[FREE + 1] + world[BORNE + 1]
    free_turn = world[FREE + 2] + world[BORNE + 2]
    rest_x = free_x - later * world[FREE_TWIST]  # of a body that is at rest at the end
    rest_y = free_y - later * world[FREE_TWIST + 1]
    rest_turn = free_turn - later_turn * world[FREE_TWIST + 2]
    at = search_from(rest_x, rest_y, rest_turn)
    arc = turned_by(world, at.turn)
    pull = pulled(agents, num_agents, at.x, at.y, arc)
    fx, fy = pull.fx - heavy * (at.x - free_x), pull.fy - heavy * (at.y - free_y)
    torque = pull.torque - slow * (at.turn - free_turn)
    dx, dy, dt = fx / square, fy / square, torque / square_turn
    asked = fx * dx + fy * dy + torque * dt
    slides, resting = asked > 1.0, _stopping(world, pull, rest_x, rest_y, rest_turn)
    bends = dx * ((heavy + pull.xx) * dx + 2.0 * (pull.xy * dy + pull.xt * dt))
    bends += dy * ((heavy + pull.yy) * dy + 2.0 * pull.yt * dt) + dt * (slow + pull.tt) * dt
    ahead = (asked - root(larger(asked, splat(1.0)))) / bends
    at = search_from(rest_x + ahead * dx, rest_y + ahead * dy, rest_turn + ahead * dt)
    attempt = 0
    while True:
        attempt += 1
        vx, vy = (at.x - rest_x) / later, (at.y - rest_y) / later
        spin = (at.turn - rest_turn) / later_turn
        norm = root(square * (vx * vx + vy * vy) + square_turn * spin * spin)
        part = 1.0 / larger(norm, splat(TINY))
        nx, ny, nt = square * part * vx, square * part * vy, square_turn * part * spin
        arc = turned_by(world, at.turn)
        pull = pulled(agents, num_agents, at.x, at.y, arc)
        fx, fy = pull.fx - heavy * (at.x - free_x), pull.fy - heavy * (at.y - free_y)
        torque = pull.torque - slow * (at.turn - free_turn)
        rub, rub_turn = square * part / later, square_turn * part / later_turn
        bend, bend_turn, mixed = part / later, part / later_turn, part / root(later * later_turn)
        fx, fy, torque = fx - nx, fy - ny, torque - nt
        out = size(fx) + size(fy)
        out -= CLOSE * (pull.load + world[HOLD] + heavy * (size(at.x) + size(at.y)))
        turning = pull.turning + world[HOLD_TURN] + slow * size(at.turn)
        out = where(slides, larger(out, size(torque) - CLOSE * turning), splat(0.0))
        if attempt == MOST or not some(out > 0.0):
            break
        slopes = (
            heavy + pull.xx + rub - bend * nx * nx,
            pull.xy - bend * nx * ny,
            pull.xt - mixed * nx * nt,
            heavy + pull.yy + rub - bend * ny * ny,
            pull.yt - mixed * ny * nt,
            turn_slope(pull, slow) + rub_turn - bend_turn * nt * nt,
        )
        at = searched(at, out, (fx, fy, torque), slopes)
    taken = (fx + nx) * at.x + (fy + ny) * at.y + (torque + nt) * at.turn  # by friction [J]
    slides = where(slides, taken, splat(-1.0)) >= 0.0
    x, y = where(slides, at.x, resting * rest_x), where(slides, at.y, resting * rest_y)
    turn = where(slides, at.turn, resting * rest_turn)
    arc = turned_by(world, turn)
    pull = pulled(agents, num_agents, x, y, arc)
    keep(world, arc, pull)
    world[MOVED], world[MOVED + 1], world[MOVED + 2] = x, y, turn
    world[REACHED] = where(slides, (x - rest_x) / later, splat(0.0))
    world[REACHED + 1] = where(slides, (y - rest_y) / later, splat(0.0))
    world[REACHED + 2] = where(slides, (turn - rest_turn) / later_turn, splat(0.0))
    return attempt


@fused_inlined
def _stopping(world, pull, x, y, turn):
    """The part of the path to rest at the end that a body goes which rests before."""
    vx, vy, spin = world[TWIST], world[TWIST + 1], world[TWIST + 2]
    energy = 0.5 * (world[HEFT] * (vx * vx + vy * vy) + world[BULK] * spin * spin)
    against = -(pull.fx + world[WEIGHT]) * x - (pull.fy + world[WEIGHT + 1]) * y
    against = against - pull.torque * turn
    part = where(against > energy, energy / larger(against, splat(TINY)), splat(1.0))
    gain, gain_turn = world[LIGHT] / world[LATER], world[AGILE] / world[LATER_TURN]
    end_x = world[FREE_TWIST] + gain * pull.fx
    end_y = world[FREE_TWIST + 1] + gain * pull.fy
    end_spin = world[FREE_TWIST + 2] + gain_turn * pull.torque
    most, most_spin = gain * world[HOLD], gain_turn * world[HOLD_TURN]
    rest = together(
        _rest(0, most, most_spin, vx, vy, spin, end_x, end_y, end_spin),
        _rest(1, most, most_spin, vx, vy, spin, end_x, end_y, end_spin),
        _rest(2, most, most_spin, vx, vy, spin, end_x, end_y, end_spin),
        _rest(3, most, most_spin, vx, vy, spin, end_x, end_y, end_spin),
    )
    return smaller(part, rest)


@fused_inlined
def _rest(at, most, most_spin, vx, vy, spin, end_x, end_y, end_spin):
    """`until_rest` of one lane."""
    return until_rest(
        element(most, at), element(most_spin, at),
        (element(vx, at), element(vy, at), element(spin, at)),
        (element(end_x, at), element(end_y, at), element(end_spin, at)),
    )  # fmt: skip
