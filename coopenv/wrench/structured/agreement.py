"""Forces that agree, exactly or nearly: the states in which the feasible set has no interior.

Where all forces point the same way none of them can be internal: Σ g = 0 while every g·f ≥ 0. Then
the pure torques are shared along their sum (eqs. 22-23) and that is the answer. Where the forces
nearly agree the same answer is nearly optimal, and where that is not good enough the iterations
begin next to it.
"""

from math import sqrt

from coopenv.compiled import TINY, fused
from coopenv.wrench.structured.balance import NU, NU_STEP
from coopenv.wrench.structured.blocks import (
    ANSWER,
    COLUMNS,
    CONES,
    DISC_PRICE,
    FIRST_CONE,
    FREE,
    PRICE,
    RADIUS,
    REST,
    G,
    V,
    block,
    norm3,
    num_blocks,
)
from coopenv.wrench.structured.bound import saving, shortfall
from coopenv.wrench.structured.cones import CONE, DET_S, DET_Z, ERROR_S, ERROR_Z, S, Z
from coopenv.wrench.structured.tolerances import ROUNDING


@fused
def disagreement(sample, system):
    """Largest sine of the angle between a force and Σ f, 1 if one opposes it."""
    _sum(sample, system, 0)
    x, y, z = system[NU_STEP, 0], system[NU_STEP, 1], system[NU_STEP, 2]
    size = max(norm3(x, y, z), TINY)
    x, y, z = x / size, y / size, z / size
    sine = 0.0
    for i in range(0, num_blocks(sample), 2):
        row = block(sample, i)
        if row[FREE] == 0.0:
            continue
        fx = row[COLUMNS] * row[V] + row[COLUMNS + 6] * row[V + 1]
        fy = row[COLUMNS + 1] * row[V] + row[COLUMNS + 7] * row[V + 1]
        fz = row[COLUMNS + 2] * row[V] + row[COLUMNS + 8] * row[V + 1]
        if fx * x + fy * y + fz * z <= 0.0:
            return 1.0
        across = norm3(fy * z - fz * y, fz * x - fx * z, fx * y - fy * x)
        sine = max(sine, across / norm3(fx, fy, fz))
    return sine


@fused
def _sum(sample, system, first):
    """Write Σ f to dν, or Σ t to its second half (``first`` = 3)."""
    for r in range(first, first + 3):
        system[NU_STEP, r] = 0.0
        for i in range(first // 3, num_blocks(sample), 2):
            row = block(sample, i)
            for j in range(2):
                system[NU_STEP, r] += row[COLUMNS + 6 * j + r] * row[V + j]


@fused
def share_torques(sample, system):
    """Candidate that keeps every force and shares the torques along their sum; return its length.

    Their sum is left in dν.
    """
    _sum(sample, system, 3)
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        row[ANSWER], row[ANSWER + 1], row[ANSWER + 2] = 0.0, 0.0, 0.0
    _share(sample, system, _supply(sample, system))
    return norm3(system[NU_STEP, 3], system[NU_STEP, 4], system[NU_STEP, 5])


@fused
def share_needed(sample, system):
    """Share what the candidate needs of pure torque among all who can supply it.

    Any split along their sum costs the same, and none costs less; without this it would be as the
    iterations left it. Where the sum alone cannot be supplied, nothing changes.
    """
    for r in range(3, 6):
        needed = 0.0
        for i in range(1, num_blocks(sample), 2):
            row = block(sample, i)
            if row[FREE] > 0.0:
                for j in range(3):
                    needed += row[COLUMNS + 6 * j + r] * (row[V + j] - row[ANSWER + j])
        system[NU_STEP, r] = needed
    supply, size = (
        _supply(sample, system),
        norm3(system[NU_STEP, 3], system[NU_STEP, 4], system[NU_STEP, 5]),
    )
    if supply >= size * size:
        _share(sample, system, supply)


@fused
def _supply(sample, system):
    """Σ max(t_i·t, 0) for the torque t in dν."""
    supply = 0.0
    for i in range(1, num_blocks(sample), 2):
        row = block(sample, i)
        if row[FREE] > 0.0:
            supply += max(_along(row, system), 0.0)
    return supply


@fused
def _share(sample, system, supply):
    """Give every torque its part of the torque t in dν.

    t_M,i = max(t_i·t, 0) / Σ max(t_j·t, 0) t    (eqs. 22-23)
    """
    for i in range(1, num_blocks(sample), 2):
        row = block(sample, i)
        if row[FREE] == 0.0:
            continue
        share = max(_along(row, system), 0.0) / max(supply, TINY)
        for j in range(3):
            needed = 0.0
            for r in range(3, 6):
                needed += share * system[NU_STEP, r] * row[COLUMNS + 6 * j + r]
            row[ANSWER + j] = row[V + j] - needed


@fused
def _along(row, system):
    """Inner product of a torque with Σ t."""
    product = row[COLUMNS + 3] * system[NU_STEP, 3] + row[COLUMNS + 4] * system[NU_STEP, 4]
    return (product + row[COLUMNS + 5] * system[NU_STEP, 5]) * row[V]


@fused
def certify(sample, system, sine):
    """Leave `share_torques` as the candidate and return the bound on its suboptimality.

    ν_f = −K f_o/‖f_o‖ with K about c/sine, ν_t = −c t/‖t‖; ζ = −c v/‖v‖ for forces, ν_t for torques

    The c of K is what force and the torque that it makes cost: of the two errors in the bound,
    K sine² and the torque's c²/K, neither may be the larger.
    """
    _aim(sample, system, (block(sample, 0)[PRICE] + block(sample, 1)[PRICE]) / max(sine, 1e-15))
    size = max(share_torques(sample, system), TINY)
    for r in range(3, 6):
        system[NU, r] = -block(sample, 1)[PRICE] * system[NU_STEP, r] / size
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        z = FIRST_CONE + Z
        length = max(norm3(row[V], row[V + 1], 0.0), TINY)
        for j in range(3):
            row[z + 1 + j] = -row[PRICE] * row[V + j] / length
            if i % 2 == 1:
                row[z + 1 + j] = 0.0
                for r in range(3, 6):
                    row[z + 1 + j] += row[COLUMNS + 6 * j + r] * system[NU, r]
            row[z + 2 * CONE + 1 + j] = 0.0
            row[z + 3 * CONE + 1 + j] = 0.0
        sign = 1.0 if row[V + 1] > 0.0 else -1.0
        row[z + 3 * CONE + 2] = -row[DISC_PRICE] * sign
    return max(shortfall(sample, system) - saving(sample, ANSWER), 0.0)


@fused
def _aim(sample, system, multiplier):
    """ν_f = −K f_o/‖f_o‖."""
    _sum(sample, system, 0)
    size = max(norm3(system[NU_STEP, 0], system[NU_STEP, 1], system[NU_STEP, 2]), TINY)
    for r in range(3):
        system[NU, r] = -multiplier * system[NU_STEP, r] / size
        system[NU, r + 3] = 0.0


@fused
def start_near(sample, system, sine):
    """Move the forces' start to where it must end, near 0, with the multipliers that say so.

    g = θ f with θ such that s·z is as large as in the other blocks.
    """
    _aim(sample, system, block(sample, 0)[PRICE] / sine)
    total, number = 0.0, 0
    for i in range(0, num_blocks(sample), 2):
        row = block(sample, i)
        if row[PRICE] > 0.0:
            total += row[PRICE] * norm3(row[V], row[V + 1], 0.0)
            number += 1
    for i in range(0, num_blocks(sample), 2):
        if block(sample, i)[FREE] > 0.0:
            _start_force_near(block(sample, i), system, total / number)


@fused
def _start_force_near(row, system, target):
    z = FIRST_CONE + CONE + Z
    for j in range(3):  # the ball's z is −Gᵀν
        row[z + 1 + j] = 0.0
        if j < row[FREE]:
            for r in range(3):
                row[z + 1 + j] -= row[COLUMNS + 6 * j + r] * system[NU, r]
    length = norm3(row[z + 1], row[z + 2], row[z + 3])
    at = FIRST_CONE + CONE
    row[z] = length + target / row[RADIUS]
    row[at + DET_Z] = (row[z] - length) * (row[z] + length)
    row[at + ERROR_Z] = ROUNDING * row[z] * row[z]
    theta = min(0.5, target / max(2.0 * row[RADIUS] * length, TINY))
    for j in range(int(row[FREE])):
        row[G + j] = theta * row[V + j]
        row[REST + j] = row[V + j] - row[G + j]
    for c in range(int(row[CONES])):
        at = FIRST_CONE + CONE * c
        first = 1 if c >= 2 else 0
        inside, length = 0.0, 0.0
        for j in range(first, 3):
            inside += row[G + j] * row[REST + j]
            rest = row[REST + j] if c == 0 or c == 3 else 0.5 * (row[G + j] - row[REST + j])
            if j >= row[FREE] and (c == 1 or c == 2):
                rest = 0.0
            row[at + S + 1 + j] = rest
            length += rest * rest
        if c == 0 or c == 3:
            row[at + S] = 1.5 * sqrt(length)
            inside = 1.25 * length
        row[at + DET_S] = inside
        row[at + ERROR_S] = ROUNDING * inside
