"""Starting point of the structured solver: the centre of every ball; compiled."""

from coopenv.compiled import fused, fused_inlined
from coopenv.compiled.lanes.vectors import root, size, splat, total, where
from coopenv.wrench.structured.balance import NU
from coopenv.wrench.structured.blocks import (
    CONES,
    DISC_PRICE,
    FREE,
    PRICE,
    RADIUS,
    REST,
    G,
    V,
    chunk,
    cone_of,
    num_chunks,
    num_cones,
)
from coopenv.wrench.structured.cones import DET_S, DET_Z, ERROR_S, ERROR_Z, S, Z
from coopenv.wrench.structured.tolerances import ROUNDING, START_PRODUCT


@fused
def start(sample, system):
    """Put every g to the centre of its ball, and the multipliers of balance to 0.

    s·z is the same for all balls, so that a tiny force does not hold up the others.
    """
    costs, number = splat(0.0), splat(0.0)
    for r in range(6):
        system[NU, r] = 0.0
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        free = b[FREE] > 0.0
        costs += where(free, b[PRICE] * _length(b[V], b[V + 1]), 0.0)
        number += where(free, splat(1.0), 0.0)
    target = START_PRODUCT * total(costs) / max(total(number), 1.0)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for j in range(3):
            b[G + j] = where(b[FREE] > j, 0.5 * b[V + j], 0.0)
            b[REST + j] = b[V + j] - b[G + j]
        b[RADIUS] = 0.5 * _length(b[V], where(b[FREE] > 1.0, b[V + 1], 0.0))
        for c in range(num_cones(b)):
            _start_cone(b, c, target)


@fused_inlined
def _length(x, y):
    """Return the length of a vector (x, y, 0)."""
    return root(x * x + y * y)


@fused_inlined
def _start_cone(b, c, target):
    """Put s of a ball to its centre, τ of a cost to twice the norm, and z to (z_0, 0).

    z_0 of a cost is its price c. z_0 of a ball is such that s·z = ``target``. Where a block has no
    such cone its lane gets s = z = (1, 0) and stays there.
    """
    cone, present = cone_of(b, c), b[CONES] > c
    for r in range(1, 4):
        cone[S + r], cone[Z + r] = 0.0, 0.0
    square = splat(0.0)
    if c == 0 or c == 3:
        for j in range(1 if c == 3 else 0, 3):
            cone[S + 1 + j] = where(present, b[REST + j], 0.0)
            square = square + cone[S + 1 + j] * cone[S + 1 + j]
        cone[S] = where(present, _length(b[V] if c == 0 else splat(0.0), b[V + 1]), 1.0)
        cone[Z] = where(present, b[PRICE] if c == 0 else b[DISC_PRICE], 1.0)
    else:
        cone[S] = where(present, b[RADIUS] if c == 1 else 0.5 * size(b[V + 1]), 1.0)
        cone[Z] = where(present, target / cone[S], 1.0)
    cone[DET_S] = cone[S] * cone[S] - square
    cone[DET_Z] = cone[Z] * cone[Z]
    cone[ERROR_S] = ROUNDING * cone[S] * cone[S]
    cone[ERROR_Z] = ROUNDING * cone[DET_Z]
