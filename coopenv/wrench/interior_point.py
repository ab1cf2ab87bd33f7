"""The iterations of the structured solver: Mehrotra's predictor and corrector, compiled."""

from math import sqrt

import numpy as np

from coopenv.wrench.agreement import certify, disagreement, share_torques, start_near
from coopenv.wrench.blocks import (
    ANSWER,
    CONES,
    FREE,
    KEPT,
    REST,
    STEP,
    G,
    cone_of,
)
from coopenv.wrench.central_start import start
from coopenv.wrench.certificate import EXCESS, LOOSE, saving, settle, shortfall
from coopenv.wrench.coupling import NU, NU_STEP, mark_alive, resultant
from coopenv.wrench.faces import fix_immovable, largest_multiplier
from coopenv.wrench.newton import direction, factorise
from coopenv.wrench.second_order import (
    DET_S,
    DET_Z,
    DS,
    DZ,
    ERROR_S,
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
PATIENCE = 10  # iterations without progress
PROMISING = 1e-6  # gap of an iterate that is worth making an answer of
DOUBTFUL = 1e-8  # gap of the answer kept from which on the last iterate is tried as well
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
    start(k, system)
    if sine < THIN:
        start_near(k, system, sine)
    bound, best, stalled, step, began, large = np.inf, np.inf, 0, 0, 0, LARGE
    kept = -np.inf
    for step in range(MAX_STEPS):
        bound = min(bound, shortfall(k, system))
        if bound <= tolerance:
            break
        if step > began and bound - saving(k, G) <= PROMISING:
            kept = _keep(k, settle(k, system, G, EXCESS), kept)
            if bound - kept <= tolerance:
                break
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
                start(k, system)
                bound, shared, best, kept = np.inf, np.inf, np.inf, -np.inf
                stalled, began, large = 0, step + 1, LARGE
    return step, _best_answer(k, system, bound, shared, kept, step > began)


@compiled
def _keep(k, saved, kept):
    """Keep the candidate if it saves more than what was kept; return what is saved now."""
    if not saved > kept:
        return kept
    for i in range(k.shape[0]):
        for j in range(3):
            k[i, KEPT + j] = k[i, ANSWER + j]
    return saved


@compiled
def _best_answer(k, system, bound, shared, kept, iterated):
    """Leave the cheapest answer at hand: settled, shared, or as applied; return its gap."""
    if iterated and bound - kept > min(DOUBTFUL, bound):
        kept = _keep(k, settle(k, system, G, EXCESS), kept)
        loose = settle(k, system, G, LOOSE) - 10.0 * sqrt(LOOSE)
        if bound - kept > 10.0 * sqrt(LOOSE):
            kept = _keep(k, loose, kept)
    if bound - kept <= min(shared, bound):
        for i in range(k.shape[0]):
            for j in range(3):
                k[i, ANSWER + j] = k[i, KEPT + j]
        return max(bound - kept, 0.0)
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
            cone = cone_of(k[i], c)
            for r in range(4):
                cone[Q + r] = -cone[Z + r]
    direction(k, system, False)
    primal, dual = _step_lengths(k)
    primal, dual = min(1.0, primal), min(1.0, dual)
    ratio = min(max(_predicted(k, primal, dual) / now, 0.0), 1.0)
    for i in range(k.shape[0]):
        for c in range(_active(k[i])):
            correct(cone_of(k[i], c), now * ratio * ratio * ratio)
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
def complementarity(k):
    """Mean of s·z over the cones."""
    total, number = 0.0, 0
    for i in range(k.shape[0]):
        for c in range(_active(k[i])):
            total += inner(cone_of(k[i], c))
            number += 1
    return total / max(number, 1)


@compiled
def _predicted(k, primal, dual):
    """Mean of s·z over the cones after steps of these lengths."""
    total, number = 0.0, 0
    for i in range(k.shape[0]):
        row = k[i]
        for c in range(_active(row)):
            cone = cone_of(row, c)
            for r in range(4):
                s = cone[S + r] + primal * cone[DS + r]
                total += s * (cone[Z + r] + dual * cone[DZ + r])
            number += 1
    return total / max(number, 1)


@compiled
def _step_lengths(k):
    """Longest steps that keep every s and every z in its cone."""
    primal, dual = np.inf, np.inf
    for i in range(k.shape[0]):
        row = k[i]
        for c in range(_active(row)):
            cone = cone_of(row, c)
            primal = min(primal, longest_step(cone, S, DS, cone[DET_S]))
            dual = min(dual, longest_step(cone, Z, DZ, cone[DET_Z]))
    return primal, dual


@compiled
def _advance_block(row, primal, dual):
    """Take the step; dets anew where that is the more accurate, balls' from g·(v − g)."""
    for j in range(int(row[FREE])):
        row[G + j] += primal * row[STEP + j]
        row[REST + j] -= primal * row[STEP + j]
    for c in range(int(row[CONES])):
        cone = cone_of(row, c)
        advance(cone, S, DS, DET_S, primal)
        advance(cone, Z, DZ, DET_Z, dual)
        refresh(cone, Z, DET_Z)
        if c == 0 or c == 3:
            refresh(cone, S, DET_S)
            continue
        inside, size = 0.0, 0.0
        for j in range(c - 1, int(row[FREE])):
            product = row[G + j] * row[REST + j]
            inside += product
            size += abs(product)
            cone[S + 1 + j] = 0.5 * (row[G + j] - row[REST + j])
        if ROUNDING * size < cone[ERROR_S] and inside > 2.0 * ROUNDING * size:
            cone[DET_S], cone[ERROR_S] = inside, ROUNDING * size
