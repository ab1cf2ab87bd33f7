"""Curvature of the structured solver's blocks: H = L D Lᵀ, four blocks at once; compiled.

H, of size 3, is the sum of the curvatures of the block's cones in its free coordinates. It is
factorised and never inverted, since close to the boundary its parts differ by many magnitudes.
"""

from coopenv.compiled import fused, fused_inlined
from coopenv.wrench.structured.balance import SCRATCH, add_squares, sums
from coopenv.wrench.structured.blocks import COLUMNS, CONES, FACTOR, FREE, chunk, cone_of, num_cones
from coopenv.wrench.structured.cones import PER_BEND, SQUARE, Q, W, Z, scale
from coopenv.wrench.structured.lanes import larger, splat, where
from coopenv.wrench.structured.memory import after

FLOOR = 1e-15  # least pivot of H, relative to its diagonal


@fused
def factorise_block(k, i):
    """Scale the cones, factorise H, carry G through L, add G H⁻¹ Gᵀ to M (lower triangle)."""
    b = chunk(k, i)
    for c in range(num_cones(b)):
        cone = cone_of(b, c)
        scale(cone)
        for r in range(4):
            cone[Q + r] = where(b[CONES] > c, -cone[Z + r], 0.0)
    h00, h01, h02, h11, h12, h22 = _hessian(b)
    several, all_three = b[FREE] > 1.0, b[FREE] > 2.0
    p0 = where(b[FREE] > 0.0, 1.0 / h00, 0.0)
    l10 = where(several, h01 * p0, 0.0)
    p1 = where(several, 1.0 / larger(h11 - l10 * h01, FLOOR * h11), 0.0)
    l20 = where(all_three, h02 * p0, 0.0)
    bend = h12 - l20 * h01
    l21 = where(all_three, bend * p1, 0.0)
    p2 = where(all_three, 1.0 / larger(h22 - l20 * h02 - l21 * bend, FLOOR * h22), 0.0)
    b[FACTOR], b[FACTOR + 1], b[FACTOR + 2] = l10, l20, l21
    b[FACTOR + 3], b[FACTOR + 4], b[FACTOR + 5] = p0, p1, p2
    carried = after(sums(k), SCRATCH)
    for r in range(3 * (i & 1), 6):
        a0, a1, a2 = b[COLUMNS + r], b[COLUMNS + 6 + r], b[COLUMNS + 12 + r]
        a1 -= l10 * a0
        carried[r], carried[6 + r], carried[12 + r] = a0, a1, a2 - l20 * a0 - l21 * a1
    add_squares(k, carried, 3 * (i & 1), p0, p1, p2)


@fused_inlined
def _hessian(b):
    """Upper triangle of H: the sum of the cones' curvatures, τ eliminated."""
    zero = splat(0.0)
    h00, h01, h02, h11, h12, h22 = zero, zero, zero, zero, zero, zero
    for c in range(num_cones(b)):
        cone = cone_of(b, c)
        w1, w2, w3 = cone[W + 1], cone[W + 2], cone[W + 3]
        square = where(b[CONES] > c, cone[SQUARE], 0.0)
        bend = square * (splat(2.0) if c == 1 or c == 2 else -2.0 * cone[PER_BEND])
        if c < 2:
            h00 += square + bend * w1 * w1
            h01 += bend * w1 * w2
            h02 += bend * w1 * w3
        h11 += square + bend * w2 * w2
        h12 += bend * w2 * w3
        h22 += square + bend * w3 * w3
    return h00, h01, h02, h11, h12, h22


@fused_inlined
def under_hessian(b, y0, y1, y2):
    """H⁻¹ y."""
    y1 -= b[FACTOR] * y0
    y2 = (y2 - b[FACTOR + 1] * y0 - b[FACTOR + 2] * y1) * b[FACTOR + 5]
    y1 = y1 * b[FACTOR + 4] - b[FACTOR + 2] * y2
    return y0 * b[FACTOR + 3] - b[FACTOR] * y1 - b[FACTOR + 1] * y2, y1, y2
