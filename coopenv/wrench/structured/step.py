"""Steps of the structured solver: takes one and evaluates the new iterate in one pass; compiled."""

from coopenv.compiled import fused, fused_inlined
from coopenv.compiled.lanes.vectors import larger, largest, size, splat, total, where
from coopenv.wrench.structured.balance import (
    BALANCE,
    NU,
    NU_STEP,
    add_resultant,
    clear_resultant,
    collect_resultant,
    seen,
)
from coopenv.wrench.structured.blocks import (
    CONES,
    FREE,
    REST,
    SEEN,
    STEP,
    G,
    chunk,
    cone_of,
    num_chunks,
    num_cones,
)
from coopenv.wrench.structured.bound import block_saving, block_shortfall
from coopenv.wrench.structured.cones import (
    DET_S,
    DET_Z,
    DS,
    DZ,
    INNER,
    S,
    Z,
    advance,
    inner,
    refresh,
    renew,
)
from coopenv.wrench.structured.tolerances import ROUNDING


@fused
def take(sample, system, primal, dual):
    """Take a step of these lengths, and write r and Gᵀν of the new iterate.

    Returns the bound on J(h) − J*, J(h) − J, the mean of s·z, and the largest multiplier of a ball
    or disc.
    """
    for r in range(6):
        system[NU, r] += dual * system[NU_STEP, r] if dual > 0.0 else 0.0
        system[BALANCE, r] = 0.0
    clear_resultant(sample)
    bound, saved, products = splat(0.0), splat(0.0), splat(0.0)
    number, multiplier = splat(0.0), splat(0.0)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)

        # take the step
        if primal > 0.0 or dual > 0.0:
            _advance_block(b, primal, dual)

        # evaluate the cones
        for c in range(num_cones(b)):
            cone, present = cone_of(b, c), b[CONES] > c
            cone[INNER] = inner(cone)
            products += where(present, cone[INNER], 0.0)
            if c == 1 or c == 2:
                multiplier = larger(where(present, cone[Z], 0.0), multiplier)

        # evaluate bound, cost and balance
        y0, y1, y2 = seen(b, system, NU, i & 1)
        b[SEEN], b[SEEN + 1], b[SEEN + 2] = y0, y1, y2
        bound += block_shortfall(b, y0, y1, y2)
        saved += block_saving(b, G)
        number += b[CONES]
        add_resultant(sample, i, b[G], b[G + 1], b[G + 2])
    collect_resultant(sample, system, BALANCE, -1.0)
    mean = total(products) / max(total(number), 1.0)
    return total(bound), total(saved), mean, largest(multiplier)


@fused_inlined
def _advance_block(b, primal, dual):
    """Take the step of four blocks; evaluate dets anew where that is more accurate."""
    for j in range(3):
        b[G + j] += primal * b[STEP + j]
        b[REST + j] -= primal * b[STEP + j]
    for c in range(num_cones(b)):
        cone = cone_of(b, c)
        advance(cone, S, DS, DET_S, primal)
        advance(cone, Z, DZ, DET_Z, dual)
        refresh(cone, Z, DET_Z)
        if c == 0 or c == 3:
            refresh(cone, S, DET_S)
        else:
            _renew_ball(b, cone, c)


@fused_inlined
def _renew_ball(b, cone, c):
    """Write s of a ball or disc from g, and its det from g·(v − g)."""
    inside, doubt = splat(0.0), splat(0.0)
    for j in range(c - 1, 3):
        part = where(b[FREE] > j, b[G + j] * b[REST + j], 0.0)
        inside = inside + part
        doubt = doubt + ROUNDING * size(part)
        there = (b[FREE] > j) & (b[CONES] > c)
        cone[S + 1 + j] = where(there, 0.5 * (b[G + j] - b[REST + j]), 0.0)
    renew(cone, DET_S, where(b[CONES] > c, inside, 0.0), doubt)
