"""Where the structured solver's iterations begin: the centre of every ball, compiled."""

from coopenv.wrench.blocks import (
    CONES,
    DISC_PRICE,
    FREE,
    PRICE,
    RADIUS,
    REST,
    G,
    V,
    cone_of,
    norm3,
)
from coopenv.wrench.coupling import NU
from coopenv.wrench.second_order import (
    CONE,
    DET_S,
    DET_Z,
    ERROR_S,
    ERROR_Z,
    ROUNDING,
    S,
    Z,
    compiled,
)

EVEN = 0.5  # s·z of a ball at the start, in mean costs of a force or torque


@compiled
def start(k, system):
    """Begin in the middle of every ball, with multipliers that need no balance.

    s·z of a ball is the same for all, lest a tiny force hold up the others.
    """
    target, number = 0.0, 0
    for r in range(6):
        system[NU, r] = 0.0
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            target += k[i, PRICE] * norm3(k[i, V], k[i, V + 1], 0.0)
            number += 1
    target *= EVEN / max(number, 1)
    for i in range(k.shape[0]):
        row = k[i]
        free = int(row[FREE])
        for j in range(3):
            row[G + j] = 0.5 * row[V + j] if j < free else 0.0
            row[REST + j] = row[V + j] - row[G + j]
        row[RADIUS] = 0.5 * norm3(row[V], row[V + 1] if free > 1 else 0.0, 0.0)
        for c in range(int(row[CONES])):
            _start_cone(row, c, target)


@compiled
def _start_cone(row, c, target):
    """Put s of a ball to its centre, τ of a cost to twice the norm, and z to (z_0, 0).

    z_0 is c in a cost; in a ball such that s·z = ``target``, however small it is.
    """
    cone = cone_of(row, c)
    for r in range(CONE):
        cone[r] = 0.0
    first = 1 if c >= 2 else 0
    if c == 0 or c == 3:
        cone[Z] = row[PRICE] if c == 0 else row[DISC_PRICE]
        square = 0.0
        for j in range(first, 3):
            cone[S + 1 + j] = row[REST + j]
            square += row[REST + j] * row[REST + j]
        cone[S] = norm3(row[V] if c == 0 else 0.0, row[V + 1], 0.0)
        cone[DET_S] = cone[S] * cone[S] - square
    else:
        cone[S] = row[RADIUS] if c == 1 else 0.5 * abs(row[V + 1])
        cone[DET_S] = cone[S] * cone[S]
        cone[Z] = target / cone[S]
    cone[DET_Z] = cone[Z] * cone[Z]
    cone[ERROR_S] = ROUNDING * cone[S] * cone[S]
    cone[ERROR_Z] = ROUNDING * cone[DET_Z]
