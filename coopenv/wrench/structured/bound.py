"""Bound on the optimum of the structured solver by weak duality, and errors by rounding; compiled.

For any multipliers ν of balance and any ζ in the dual cones of costs (‖ζ‖ ≤ c) and discs, with
ζ_ball = Gᵀν − Σ ζ_cost − ζ_disc, the optimum J* obeys

J(h) − J* ≤ Σ_cost [c‖v‖ + ζ·v] + ½ Σ_ball,disc [‖ζ‖‖v‖ + ζ·v]

Every term is ≥ 0 and is evaluated without cancellation. Costs are in units of J(h).
"""

from math import sqrt

from coopenv.compiled import TINY, fused, fused_inlined
from coopenv.compiled.lanes.vectors import larger, largest, root, size, splat, total, where
from coopenv.wrench.structured.balance import NU, NU_STEP, resultant, seen
from coopenv.wrench.structured.blocks import (
    ANSWER,
    CONES,
    DISC_PRICE,
    FREE,
    PRICE,
    RADIUS,
    V,
    chunk,
    cone_of,
    num_chunks,
    num_cones,
)
from coopenv.wrench.structured.cones import Z
from coopenv.wrench.structured.tolerances import (
    DEPTH_LOSS,
    MULTIPLIER_GROWTH,
    NEGLIGIBLE,
    TORQUE_ROUNDING,
)


@fused
def shortfall(sample, system):
    """Return the bound on J(h) − J* from the multipliers and the cones' z."""
    bound = splat(0.0)
    for i in range(num_chunks(sample)):
        bound += block_shortfall(chunk(sample, i), *seen(chunk(sample, i), system, NU, i & 1))
    return total(bound)


@fused_inlined
def block_shortfall(b, y0, y1, y2):
    """Return the terms of four blocks in the bound, for y = Gᵀν."""
    bound = splat(0.0)
    for c in range(num_cones(b)):
        if c == 1:
            continue
        cone, present = cone_of(b, c), b[CONES] > c
        a0, a1, a2 = cone[Z + 1], cone[Z + 2], cone[Z + 3]
        if c == 2:  # the program's z of a disc is −ζ
            y1, y2 = y1 + a1, y2 + a2
            bound += 0.5 * _defect(splat(0.0), -a1, -a2, splat(0.0), b[V + 1])
            continue
        price = b[PRICE] if c == 0 else b[DISC_PRICE]
        length = _length(a0, a1, a2)
        shrink = where(length > price, price / length, 1.0)
        a0, a1, a2 = a0 * shrink, a1 * shrink, a2 * shrink
        y0, y1, y2 = y0 - a0, y1 - a1, y2 - a2
        v0 = b[V] if c == 0 else splat(0.0)
        defect = (price - length * shrink) * _length(v0, b[V + 1], 0.0)
        bound += where(present, defect + _defect(a0, a1, a2, v0, b[V + 1]), 0.0)
    several, all_three = b[FREE] > 1.0, b[FREE] > 2.0
    y1, y2, v1 = where(several, y1, 0.0), where(all_three, y2, 0.0), where(several, b[V + 1], 0.0)
    bound += 0.5 * _defect(y0, y1, y2, b[V], v1)
    return where(b[FREE] > 0.0, bound, 0.0)


@fused_inlined
def _length(x, y, z):
    """Return the length of a vector in every lane."""
    return root(x * x + y * y + z * z)


@fused_inlined
def _defect(a0, a1, a2, b0, b1):
    """Return ‖a‖‖b‖ + a·b for b = (b_0, b_1, 0), accurate also where they are opposed."""
    product = a0 * b0 + a1 * b1
    square_a, square_b = a0 * a0 + a1 * a1 + a2 * a2, b0 * b0 + b1 * b1
    sizes = root(square_a * square_b)
    c2 = a0 * b1 - a1 * b0
    opposed = (a2 * a2 * square_b + c2 * c2) / larger(sizes - product, TINY)
    return where(product >= 0.0, sizes + product, opposed)


@fused
def saving(sample, part):
    """Return J(h) − J(h − g) for g in the fields from ``part`` on, accurate where g is small."""
    saved = splat(0.0)
    for i in range(num_chunks(sample)):
        saved += block_saving(chunk(sample, i), part)
    return total(saved)


@fused_inlined
def block_saving(b, part):
    """Return J(h) − J(h − g) of four blocks."""
    v0, v1, g0, g1, g2 = b[V], b[V + 1], b[part], b[part + 1], b[part + 2]
    before, after = v1 * v1, (v1 - g1) * (v1 - g1) + g2 * g2
    difference = g1 * (2.0 * v1 - g1) - g2 * g2
    saved = splat(0.0)
    if largest(b[CONES]) == 4.0:
        saved = b[DISC_PRICE] * difference / larger(root(before) + root(after), TINY)
        saved = where(b[CONES] > 3.0, saved, 0.0)
    before += v0 * v0
    after += (v0 - g0) * (v0 - g0)
    difference += g0 * (2.0 * v0 - g0)
    saved += b[PRICE] * difference / larger(root(before) + root(after), TINY)
    return where(b[FREE] > 0.0, saved, 0.0)


@fused
def undercut(sample, system, saved, beyond, depth):
    """Estimate how far below J* the cost of an answer may be, which is feasible only to rounding.

    Missing balance by ε may save ε‖ν‖. The multipliers ν of force are huge where forces nearly
    agree, those of torque where levers are long or where only a very short lever could compensate a
    torque. Leaving a ball by ε may save ε‖ζ‖. Both errors are measured, and `TORQUE_ROUNDING` is
    added to those of torque.

    These multipliers are the answer's, and those of J* may be larger without bound: where forces
    nearly agree, ε may exceed the ``depth`` of the feasible set. By convexity forces that are off
    by ε save no more than the part ε/depth of what the answer saves ``beyond`` one that is surely
    plausible. Neither is more than all that is saved, as J* ≤ J(h).
    """
    resultant(sample, system, ANSWER, NU_STEP)
    square, worth = 0.0, 0.0
    for r in range(6):
        worth += abs(system[NU, r] * system[NU_STEP, r])
    for r in range(3, 6):
        square += system[NU, r] * system[NU, r]
    off = sqrt(
        system[NU_STEP, 0] * system[NU_STEP, 0]
        + system[NU_STEP, 1] * system[NU_STEP, 1]
        + system[NU_STEP, 2] * system[NU_STEP, 2]
    )
    priced, outside = splat(0.0), splat(0.0)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        ball, disc = _excess(b)
        priced += where(ball > 0.0, ball * cone_of(b, 1)[Z], 0.0)
        priced += where(disc > 0.0, disc * cone_of(b, 2)[Z], 0.0)
        if i & 1 == 0:
            outside += ball + disc
    off += total(outside)
    thin = DEPTH_LOSS * off
    part = thin / depth if thin < depth else 1.0
    worth = TORQUE_ROUNDING * sqrt(square) + MULTIPLIER_GROWTH * (worth + total(priced))
    return max(min(worth, saved), part * beyond, 0.0)


@fused
def neglected(sample, system):
    """Return by how much vectors that are left as applied for their size would raise the bound.

    ½ (‖y‖‖v‖ + y·v) for y = Gᵀν + c v/‖v‖: the term of the ball where that of the cost is 0
    """
    bound = splat(0.0)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        y0, y1, y2 = seen(b, system, NU, i & 1)
        length = _length(b[V], b[V + 1], 0.0)
        per_length = 1.0 / larger(length, TINY)
        y0, y1 = y0 + b[PRICE] * b[V] * per_length, y1 + b[PRICE] * b[V + 1] * per_length
        y1 += where(b[V + 1] < 0.0, -b[DISC_PRICE], b[DISC_PRICE])
        left = (b[FREE] < 1.0) & (length <= NEGLIGIBLE)
        bound += where(left, 0.5 * _defect(y0, y1, y2, b[V], b[V + 1]), 0.0)
    return total(bound)


@fused_inlined
def _excess(b):
    """Return by how much the candidate leaves the balls and the discs of four blocks."""
    inner, square = products(b)
    ball = leaving(inner + b[ANSWER] * b[V], square + b[ANSWER] * b[ANSWER], b[RADIUS])
    disc = leaving(inner, square, 0.5 * size(b[V + 1]))
    return where(b[CONES] > 1.0, ball, 0.0), where(b[CONES] > 2.0, disc, 0.0)


@fused_inlined
def products(b):
    """Return g·v and ‖g‖² of the candidate, both without the first coordinate."""
    g1, g2 = b[ANSWER + 1], b[ANSWER + 2]
    return g1 * b[V + 1], g1 * g1 + g2 * g2


@fused_inlined
def leaving(inner, square, radius):
    """Return by how much g leaves a ball, from g·v and ‖g‖²; accurate near 0."""
    out = larger(square - inner, 0.0)
    return out / larger(root(out + radius * radius) + radius, TINY)
