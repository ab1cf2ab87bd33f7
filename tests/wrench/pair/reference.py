"""Least cost of two planar effectors in 60 decimal digits, by nested golden-section searches.

Written down again from eqs. 17-21 and nothing else: g = (u, v) is the internal force on effector 1
in a frame along the line through the grips. Of each v the feasible u are an interval, and the cost
is convex. Numbers are read as the exact values of the floats.
"""

from collections.abc import Callable
from decimal import Context, Decimal, localcontext
from typing import NamedTuple

from coopenv.arrays import FloatArray

STEPS = 130  # golden sections: down to 1e-27 of the bracket
GOLDEN = (Decimal(5).sqrt() - 1) / 2
ZERO, NEVER = Decimal(0), Decimal("Infinity")
Vector = tuple[Decimal, Decimal]


class Pair(NamedTuple):
    """A wrench and its grips in the frame along their line."""

    force: tuple[Vector, Vector]
    torque: Vector
    grip: tuple[Vector, Vector]
    distance: Decimal  # from grip to grip
    weight: Decimal  # w
    induced: bool  # s


def least_cost(
    applied: FloatArray, grips: FloatArray, torque_weight: float = 0.5, induced: bool = False
) -> float:
    """J(h_M) of the optimum, of ``applied`` ``(2, 3)`` at ``grips`` ``(2, 2)``."""
    with localcontext(Context(prec=60)):
        pair = _read(applied, grips, torque_weight, induced)
        reach = sum((_norm(force) for force in pair.force), ZERO)
        at_zero = _at_height(pair, ZERO)
        up = _minimum(lambda v: _at_height(pair, v), reach)
        down = _minimum(lambda v: _at_height(pair, -v), reach)
        return float(min(at_zero, up, down))


def _read(applied: FloatArray, grips: FloatArray, torque_weight: float, induced: bool) -> Pair:
    h = [[Decimal(float(part)) for part in row] for row in applied]
    r1, r2 = ((Decimal(float(x)), Decimal(float(y))) for x, y in grips)
    along = (r1[0] - r2[0], r1[1] - r2[1])
    distance = _norm(along)
    along = along if distance else r1  # of grips at one place any frame will do
    length = _norm(along)
    c, s = (along[0] / length, along[1] / length) if length else (Decimal(1), ZERO)

    def turned(vector: Vector) -> Vector:
        return c * vector[0] + s * vector[1], c * vector[1] - s * vector[0]

    force = turned((h[0][0], h[0][1])), turned((h[1][0], h[1][1]))
    weight = Decimal(float(torque_weight))
    torque = (h[0][2], h[1][2])
    grip = (turned(r1), turned(r2)) if distance else ((length, ZERO), (length, ZERO))
    return Pair(force, torque, grip, distance, weight, induced)


def _norm(vector: Vector) -> Decimal:
    return (vector[0] * vector[0] + vector[1] * vector[1]).sqrt()


def _moment(grip: Vector, force: Vector) -> Decimal:
    return grip[0] * force[1] - grip[1] * force[0]


def _minimum(function: Callable[[Decimal], Decimal], high: Decimal) -> Decimal:
    """Least value on [0, high] of a convex function that is infinite, if at all, beyond a point."""
    low, best = ZERO, NEVER
    p, q = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_p, at_q = function(p), function(q)
    for _ in range(STEPS):
        best = min(best, at_p, at_q)
        if at_p <= at_q:
            high, q, at_q = q, p, at_p
            p = high - GOLDEN * (high - low)
            at_p = function(p)
        else:
            low, p, at_p = p, q, at_q
            q = low + GOLDEN * (high - low)
            at_q = function(q)
    return best


def _at_height(pair: Pair, v: Decimal) -> Decimal:
    """Least cost at height v; at 0 the applied wrench is feasible, whatever rounding says."""
    taken = sum((min(own, ZERO) for own in pair.torque), ZERO)
    given = sum((max(own, ZERO) for own in pair.torque), ZERO)
    torque = taken + given + pair.distance * v  # of the rounded sums: v = 0 must be between them
    ends = _feasible(pair, v) if taken <= torque <= given else None
    if ends is None:
        return NEVER if v else _cost(pair, ZERO, ZERO)
    low, high = ends
    if not pair.induced:
        (f1x, f1y), (f2x, f2y) = pair.force
        rise1, rise2 = abs(f1y - v), abs(f2y + v)
        u = f1x - (f1x + f2x) * rise1 / (rise1 + rise2) if rise1 + rise2 else f1x
        return _cost(pair, min(max(u, low), high), v)
    inside = _minimum(lambda u: _cost(pair, low + u, v), high - low)
    return min(inside, _cost(pair, low, v), _cost(pair, high, v))


def _feasible(pair: Pair, v: Decimal) -> tuple[Decimal, Decimal] | None:
    """Interval of u in both discs and, where a grip has a lever, both strips."""
    (first, second), low, high = pair.force, -NEVER, NEVER
    for grip, (x, y) in zip(pair.grip, (first, (-second[0], -second[1])), strict=True):
        square = x * x / 4 + v * (y - v)
        if square < 0:
            return None
        low, high = max(low, x / 2 - square.sqrt()), min(high, x / 2 + square.sqrt())
        limit = _moment(grip, (x, y))
        if grip[1]:
            ends = sorted((grip[0] * v / grip[1], (grip[0] * v - limit) / grip[1]))
            low, high = max(low, ends[0]), min(high, ends[1])
        elif not min(limit, ZERO) <= grip[0] * v <= max(limit, ZERO):
            return None
    return (low, high) if low <= high else None


def _cost(pair: Pair, u: Decimal, v: Decimal) -> Decimal:
    (f1x, f1y), (f2x, f2y) = pair.force
    forces = ((f1x - u, f1y - v), (f2x + u, f2y + v))
    torque = abs(pair.torque[0] + pair.torque[1] + pair.distance * v)
    if pair.induced:
        torque += sum(abs(_moment(r, f)) for r, f in zip(pair.grip, forces, strict=True))
    return (1 - pair.weight) * sum(map(_norm, forces), ZERO) + pair.weight * torque
