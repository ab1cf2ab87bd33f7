"""What an answer of the structured solver is worth: costs, the dual bound, the way back into balls.

For any multipliers ν of balance and any ζ in the dual cones of costs (‖ζ‖ ≤ c) and discs, with
ζ_ball = Gᵀν − Σ ζ_cost − ζ_disc, the optimum obeys

J(h) − J* ≤ Σ_cost [c‖v‖ + ζ·v] + ½ Σ_ball,disc [‖ζ‖‖v‖ + ζ·v]

by weak duality; every term is ≥ 0 and is evaluated without cancellation. Costs J(h) = 1.
"""

from math import sqrt

import numpy as np

from coopenv.wrench.blocks import (
    ANSWER,
    COLUMNS,
    CONES,
    DISC_PRICE,
    FREE,
    PRICE,
    RADIUS,
    V,
    cone_of,
    norm3,
)
from coopenv.wrench.coupling import BALANCE, NU, NU_STEP, resultant, solve_system, spread_evenly
from coopenv.wrench.newton import spread_step
from coopenv.wrench.second_order import TINY, Z, compiled, inlined

EXCESS = 3e-16  # [units of the sample] by which an answer may leave a ball
LOOSE = 1e-12  # the same for the last resort; √ of it may be gained in cost
EVENED = 1e-15  # resultant of g from which on it is not corrected any more
BALANCED = 1e-13  # largest resultant of an answer's g
NOISE = 1e-28  # square of an internal part that may point anywhere
SLACK = 5e-13  # what `undercut` takes for ε: more than there is, as the multipliers lag behind


@compiled
def shortfall(k, system):
    """Bound on J(h) − J* from the multipliers and the cones' z."""
    total = 0.0
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            total += _block_shortfall(k[i], system, 3 * (i & 1))
    return total


@compiled
def _block_shortfall(row, system, first):
    y0, y1, y2, total = 0.0, 0.0, 0.0, 0.0  # ζ_ball
    for r in range(first, 6):
        nu = system[NU, r]
        y0 += row[COLUMNS + r] * nu
        y1 += row[COLUMNS + 6 + r] * nu
        y2 += row[COLUMNS + 12 + r] * nu
    for c in range(int(row[CONES])):
        cone = cone_of(row, c)
        a0, a1, a2 = cone[Z + 1], cone[Z + 2], cone[Z + 3]
        if c == 2:  # the program's z of a disc is −ζ
            y1, y2 = y1 + a1, y2 + a2
            total += 0.5 * _defect(0.0, -a1, -a2, 0.0, row[V + 1])
        elif c != 1:
            price = row[PRICE] if c == 0 else row[DISC_PRICE]
            size = norm3(a0, a1, a2)
            shrink = price / size if size > price else 1.0
            a0, a1, a2 = a0 * shrink, a1 * shrink, a2 * shrink
            y0, y1, y2 = y0 - a0, y1 - a1, y2 - a2
            v0 = row[V] if c == 0 else 0.0
            total += (price - size * shrink) * sqrt(v0 * v0 + row[V + 1] * row[V + 1])
            total += _defect(a0, a1, a2, v0, row[V + 1])
    if row[FREE] < 2.0:
        return total + 0.5 * _defect(y0, 0.0, 0.0, row[V], 0.0)
    if row[FREE] < 3.0:
        y2 = 0.0
    return total + 0.5 * _defect(y0, y1, y2, row[V], row[V + 1])


@inlined
def _defect(a0, a1, a2, b0, b1):
    """‖a‖‖b‖ + a·b for b = (b_0, b_1, 0)."""
    product = a0 * b0 + a1 * b1
    sizes = sqrt((a0 * a0 + a1 * a1 + a2 * a2) * (b0 * b0 + b1 * b1))
    if product >= 0.0:
        return sizes + product
    c2 = a0 * b1 - a1 * b0
    return (a2 * a2 * (b0 * b0 + b1 * b1) + c2 * c2) / max(sizes - product, TINY)


@compiled
def saving(k, part):
    """J(h) − J(h − g) for g at ``part`` of the blocks, accurate where g is small."""
    total = 0.0
    for i in range(k.shape[0]):
        row = k[i]
        if row[FREE] == 0.0:
            continue
        v0, v1, g0, g1, g2 = row[V], row[V + 1], row[part], row[part + 1], row[part + 2]
        before, after = v1 * v1, (v1 - g1) * (v1 - g1) + g2 * g2
        difference = g1 * (2.0 * v1 - g1) - g2 * g2
        if row[CONES] == 4.0:
            total += row[DISC_PRICE] * difference / max(sqrt(before) + sqrt(after), TINY)
        before += v0 * v0
        after += (v0 - g0) * (v0 - g0)
        difference += g0 * (2.0 * v0 - g0)
        total += row[PRICE] * difference / max(sqrt(before) + sqrt(after), TINY)
    return total


@compiled
def undercut(system, saved):
    """Estimate how far below J* an answer's cost may be, as it is balanced only to rounding.

    A slack ε in torque is worth ε‖ν‖, ν being the multipliers of its balance, which are huge where
    only a very short lever could compensate a torque. Never more than all that is saved, since
    J* ≤ J(h).
    """
    square = 0.0
    for r in range(3, 6):
        square += system[NU, r] * system[NU, r]
    return min(max(saved, 0.0), SLACK * sqrt(square))


@compiled
def settle(k, system, part, excess):
    """Make the g at ``part`` an answer: balanced, and in every ball; return J(h) − J.

    What misses balance is spread by the last Newton system; what then leaves a ball is drawn back
    by shrinking everything towards 0, which keeps the balance: ‖θg‖² ≤ θ g·v.
    """
    for i in range(k.shape[0]):
        for j in range(3):
            k[i, ANSWER + j] = k[i, part + j]
    _balance(k, system)
    for _ in range(5):
        if resultant(k, system, ANSWER) <= EVENED:
            break
        _balance(k, system)
    if not resultant(k, system, ANSWER) <= BALANCED:
        spread_evenly(k, system)
        if not resultant(k, system, ANSWER) <= BALANCED:
            return -np.inf
    shrink = 1.0
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            shrink = min(shrink, _room(k[i], excess))
    for i in range(k.shape[0]):
        for j in range(3):
            k[i, ANSWER + j] *= shrink
    return saving(k, ANSWER)


@compiled
def _balance(k, system):
    """Add H⁻¹ Gᵀ M⁻¹ r to the candidate answer, which takes it back to G g = 0."""
    resultant(k, system, ANSWER)
    for r in range(6):
        system[NU_STEP, r] = system[BALANCE, r]
    solve_system(system)
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            spread_step(k[i], system, 3 * (i & 1), 0.0, ANSWER)


@compiled
def _room(row, excess):
    """Largest θ ≤ 1 such that θ times the candidate is in the block's ball and disc."""
    room = 1.0
    for first in range(2 if row[CONES] > 2.0 else 1):
        inner, square = 0.0, 0.0
        for j in range(first, int(row[FREE])):
            inner += row[ANSWER + j] * row[V + j]
            square += row[ANSWER + j] * row[ANSWER + j]
        radius = 0.5 * abs(row[V + 1]) if first == 1 else row[RADIUS]
        if square > NOISE and sqrt(max(square - inner + radius * radius, 0.0)) - radius > excess:
            room = min(room, max(inner, 0.0) / square)
    return room
