"""Pull: what hands give at a displacement of their body, and how it falls with the displacement."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import TINY
from coopenv.compiled.kinds import fused_inlined
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
from coopenv.geometry.frames import rotated
from coopenv.physics.compliance.block import (
    AGENT_FIELDS,
    BASE,
    COSINE,
    FORCE,
    GIVEN,
    GRIP,
    LIMIT,
    SINE,
    SLOPE,
)

_SMALL = 0.06  # [rad²] of half a turn, for which a series is true to rounding


class Pull(NamedTuple):
    """What hands give together; lanes each."""

    fx: FloatArray  # world frame [N]
    fy: FloatArray
    torque: FloatArray  # at the centre of mass [N·m]
    load: FloatArray  # sum of the forces' magnitudes, held ones included [N]
    turning: FloatArray  # likewise of torques [N·m]
    xx: FloatArray  # −∂f/∂displacement, symmetric
    xy: FloatArray
    xt: FloatArray
    yy: FloatArray
    yt: FloatArray
    tt: FloatArray
    lean: FloatArray  # what of −∂torque/∂turn is from levers that turn by half the turn


class Arc(NamedTuple):
    """A turn, seen from its middle; lanes each."""

    turn: FloatArray  # [rad]
    c: FloatArray  # direction in the middle
    s: FloatArray
    chord: FloatArray  # by arc


@fused_inlined
def pulled(agents, num_agents, dx, dy, arc):
    """A `Pull` at a displacement of the body; writes each hand's force and torque, world frame."""
    zero = splat(0.0)
    fx, fy, torque, load, turning, lean = zero, zero, zero, zero, zero, zero
    xx, xy, xt, yy, yt, tt = zero, zero, zero, zero, zero, zero
    for i in range(num_agents):
        at = i * AGENT_FIELDS
        x, y = rotated(arc.c, arc.s, agents[at + GRIP], agents[at + GRIP + 1])
        x, y = arc.chord * x, arc.chord * y  # lever of the chord
        slope, most = agents[at + SLOPE], agents[at + LIMIT]
        px = agents[at + BASE] - slope * (dx - arc.turn * y)
        py = agents[at + BASE + 1] - slope * (dy + arc.turn * x)
        square = px * px + py * py
        part = 1.0 / root(larger(square, splat(TINY)))
        over = square > most * most
        nx, ny = part * px, part * py
        px, py = where(over, most * nx, px), where(over, most * ny, py)
        bound = most * part * slope
        jx, jy = where(over, bound * ny * ny, slope), where(over, bound * nx * nx, slope)
        cross = where(over, -(bound * nx * ny), zero)
        slope, most = agents[at + SLOPE + 1], agents[at + LIMIT + 1]
        free = agents[at + BASE + 2] - slope * arc.turn
        pt = larger(smaller(free, most), -most)
        stiff = where(size(free) > most, zero, slope)
        agents[at + FORCE], agents[at + FORCE + 1], agents[at + FORCE + 2] = px, py, pt
        across, along = cross * x - jx * y, jy * x - cross * y
        xx, xy, yy = xx + jx, xy + cross, yy + jy
        xt, yt, tt = xt + across, yt + along, tt + stiff - y * across + x * along
        hx, hy = rotated(arc.c, arc.s, agents[at + GIVEN], agents[at + GIVEN + 1])
        fx, fy = fx + px + arc.chord * hx, fy + py + arc.chord * hy
        own, away = x * (py + hy) - y * (px + hx), x * (px + hx) + y * (py + hy)
        lean += 0.5 * away
        torque += own + pt + agents[at + GIVEN + 2]
        load += size(px) + size(py) + size(hx) + size(hy)
        turning += size(own) + size(pt) + size(agents[at + GIVEN + 2])
    return Pull(fx, fy, torque, load, turning, xx, xy, xt, yy, yt, tt, lean)


@fused_inlined
def turned_by(world, turn):
    """The `Arc` of a turn by bodies of a block."""
    c, s = world[COSINE], world[SINE]
    half = turn * 0.5
    z = half * half
    cosine = 1 + z * (-1 / 2 + z * (1 / 24 + z * (-1 / 720 + z * (1 / 40320 - z * (1 / 3628800)))))
    chord = 1 + z * (
        -1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z * (1 / 362880 - z * (1 / 39916800))))
    )
    if some(z > _SMALL):
        cosine = where(z > _SMALL, _cosine(half), cosine)
        chord = where(z > _SMALL, _sine(half) / half, chord)
    sine = chord * half
    return Arc(turn, c * cosine - s * sine, s * cosine + c * sine, chord)


@fused_inlined
def _cosine(x):
    return together(
        np.cos(element(x, 0)), np.cos(element(x, 1)), np.cos(element(x, 2)), np.cos(element(x, 3))
    )


@fused_inlined
def _sine(x):
    return together(
        np.sin(element(x, 0)), np.sin(element(x, 1)), np.sin(element(x, 2)), np.sin(element(x, 3))
    )
