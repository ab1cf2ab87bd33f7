"""The iterations of the structured solver: Mehrotra's predictor and corrector, compiled."""

from math import sqrt

import numpy as np

from coopenv.compiled import fused
from coopenv.wrench.structured.agreement import certify, disagreement, share_torques, start_near
from coopenv.wrench.structured.balance import BALANCE, largest_component, mark_alive
from coopenv.wrench.structured.blocks import ANSWER, CONES, KEPT, G, chunk, num_chunks
from coopenv.wrench.structured.facial_reduction import fix_immovable
from coopenv.wrench.structured.feasible import BALANCED, EVENLY, EXCESS, LOOSE, clear, settle
from coopenv.wrench.structured.lanes import splat, total
from coopenv.wrench.structured.newton import improve, predict
from coopenv.wrench.structured.start import start
from coopenv.wrench.structured.step import take

PARALLEL = 1e-12  # sine of the angle below which forces count as parallel
THIN = 0.05  # sine below which they nearly agree
CLOSE = 1e-4  # sine below which the feasible set is so thin that careful steps pay
LARGE = 10.0  # multiplier of a ball from which on one looks for what cannot move
LONG, MORE = 16, 50  # iterations that few samples need, and chunks for which they need one more
MAX_STEPS = 80
PATIENCE = 10  # iterations without progress
CENTRED, SHORT = 0.1, 0.8  # what patient steps at least leave of s·z, and how far they go
GOOD = 1e-9  # gap, relative to J(h), of an answer that need not be better
WORTH, IDLE = 0.3, 2  # such an answer is made better until one more iteration than this leaves more
PROMISING = 1e-6  # gap of an iterate that is worth making an answer of
NEAR = 1e-7  # the same where the steps are likely to go well
DOUBTFUL = 1e-8  # gap of the answer kept from which on the last iterate is tried as well
STUCK = 1e-6  # step length that is none


@fused
def solve(sample, system, tolerance, patient):
    """Leave the best answer found in the blocks; return the iterations and its gap.

    The gap is relative to J(h). Iterating stops once it is within the tolerance, or once it is
    `GOOD` and hardly falls any more. Patient iterations are three times as many and reach a thin
    set from far outside, where others meet a ball before they are balanced and stay there.
    """
    mark_alive(sample, system)
    sine = disagreement(sample, system)
    shared = np.inf
    if sine < THIN:
        shared = certify(sample, system, sine)
        if shared <= GOOD or sine <= PARALLEL:
            return 0, shared
    start(sample, system)
    if sine < THIN:
        start_near(sample, system, sine)
    newest, saved, now, multiplier = take(sample, system, 0.0, 0.0)
    bound, best, stalled, step, began, large = np.inf, np.inf, 0, 0, 0, LARGE
    kept, gap, idle = -np.inf, np.inf, 0
    balanced = EVENLY if patient else BALANCED
    for step in range(MAX_STEPS):
        bound = min(bound, newest)
        if bound <= GOOD:
            break
        slow = stalled > 0 or step >= LONG + num_chunks(sample) // MORE
        careful = patient or slow or sine < CLOSE
        if step > began and bound - saved <= (PROMISING if careful else NEAR):
            kept = _keep(sample, settle(sample, system, G, EXCESS, balanced), kept)
            idle = idle + 1 if bound - kept > WORTH * gap else 0
            gap = min(gap, bound - kept)
            if gap <= tolerance or (gap <= GOOD and idle > IDLE):
                break
        progress = largest_component(system, BALANCE) + now
        stalled = 0 if progress < 0.9 * best else stalled + 1
        best = min(best, progress)
        if stalled > PATIENCE and not patient:
            break
        primal, dual = _step(sample, system, now, slow, careful, patient)
        if not (primal > STUCK or dual > STUCK):  # also where they are not numbers
            break
        newest, saved, now, multiplier = take(sample, system, primal, dual)
        if multiplier > large and gap > GOOD:
            large = 4.0 * multiplier
            fixed = fix_immovable(sample, system, multiplier)
            mark_alive(sample, system)
            if fixed:
                start(sample, system)
                newest, saved, now, multiplier = take(sample, system, 0.0, 0.0)
                bound, shared, best, kept = np.inf, np.inf, np.inf, -np.inf
                stalled, began, large = 0, step + 1, LARGE
    return step, _best_answer(sample, system, bound, shared, kept, step > began, balanced)


@fused
def _keep(sample, saved, kept):
    """Keep the candidate if it saves more than what was kept; return what is saved now."""
    if not saved > kept:
        return kept
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for j in range(3):
            b[KEPT + j] = b[ANSWER + j]
    return saved


@fused
def _best_answer(sample, system, bound, shared, kept, iterated, balanced):
    """Leave the cheapest answer at hand: settled, shared, or as applied; return its gap."""
    if iterated and bound - kept > min(DOUBTFUL, bound):
        kept = _keep(sample, settle(sample, system, G, EXCESS, balanced), kept)
        loose = settle(sample, system, G, LOOSE, balanced) - 10.0 * sqrt(LOOSE)
        if bound - kept > 10.0 * sqrt(LOOSE):
            kept = _keep(sample, loose, kept)
    if bound - kept <= min(shared, bound):
        for i in range(num_chunks(sample)):
            b = chunk(sample, i)
            for j in range(3):
                b[ANSWER + j] = b[KEPT + j]
        return max(bound - kept, 0.0)
    if shared <= bound:
        share_torques(sample, system)
        return shared
    clear(sample)
    return bound


@fused
def _step(sample, system, now, slow, careful, patient):
    """Predict and correct from complementarity ``now``; return the lengths of the step found.

    A careful step aims lower and stops farther from the boundary. A slow one is refined. A patient
    one stays central: it aims low only as far as the predictor's step has shown to go well.
    """
    number = splat(0.0)
    for i in range(num_chunks(sample)):
        number += chunk(sample, i)[CONES]
    primal, dual, moved, dual_moved, both = predict(sample, system)
    primal, dual = min(1.0, primal), min(1.0, dual)
    change = primal * moved + dual * dual_moved + primal * dual * both
    ratio = min(max(1.0 + change / (now * total(number)), 0.0), 1.0)
    target, back = now * ratio * ratio, max(0.98, 1.0 - 0.1 * ratio)
    if careful:
        target, back = target * ratio * ratio, max(0.8, 1.0 - 0.5 * ratio)
    if patient:
        missing = 1.0 - min(primal, dual)
        target, back = now * max(CENTRED, missing * missing), SHORT
    primal, dual, moved, dual_moved, both = improve(sample, system, target, slow or patient)
    if not abs(both) < np.inf:
        return 0.0, 0.0
    back = min(back, 0.999)
    return min(1.0, back * primal), min(1.0, back * dual)
