"""The iterations of the structured solver: Mehrotra's predictor and corrector, compiled."""

from math import sqrt

import numpy as np

from coopenv.wrench.agreement import certify, disagreement, share_torques, start_near
from coopenv.wrench.blocks import (
    ANSWER,
    CONES,
    DISC_PRICE,
    FIRST_CONE,
    FREE,
    PRICE,
    RADIUS,
    REST,
    STEP,
    G,
    V,
    norm3,
)
from coopenv.wrench.certificate import EXCESS, LOOSE, saving, settle, shortfall
from coopenv.wrench.coupling import NU, NU_STEP, mark_alive, resultant
from coopenv.wrench.faces import fix_immovable, largest_multiplier
from coopenv.wrench.newton import direction, factorise
from coopenv.wrench.second_order import (
    CONE,
    DET_S,
    DET_Z,
    DS,
    DZ,
    ERROR_S,
    ERROR_Z,
    ROUNDING,
    Q,
    S,
    Z,
    advance,
    compiled,
    correct,
    inner,
    longest_step,
    refresh,
)

PARALLEL = 1e-12  # sine of the angle below which forces count as parallel
THIN = 0.05  # sine below which they nearly agree
LARGE = 10.0  # multiplier of a ball from which on one looks for what cannot move
MAX_STEPS = 80
SPREAD_BALL, SPREAD_COST = 0.5, 0.0
PATIENCE = 10  # iterations without progress
STUCK = 1e-6  # step length that is none


@compiled
def solve(k, system, tolerance):
    """Leave the best answer found in the blocks; return the iterations and its gap.

    The gap is relative to J(h); iterating stops once it is within the tolerance.
    """
    mark_alive(k, system)
    sine = disagreement(k, system)
    shared = np.inf
    if sine < THIN:
        shared = certify(k, system, sine)
        if shared <= tolerance or sine <= PARALLEL:
            return 0, shared
    _start(k, system)
    if sine < THIN:
        start_near(k, system, sine)
    bound, best, stalled, step, began, large = np.inf, np.inf, 0, 0, 0, LARGE
    for step in range(MAX_STEPS):
        bound = min(bound, shortfall(k, system))
        if bound <= tolerance:
            break
        if step > began and bound - saving(k, G) <= tolerance:
            gap = bound - settle(k, system, G, EXCESS)
            if gap <= tolerance:
                return step, max(gap, 0.0)
        now = complementarity(k)
        progress = resultant(k, system, G) + now
        stalled = 0 if progress < 0.9 * best else stalled + 1
        best = min(best, progress)
        if stalled > PATIENCE or not _iterate(k, system, now):
            break
        if largest_multiplier(k) > large:
            large = 4.0 * largest_multiplier(k)
            fixed = fix_immovable(k, system)
            mark_alive(k, system)
            if fixed:
                _start(k, system)
                bound, shared, best, stalled, began, large = (
                    np.inf,
                    np.inf,
                    np.inf,
                    0,
                    step + 1,
                    LARGE,
                )
    return step, _best_answer(k, system, bound, shared, step > began)


@compiled
def _best_answer(k, system, bound, shared, iterated):
    """Leave the cheapest answer at hand: settled, shared, or as applied; return its gap."""
    gap = bound - settle(k, system, G, EXCESS) if iterated else np.inf
    if iterated and gap > 10.0 * sqrt(LOOSE):
        gap = max(bound - settle(k, system, G, LOOSE), 0.0) + 10.0 * sqrt(LOOSE)
    if gap <= min(shared, bound):
        return max(gap, 0.0)
    if shared <= bound:
        share_torques(k, system)
        return shared
    for i in range(k.shape[0]):
        for j in range(3):
            k[i, ANSWER + j] = 0.0
    return bound


@compiled
def _iterate(k, system, now):
    """One step from complementarity ``now``, in place; return whether it led anywhere."""
    factorise(k, system)
    for i in range(k.shape[0]):
        for c in range(_active(k[i])):
            at = FIRST_CONE + CONE * c
            for r in range(4):
                k[i, at + Q + r] = -k[i, at + Z + r]
    direction(k, system, False)
    primal, dual = _step_lengths(k)
    primal, dual = min(1.0, primal), min(1.0, dual)
    ratio = min(max(_predicted(k, primal, dual) / now, 0.0), 1.0)
    for i in range(k.shape[0]):
        for c in range(_active(k[i])):
            correct(k[i], FIRST_CONE + CONE * c, now * ratio * ratio * ratio)
    direction(k, system, True)
    back = min(max(0.98, 1.0 - 0.1 * ratio), 0.999)
    primal, dual = _step_lengths(k)
    primal, dual = min(1.0, back * primal), min(1.0, back * dual)
    if not (primal > STUCK or dual > STUCK):  # also where they are not numbers
        return False
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            _advance_block(k[i], primal, dual)
    for r in range(6):
        system[NU, r] += dual * system[NU_STEP, r]
    return True


@compiled
def _active(row):
    """Number of cones of a block, 0 where nothing in it is variable."""
    return int(row[CONES]) if row[FREE] > 0.0 else 0


@compiled
def _start(k, system):
    """Begin in the middle of every ball, with multipliers that need no balance."""
    target, number = 0.0, 0
    for r in range(6):
        system[NU, r] = 0.0
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            target += k[i, PRICE] * norm3(k[i, V], k[i, V + 1], 0.0)
            number += 1
    target /= max(number, 1)
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
    """Put s of a ball to its centre, τ of a cost to twice the norm, and z to (c, 0)."""
    at = FIRST_CONE + CONE * c
    for r in range(CONE):
        row[at + r] = 0.0
    price = row[DISC_PRICE] if c == 3 else row[PRICE]
    if c == 1 or c == 2:
        price = SPREAD_BALL * target / (row[RADIUS] if c == 1 else 0.5 * abs(row[V + 1]))
    row[at + Z], row[at + DET_Z] = price, price * price
    first = 1 if c >= 2 else 0
    if c == 0 or c == 3:
        square = 0.0
        for j in range(first, 3):
            row[at + S + 1 + j] = row[REST + j]
            square += row[REST + j] * row[REST + j]
        row[at + S] = norm3(row[V] if c == 0 else 0.0, row[V + 1], 0.0)
        row[at + S] = max(row[at + S], SPREAD_COST * target / price)
        row[at + DET_S] = row[at + S] * row[at + S] - square
    else:
        row[at + S] = row[RADIUS] if c == 1 else 0.5 * abs(row[V + 1])
        row[at + DET_S] = row[at + S] * row[at + S]
    row[at + ERROR_S] = ROUNDING * row[at + S] * row[at + S]
    row[at + ERROR_Z] = ROUNDING * price * price


@compiled
def complementarity(k):
    """Mean of s·z over the cones."""
    total, number = 0.0, 0
    for i in range(k.shape[0]):
        for c in range(_active(k[i])):
            total += inner(k[i], FIRST_CONE + CONE * c)
            number += 1
    return total / max(number, 1)


@compiled
def _predicted(k, primal, dual):
    """Mean of s·z over the cones after steps of these lengths."""
    total, number = 0.0, 0
    for i in range(k.shape[0]):
        row = k[i]
        for c in range(_active(row)):
            at = FIRST_CONE + CONE * c
            for r in range(4):
                s = row[at + S + r] + primal * row[at + DS + r]
                total += s * (row[at + Z + r] + dual * row[at + DZ + r])
            number += 1
    return total / max(number, 1)


@compiled
def _step_lengths(k):
    """Longest steps that keep every s and every z in its cone."""
    primal, dual = np.inf, np.inf
    for i in range(k.shape[0]):
        row = k[i]
        for c in range(_active(row)):
            at = FIRST_CONE + CONE * c
            primal = min(primal, longest_step(row, at + S, at + DS, row[at + DET_S]))
            dual = min(dual, longest_step(row, at + Z, at + DZ, row[at + DET_Z]))
    return primal, dual


@compiled
def _advance_block(row, primal, dual):
    """Take the step; dets anew where that is the more accurate, balls' from g·(v − g)."""
    for j in range(int(row[FREE])):
        row[G + j] += primal * row[STEP + j]
        row[REST + j] -= primal * row[STEP + j]
    for c in range(int(row[CONES])):
        at = FIRST_CONE + CONE * c
        advance(row, at + S, at + DS, at + DET_S, primal)
        advance(row, at + Z, at + DZ, at + DET_Z, dual)
        refresh(row, at + Z, at + DET_Z)
        if c == 0 or c == 3:
            refresh(row, at + S, at + DET_S)
            continue
        inside, size = 0.0, 0.0
        for j in range(c - 1, int(row[FREE])):
            product = row[G + j] * row[REST + j]
            inside += product
            size += abs(product)
            row[at + S + 1 + j] = 0.5 * (row[G + j] - row[REST + j])
        if ROUNDING * size < row[at + ERROR_S] and inside > 2.0 * ROUNDING * size:
            row[at + DET_S], row[at + ERROR_S] = inside, ROUNDING * size
