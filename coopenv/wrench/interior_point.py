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
    SEEN,
    STEP,
    G,
    chunk,
    cone_of,
    num_chunks,
)
from coopenv.wrench.central_start import start
from coopenv.wrench.certificate import (
    EXCESS,
    LOOSE,
    block_saving,
    block_shortfall,
    settle,
)
from coopenv.wrench.coupling import (
    BALANCE,
    NU,
    NU_STEP,
    add_resultant,
    clear_resultant,
    collect_resultant,
    largest_component,
    mark_alive,
    seen,
)
from coopenv.wrench.faces import fix_immovable
from coopenv.wrench.lanes import larger, largest, size, splat, total, where
from coopenv.wrench.newton import improve, predict
from coopenv.wrench.second_order import (
    DET_S,
    DET_Z,
    DS,
    DZ,
    INNER,
    ROUNDING,
    S,
    Z,
    advance,
    compiled,
    inlined,
    inner,
    refresh,
    renew,
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
    found = measure(k, system, 0.0, 0.0)
    bound, best, stalled, step, began, large = np.inf, np.inf, 0, 0, 0, LARGE
    kept = -np.inf
    for step in range(MAX_STEPS):
        newest, saved, now, multiplier = found
        bound = min(bound, newest)
        if bound <= tolerance:
            break
        if step > began and bound - saved <= PROMISING:
            kept = _keep(k, settle(k, system, G, EXCESS), kept)
            if bound - kept <= tolerance:
                break
        progress = largest_component(system, BALANCE) + now
        stalled = 0 if progress < 0.9 * best else stalled + 1
        best = min(best, progress)
        if stalled > PATIENCE:
            break
        primal, dual = _step(k, system, now)
        if not (primal > STUCK or dual > STUCK):  # also where they are not numbers
            break
        found = measure(k, system, primal, dual)
        if found[3] > large:
            large = 4.0 * found[3]
            fixed = fix_immovable(k, system, found[3])
            mark_alive(k, system)
            if fixed:
                start(k, system)
                found = measure(k, system, 0.0, 0.0)
                bound, shared, best, kept = np.inf, np.inf, np.inf, -np.inf
                stalled, began, large = 0, step + 1, LARGE
    return step, _best_answer(k, system, bound, shared, kept, step > began)


@compiled
def _keep(k, saved, kept):
    """Keep the candidate if it saves more than what was kept; return what is saved now."""
    if not saved > kept:
        return kept
    for i in range(num_chunks(k)):
        b = chunk(k, i)
        for j in range(3):
            b[KEPT + j] = b[ANSWER + j]
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
        for i in range(num_chunks(k)):
            b = chunk(k, i)
            for j in range(3):
                b[ANSWER + j] = b[KEPT + j]
        return max(bound - kept, 0.0)
    if shared <= bound:
        share_torques(k, system)
        return shared
    for i in range(num_chunks(k)):
        b = chunk(k, i)
        for j in range(3):
            b[ANSWER + j] = 0.0
    return bound


@compiled
def _step(k, system, now):
    """Predict and correct from complementarity ``now``; return the lengths of the step found."""
    number = splat(0.0)
    for i in range(num_chunks(k)):
        number += chunk(k, i)[CONES]
    primal, dual, moved, dual_moved, both = predict(k, system)
    primal, dual = min(1.0, primal), min(1.0, dual)
    change = primal * moved + dual * dual_moved + primal * dual * both
    ratio = min(max(1.0 + change / (now * total(number)), 0.0), 1.0)
    primal, dual, moved, dual_moved, both = improve(k, system, now * ratio * ratio * ratio)
    if not abs(both) < np.inf:
        return 0.0, 0.0
    back = min(max(0.98, 1.0 - 0.1 * ratio), 0.999)
    return min(1.0, back * primal), min(1.0, back * dual)


@compiled
def measure(k, system, primal, dual):
    """Take a step of these lengths and see where it led, in one pass; r and Gᵀν are written.

    Returns the bound on J(h) − J*, J(h) − J, the mean of s·z, and the largest multiplier of a ball
    or disc.
    """
    for r in range(6):
        system[NU, r] += dual * system[NU_STEP, r] if dual > 0.0 else 0.0
        system[BALANCE, r] = 0.0
    clear_resultant(k)
    bound, saved, products = splat(0.0), splat(0.0), splat(0.0)
    number, multiplier = splat(0.0), splat(0.0)
    for i in range(num_chunks(k)):
        b = chunk(k, i)
        if primal > 0.0 or dual > 0.0:
            _advance_block(b, primal, dual)
        for c in range(int(largest(b[CONES]))):
            cone, present = cone_of(b, c), b[CONES] > c
            cone[INNER] = inner(cone)
            products += where(present, cone[INNER], 0.0)
            if c == 1 or c == 2:
                multiplier = larger(where(present, cone[Z], 0.0), multiplier)
        y0, y1, y2 = seen(b, system, NU, i & 1)
        b[SEEN], b[SEEN + 1], b[SEEN + 2] = y0, y1, y2
        bound += block_shortfall(b, y0, y1, y2)
        saved += block_saving(b, G)
        number += b[CONES]
        add_resultant(k, i, b[G], b[G + 1], b[G + 2])
    collect_resultant(k, system, BALANCE, -1.0)
    mean = total(products) / max(total(number), 1.0)
    return total(bound), total(saved), mean, largest(multiplier)


@inlined
def _advance_block(b, primal, dual):
    """Take the step; dets anew where that is the more accurate, balls' from g·(v − g)."""
    for j in range(3):
        b[G + j] += primal * b[STEP + j]
        b[REST + j] -= primal * b[STEP + j]
    for c in range(int(largest(b[CONES]))):
        cone = cone_of(b, c)
        advance(cone, S, DS, DET_S, primal)
        advance(cone, Z, DZ, DET_Z, dual)
        refresh(cone, Z, DET_Z)
        if c == 0 or c == 3:
            refresh(cone, S, DET_S)
        else:
            _renew_ball(b, cone, c)


@inlined
def _renew_ball(b, cone, c):
    """Take s and its det of a ball or disc from g and v − g."""
    inside, doubt = splat(0.0), splat(0.0)
    for j in range(c - 1, 3):
        part = where(b[FREE] > j, b[G + j] * b[REST + j], 0.0)
        inside = inside + part
        doubt = doubt + ROUNDING * size(part)
        there = (b[FREE] > j) & (b[CONES] > c)
        cone[S + 1 + j] = where(there, 0.5 * (b[G + j] - b[REST + j]), 0.0)
    renew(cone, DET_S, where(b[CONES] > c, inside, 0.0), doubt)
