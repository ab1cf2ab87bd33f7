"""Compliant hold: springs and dampers between the references of hands and the grips of a body.

Hand i has a reference in the world; s is the way to it from the grip, φ the turn. It gives

    f = P(K s + B ṡ),    t = P(κ φ + β φ̇)

with P the nearest force, or torque, within the agent's limit. The reference is on a leash: where
K s or κ φ alone would exceed the limit, it is drawn along.

A substep takes the force in the middle, constant in the world frame, and the torque constant:

    f = P(K (s + Δs / 2) + B Δs / h),    t = P(κ (φ + Δφ / 2) + β Δφ / h)

where Δs, Δφ are what really comes of it: a small system of equations, solved by Newton's method.
A free body moves under it as exactly as without hands, drag included; of its turn Δθ the grip at g
makes the chord 2 sin(Δθ / 2) ẑ × R(θ + Δθ / 2) g. With the torque of f taken at the lever of that
chord, Σ f · Δp + t Δθ is the work done on the body. What moves the references, at u and Ω, does
Σ f · u h + t Ω h; the difference is the change of K s² / 2 + κ φ² / 2, and what dampers, limits and
leash take, which is never negative. So under references at rest no substep adds energy, as far as
the equations are solved: they are where no body turns by as much as a radian in a substep.

On wheels the grip follows the chord of a circle, and what the body's path differs from it by (of
third order in h) the reference is moved along.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.physics.coefficients import (
    COAST,
    DECAY,
    FALL_PATH,
    FALL_SPEED,
    HEAVY,
    NODE_PATH,
    PATH_GAIN,
    SPEED_GAIN,
    SPIN_COAST,
    SPIN_DECAY,
    SPIN_GAIN,
    TURN_GAIN,
    WHEELS,
)
from coopenv.physics.motion import Motion, collect, command_to, roll, roll_on, supported

_NEWTON, _MOST = 12, 60  # iterations by Newton's method, and at all
_ROUNDS, _STILL = 12, 1e-12  # solutions beside a contact that bears, and their change [m, rad]
_CLOSE = 1e-9  # of forces and torques, that in equilibrium are out by so much at most


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
    grows by ``share`` of what is given in it; ``stretch`` and ``felt`` are left with what serves
    here: what hands would give if the body stood still, and what they give, world frame.
    """
    velocity, spring, limit, grips, held, reference, base, applied, force, _ = hands
    rate = 1 / step
    for k in range(len(rows)):
        c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        draw(k, pose, c, s, spring, limit, grips, reference, base)
        for i in range(grips.shape[1]):
            for j in range(3):
                stiff = spring[k, i, j // 2]
                slope = stiff / 2 + spring[k, i, 2 + j // 2] * rate
                base[k, i, j] = stiff * base[k, i, j] + slope * step * velocity[k, i, j]
                reference[k, i, j] += step * velocity[k, i, j]
        if table[k, WHEELS]:
            c, s, chord, free = _rolled(table, k, pose, twist, hands, c, s, rate)
        else:
            c, s, chord, free = _pushed(table, k, pose, twist, hands, c, s, rate, expected)
        along = across = 0.0
        for i in range(grips.shape[1]):
            x, y = rotated_back(c, s, force[k, i, 0], force[k, i, 1])
            x, y = chord * x + held[k, i, 0], chord * y + held[k, i, 1]
            along, across = along + x, across + y
            applied[k, i, 0] += share * x
            applied[k, i, 1] += share * y
            applied[k, i, 2] += share * (force[k, i, 2] + held[k, i, 2])
        if table[k, WHEELS]:
            start = pose[k, 2], twist[k, 0], twist[k, 1], twist[k, 2]
            roll_on(table, k, Motion(*start, along, across, 0.0), free[5], step, around)
        command_to(table, k, rows[k], pose, step, free, command, expected)


@inlined
def draw(k, pose, c, s, spring, limit, grips, reference, stretch):
    """Draw references along that are beyond their leash; writes the stretch, world frame."""
    for i in range(grips.shape[1]):
        x, y = rotated(c, s, grips[k, i, 0], grips[k, i, 1])
        grip_x, grip_y = pose[k, 0] + x, pose[k, 1] + y
        x, y = reference[k, i, 0] - grip_x, reference[k, i, 1] - grip_y
        turn = reference[k, i, 2] - pose[k, 2]
        stiff, most = spring[k, i, 0], limit[k, i, 0]
        square = stiff * stiff * (x * x + y * y)
        if stiff == 0.0 or square > most * most:
            part = 0.0 if stiff == 0.0 else most / np.sqrt(square)
            x, y = part * x, part * y
            reference[k, i, 0], reference[k, i, 1] = grip_x + x, grip_y + y
        stiff, most = spring[k, i, 1], limit[k, i, 1]
        if stiff == 0.0 or stiff * abs(turn) > most:
            turn *= 0.0 if stiff == 0.0 else most / (stiff * abs(turn))
            reference[k, i, 2] = pose[k, 2] + turn
        stretch[k, i, 0], stretch[k, i, 1], stretch[k, i, 2] = x, y, turn


@inlined
def _pushed(table, k, pose, twist, hands, start_c, start_s, rate, expected):
    """A free body's substep: direction in its middle, chord by arc, and what `advance` returns.

    Gravity is met exactly. What the contact that lasts (`coopenv.physics.motion.supported`) bears
    depends on what hands give, and that on how far it bears the body: solved in turn.
    """
    vx, vy, spin = twist[k, 0], twist[k, 1], twist[k, 2]
    free_x = table[k, COAST] * vx + table[k, FALL_PATH]
    free_y = table[k, COAST] * vy + table[k, FALL_PATH + 1]
    free_turn = table[k, SPIN_COAST] * spin
    gain, grown = table[k, PATH_GAIN], table[k, SPEED_GAIN]
    borne_x = borne_y = borne_turn = 0.0
    rounds = 0
    while True:
        c, s, chord, pull = _met(
            table, k, hands, start_c, start_s, rate,
            free_x + borne_x, free_y + borne_y, free_turn + borne_turn,
        )  # fmt: skip
        x, y = free_x + gain * pull.fx, free_y + gain * pull.fy
        turn = free_turn + table[k, TURN_GAIN] * pull.torque
        end_x = table[k, DECAY] * vx + table[k, FALL_SPEED] + grown * pull.fx
        end_y = table[k, DECAY] * vy + table[k, FALL_SPEED + 1] + grown * pull.fy
        end_spin = table[k, SPIN_DECAY] * spin + table[k, SPIN_GAIN] * pull.torque
        moved = (x + borne_x, y + borne_y, turn + borne_turn, end_x, end_y, end_spin)
        rounds += 1
        if rounds == _ROUNDS or not table[k, HEAVY]:
            break
        bare, start = (x, y, turn, end_x, end_y, end_spin), (vx, vy, spin)
        more_x, more_y, more_turn = supported(table, k, start, expected, bare, 1 / rate)
        change = abs(more_x - borne_x) + abs(more_y - borne_y) + abs(more_turn - borne_turn)
        if change <= _STILL:
            break
        borne_x, borne_y, borne_turn = more_x, more_y, more_turn
    return c, s, chord, moved


@inlined
def _met(table, k, hands, start_c, start_s, rate, free_x, free_y, free_turn):
    """Newton's method for the displacement of a free body that moves ``free`` without hands."""
    turn_gain = table[k, TURN_GAIN]
    heavy, slow = 1 / table[k, PATH_GAIN], 1 / turn_gain
    x, y, turn = free_x, free_y, free_turn
    attempt = 0
    while True:
        attempt += 1
        c, s, chord = _middle(start_c, start_s, turn / 2)
        pull = _pull(k, hands, rate, x, y, turn, chord, c, s, attempt <= _NEWTON)
        fx, fy = pull.fx - heavy * (x - free_x), pull.fy - heavy * (y - free_y)
        torque = pull.torque - slow * (turn - free_turn)
        close = abs(fx) + abs(fy) <= _CLOSE * (pull.load + heavy * (abs(x) + abs(y)))
        close = close and abs(torque) <= _CLOSE * (pull.turning + slow * abs(turn))
        if close or attempt == _MOST:
            break
        dx, dy, dt = _solved(
            heavy + pull.xx, pull.xy, pull.xt, heavy + pull.yy, pull.yt, slow + pull.tt,
            fx, fy, torque,
        )  # fmt: skip
        x, y, turn = x + dx, y + dy, turn + dt
    return c, s, chord, pull


@inlined
def _rolled(table, k, pose, twist, hands, start_c, start_s, rate):
    """`_pushed` for a body on wheels; moves references by what the chord leaves of its path."""
    grips, reference = hands[3], hands[5]
    speed, _ = rotated_back(start_c, start_s, twist[k, 0], twist[k, 1])
    free_way, free_turn = table[k, COAST] * speed, table[k, SPIN_COAST] * twist[k, 2]
    gain = table[k, NODE_PATH] + table[k, NODE_PATH + 1] + table[k, NODE_PATH + 2]
    heavy, slow = 1 / gain, 1 / table[k, TURN_GAIN]
    way, turn = free_way, free_turn
    attempt = 0
    while True:
        attempt += 1
        c, s, chord = _middle(start_c, start_s, turn / 2)
        ux, uy = chord * c, chord * s  # displacement for a unit of way
        pull = _pull(k, hands, rate, way * ux, way * uy, turn, chord, c, s, attempt <= _NEWTON)
        thrust = ux * pull.fx + uy * pull.fy
        force, torque = thrust - heavy * (way - free_way), pull.torque - slow * (turn - free_turn)
        close = abs(force) <= _CLOSE * (pull.load + heavy * abs(way))
        close = close and abs(torque) <= _CLOSE * (pull.turning + slow * abs(turn))
        if close or attempt == _MOST:
            break
        ww = heavy + ux * (ux * pull.xx + uy * pull.xy) + uy * (ux * pull.xy + uy * pull.yy)
        wt, tt = ux * pull.xt + uy * pull.yt, slow + pull.tt
        size = ww * tt - wt * wt
        way, turn = (
            way + (tt * force - wt * torque) / size,
            turn + (ww * torque - wt * force) / size,
        )
    moved = roll(
        table,
        k,
        Motion(pose[k, 2], twist[k, 0], twist[k, 1], twist[k, 2], thrust, 0.0, pull.torque),
    )
    for i in range(grips.shape[1]):
        reference[k, i, 0] += moved[0] - way * ux
        reference[k, i, 1] += moved[1] - way * uy
    return c, s, chord, moved


class Pull(NamedTuple):
    """What hands give at a displacement of their body, and how it falls with the displacement."""

    fx: float  # world frame [N]
    fy: float
    torque: float  # at the centre of mass [N·m]
    load: float  # sum of the forces' magnitudes, held ones included [N]
    turning: float  # likewise of torques [N·m]
    xx: float  # −∂f/∂displacement, symmetric
    xy: float
    xt: float
    yy: float
    yt: float
    tt: float


@inlined
def _pull(k, hands, rate, dx, dy, turn, chord, c, s, newton):
    """A `Pull` at a displacement of the body; writes each hand's force and torque, world frame.

    Without ``newton``, saturated hands are given the slope from no force to theirs, which bounds
    the true one from above: steps are shorter then and end everywhere.
    """
    _, spring, limit, grips, held, _, base, _, force, _ = hands
    fx = fy = torque = load = turning = 0.0
    xx = xy = xt = yy = yt = tt = 0.0
    for i in range(grips.shape[1]):
        x, y = rotated(c, s, grips[k, i, 0], grips[k, i, 1])
        x, y = chord * x, chord * y  # lever of the chord
        slope, most = spring[k, i, 0] / 2 + spring[k, i, 2] * rate, limit[k, i, 0]
        px, py = base[k, i, 0] - slope * (dx - turn * y), base[k, i, 1] - slope * (dy + turn * x)
        square = px * px + py * py
        jx, jy, cross = slope, slope, 0.0
        if square > most * most:
            part = 1 / np.sqrt(square)
            nx, ny = part * px, part * py
            slope = most * part * slope
            px, py, jx, jy = most * nx, most * ny, slope, slope
            if newton:
                jx, jy, cross = slope * ny * ny, slope * nx * nx, -slope * nx * ny
        slope, most = spring[k, i, 1] / 2 + spring[k, i, 3] * rate, limit[k, i, 1]
        pt = base[k, i, 2] - slope * turn
        if abs(pt) > most:
            slope = 0.0 if newton else slope * most / abs(pt)
            pt = most if pt > 0.0 else -most
        force[k, i, 0], force[k, i, 1], force[k, i, 2] = px, py, pt
        across, along = cross * x - jx * y, jy * x - cross * y
        xx, xy, yy = xx + jx, xy + cross, yy + jy
        xt, yt, tt = xt + across, yt + along, tt + slope - y * across + x * along
        hx, hy = rotated(c, s, held[k, i, 0], held[k, i, 1])
        fx, fy = fx + px + chord * hx, fy + py + chord * hy
        own = x * (py + hy) - y * (px + hx)
        torque += own + pt + held[k, i, 2]
        load += abs(px) + abs(py) + abs(hx) + abs(hy)
        turning += abs(own) + abs(pt) + abs(held[k, i, 2])
    return Pull(fx, fy, torque, load, turning, xx, xy, xt, yy, yt, tt)


@inlined
def _middle(c, s, half):
    """A direction turned on by ``half`` a turn, and chord by arc of the whole turn."""
    z = half * half
    if z < 0.06:  # series, to rounding
        cosine = 1 + z * (-1 / 2 + z * (1 / 24 + z * (-1 / 720 + z * (1 / 40320 - z / 3628800))))
        chord = 1 + z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z * (1 / 362880 - z / 39916800))))
    else:
        cosine, chord = np.cos(half), np.sin(half) / half
    sine = chord * half
    return c * cosine - s * sine, s * cosine + c * sine, chord


@inlined
def _solved(xx, xy, xt, yy, yt, tt, ex, ey, et):
    """Solution of a symmetric positive definite system of three, by elimination."""
    inverse = 1 / xx
    ly, lt = xy * inverse, xt * inverse
    yy, yt, tt = yy - ly * xy, yt - ly * xt, tt - lt * xt
    ey, et = ey - ly * ex, et - lt * ex
    other = 1 / yy
    low = yt * other
    dt = (et - low * ey) / (tt - low * yt)
    dy = (ey - yt * dt) * other
    return (ex - xy * dy - xt * dt) * inverse, dy, dt


@compiled
def collect_and_hold(rows, table, rooms, buffers, expected, reached, hands, step, share):
    """`collect` one substep and `hold` the next, in one call from Python."""
    report, command = buffers
    pose, twist, impulse, shift, around = reached
    lost = collect(rows, table, rooms, report, expected, pose, twist, impulse, shift, around)
    hold(rows, table, pose, twist, hands, step, share, command, expected, around)
    return lost


@compiled
def feel(pose, twist, hands):
    """What hands feel and store at the end of a step: writes stretch, ``felt`` and ``energy``."""
    velocity, spring, limit, grips, held, reference, stretch, _, felt, energy = hands
    for k in range(len(pose)):
        c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        draw(k, pose, c, s, spring, limit, grips, reference, stretch)
        for i in range(grips.shape[1]):
            x, y, turn = stretch[k, i, 0], stretch[k, i, 1], stretch[k, i, 2]
            across, along = rotated(c, s, -grips[k, i, 1], grips[k, i, 0])  # a unit of spin
            vx = velocity[k, i, 0] - twist[k, 0] - twist[k, 2] * across
            vy = velocity[k, i, 1] - twist[k, 1] - twist[k, 2] * along
            fx = spring[k, i, 0] * x + spring[k, i, 2] * vx
            fy = spring[k, i, 0] * y + spring[k, i, 2] * vy
            size = np.sqrt(fx * fx + fy * fy)
            part = limit[k, i, 0] / size if size > limit[k, i, 0] else 1.0
            torque = spring[k, i, 1] * turn + spring[k, i, 3] * (velocity[k, i, 2] - twist[k, 2])
            torque = min(max(torque, -limit[k, i, 1]), limit[k, i, 1])
            fx, fy = rotated_back(c, s, part * fx, part * fy)
            felt[k, i, 0], felt[k, i, 1] = fx + held[k, i, 0], fy + held[k, i, 1]
            felt[k, i, 2] = torque + held[k, i, 2]
            energy[k, i] = (spring[k, i, 0] * (x * x + y * y) + spring[k, i, 1] * turn * turn) / 2
            stretch[k, i, 0], stretch[k, i, 1] = rotated_back(c, s, x, y)
