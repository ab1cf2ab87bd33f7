"""Agreeing forces in the structured solver: an answer without iterations, and a start beside it.

Where all forces are parallel the feasible set has no interior. None of the forces can be internal,
since Σ g = 0 while every g·f ≥ 0. The pure torques are shared along their sum (eqs. 22-23), and
that is the answer. Where the forces are nearly parallel the same answer is nearly optimal. If its
gap is too large, the iterations start next to it.

Source: Donner, Endo & Buss 2018, eqs. 22-23; the bound and the start are our own.
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
    num_blocks,
)
from coopenv.wrench.structured.bound import saving, shortfall
from coopenv.wrench.structured.cones import CONE, DET_S, DET_Z, ERROR_S, ERROR_Z, S, Z
from coopenv.wrench.structured.frame import norm3
from coopenv.wrench.structured.tolerances import LEAST_SINE, ROUNDING


@fused
def disagreement(sample, system):
    """Return the largest sine of the angle between a force and Σ f, 1 if one opposes it."""
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
def room_in(sample, system):
    """Return how deep forces alone would make the feasible set, and what sharing torques saves.

    The depth is by how much Σ g could point beyond 0, against Σ f: (Σ ‖f‖ − ‖Σ f‖) / 2, of forces
    that are not fixed. The saving is in parts of J(h).
    """
    depth, saved = 0.0, 0.0
    for first in (0, 3):
        _sum(sample, system, first)
        x, y, z = system[NU_STEP, first], system[NU_STEP, first + 1], system[NU_STEP, first + 2]
        size = max(norm3(x, y, z), TINY)
        x, y, z = x / size, y / size, z / size
        for i in range(first // 3, num_blocks(sample), 2):
            row = block(sample, i)
            at = COLUMNS + first
            fx = row[at] * row[V] + row[at + 6] * row[V + 1]
            fy = row[at + 1] * row[V] + row[at + 7] * row[V + 1]
            fz = row[at + 2] * row[V] + row[at + 8] * row[V + 1]
            along = fx * x + fy * y + fz * z
            across = norm3(fy * z - fz * y, fz * x - fx * z, fx * y - fy * x)
            length = norm3(fx, fy, fz)
            lost = length - along
            if along > 0.0:
                lost = across * across / (length + along)
            if first == 0 and row[FREE] > 0.0:
                depth += 0.5 * lost
            if first == 3:
                saved += row[PRICE] * lost
    return depth, saved


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
    """Make the answer that keeps every force and shares the torques along their sum.

    Returns the length of the sum, which is left in dν.
    """
    _sum(sample, system, 3)
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        row[ANSWER], row[ANSWER + 1], row[ANSWER + 2] = 0.0, 0.0, 0.0
    _share(sample, system, _supply(sample, system))
    return norm3(system[NU_STEP, 3], system[NU_STEP, 4], system[NU_STEP, 5])


@fused
def share_needed(sample, system):
    """Share what the answer needs of pure torque in proportion to what each effector can supply.

    Every split along the needed torque costs the same, and none costs less. Without this the split
    would be as the iterations left it. Where not all of it can be supplied, nothing changes.
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
    """Return Σ max(t_i·t, 0) for the torque t in dν."""
    supply = 0.0
    for i in range(1, num_blocks(sample), 2):
        row = block(sample, i)
        if row[FREE] > 0.0:
            supply += max(_along(row, system), 0.0)
    return supply


@fused
def _share(sample, system, supply):
    """Give every effector its share of the torque t in dν.

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
    """Return t_i·t for the torque t in dν."""
    product = row[COLUMNS + 3] * system[NU_STEP, 3] + row[COLUMNS + 4] * system[NU_STEP, 4]
    return (product + row[COLUMNS + 5] * system[NU_STEP, 5]) * row[V]


@fused
def certify(sample, system, sine):
    """Make the answer of `share_torques` and return its gap, relative to J(h).

    ν_f = −K f_o/‖f_o‖ with K = c/sine, ν_t = −c t/‖t‖, ζ = −c v/‖v‖ for forces and ν_t for torques

    The c of K is the price of a force and of the torque that it makes. With this K the two errors
    in the bound, K sine² and the torque's c²/K, are equal.
    """
    _aim(
        sample, system, (block(sample, 0)[PRICE] + block(sample, 1)[PRICE]) / max(sine, LEAST_SINE)
    )
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
    """Write ν_f = −K f_o/‖f_o‖ and ν_t = 0, K being ``multiplier``."""
    _sum(sample, system, 0)
    size = max(norm3(system[NU_STEP, 0], system[NU_STEP, 1], system[NU_STEP, 2]), TINY)
    for r in range(3):
        system[NU, r] = -multiplier * system[NU_STEP, r] / size
        system[NU, r + 3] = 0.0


@fused
def start_near(sample, system, sine):
    """Move the start of forces that are nearly parallel next to the answer for parallel ones.

    g = θ f with θ such that s·z is as large as in the other blocks, and multipliers along Σ f.
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
    """Write g = θ f of a force, and s and z of its cones, for s·z = ``target``."""
    # z of the ball
    z = FIRST_CONE + CONE + Z
    for j in range(3):  # −Gᵀν
        row[z + 1 + j] = 0.0
        if j < row[FREE]:
            for r in range(3):
                row[z + 1 + j] -= row[COLUMNS + 6 * j + r] * system[NU, r]
    length = norm3(row[z + 1], row[z + 2], row[z + 3])
    at = FIRST_CONE + CONE
    row[z] = length + target / row[RADIUS]
    row[at + DET_Z] = (row[z] - length) * (row[z] + length)
    row[at + ERROR_Z] = ROUNDING * row[z] * row[z]

    # g
    theta = min(0.5, target / max(2.0 * row[RADIUS] * length, TINY))
    for j in range(int(row[FREE])):
        row[G + j] = theta * row[V + j]
        row[REST + j] = row[V + j] - row[G + j]

    # s of every cone
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
