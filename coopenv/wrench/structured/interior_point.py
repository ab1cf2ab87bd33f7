"""Primal-dual interior-point iterations of the structured solver; compiled.

Mehrotra's predictor and corrector (`newton`). *Careful* steps aim lower and stop farther from the
boundary. They are taken where the feasible set is thin. *Slow* steps, where there is no progress,
are careful and are refined, too. *Patient* steps, those of a second attempt, are refined and stay
central.

Source: S. Mehrotra, "On the implementation of a primal-dual interior point method", 1992.
"""

import numpy as np

from coopenv.compiled import fused
from coopenv.compiled.lanes.vectors import splat, total
from coopenv.wrench.structured.agreement import certify, disagreement, share_torques, start_near
from coopenv.wrench.structured.balance import BALANCE, largest_component, mark_alive
from coopenv.wrench.structured.blocks import ANSWER, CONES, KEPT, G, chunk, num_chunks
from coopenv.wrench.structured.facial_reduction import fix_immovable
from coopenv.wrench.structured.feasible import clear, settle
from coopenv.wrench.structured.newton import correct, predict
from coopenv.wrench.structured.start import start
from coopenv.wrench.structured.step import take
from coopenv.wrench.structured.tolerances import (
    BALANCED,
    BALANCED_PATIENT,
    CAREFUL_REACH,
    CAREFUL_REACH_LOSS,
    CHUNKS_PER_ITERATION,
    CLOSE,
    DOUBTFUL_GAP,
    EXCESS,
    GOOD_GAP,
    IDLE,
    LONGEST_REACH,
    LOOSE_EXCESS,
    LOOSE_GAIN,
    MAX_IDLE,
    MAX_ITERATIONS,
    MAX_STALLED,
    NO_STEP,
    PARALLEL,
    PATIENT_CENTRING,
    PATIENT_REACH,
    PROMISING_GAP,
    PROMISING_GAP_OF_LONG_STEPS,
    REACH,
    REACH_LOSS,
    STALLED,
    SUSPECT_GROWTH,
    SUSPECT_MULTIPLIER,
    THIN,
    USUAL_ITERATIONS,
)


def solving(for_all):
    """Make `solve`: for all samples, or for usual ones, which is compiled in less time."""

    @fused
    def solve(sample, system, tolerance, patient):
        """Leave the best answer found in the blocks; return the number of iterations and its gap.

        Gaps and savings are relative to J(h). Iterating stops once the gap is within the tolerance,
        or once it is within `GOOD_GAP` and hardly falls any more. Patient iterations are up to
        three times as many. They reach a thin set from far outside, where others meet a ball before
        they are balanced and stay there. A number below zero says that there is no answer, since
        something may be immovable and `for_all` is not wanted.
        """
        # where forces agree, share the torques
        mark_alive(sample, system)
        sine = disagreement(sample, system)
        gap_shared = np.inf
        if sine < THIN:
            gap_shared = certify(sample, system, sine)
            if gap_shared <= GOOD_GAP or sine <= PARALLEL:
                return 0, gap_shared

        # start
        start(sample, system)
        if sine < THIN:
            start_near(sample, system, sine)
        newest, saved, mean, multiplier = take(sample, system, 0.0, 0.0)
        bound, kept, gap = np.inf, -np.inf, np.inf
        least, stalled, idle, began, suspicious = np.inf, 0, 0, 0, SUSPECT_MULTIPLIER
        balanced = BALANCED_PATIENT if patient else BALANCED
        usual = USUAL_ITERATIONS + num_chunks(sample) // CHUNKS_PER_ITERATION
        iteration = 0
        for iteration in range(MAX_ITERATIONS):
            # bound what can be saved
            bound = min(bound, newest)
            if bound <= GOOD_GAP:
                break

            # keep the best answer, and stop where it is good enough
            slow = stalled > 0 or iteration >= usual
            careful = patient or slow or sine < CLOSE
            promising = PROMISING_GAP if careful else PROMISING_GAP_OF_LONG_STEPS
            if iteration > began and bound - saved <= promising:
                kept = _keep(sample, settle(sample, system, G, EXCESS, balanced), kept)
                idle = idle + 1 if bound - kept > IDLE * gap else 0
                gap = min(gap, bound - kept)
                if gap <= tolerance or (gap <= GOOD_GAP and idle > MAX_IDLE):
                    break

            # stop where there is no progress
            residual = largest_component(system, BALANCE) + mean
            stalled = 0 if residual < STALLED * least else stalled + 1
            least = min(least, residual)
            if stalled > MAX_STALLED and not patient:
                break

            # predict, correct and take the step
            primal, dual = _find_step(sample, system, mean, slow, careful, patient)
            if not (primal > NO_STEP or dual > NO_STEP):  # also where they are not numbers
                break
            newest, saved, mean, multiplier = take(sample, system, primal, dual)

            # where a multiplier grows without end, fix what cannot move and start afresh
            if multiplier > suspicious and gap > GOOD_GAP:
                if not for_all:
                    return -1, np.inf
                suspicious = SUSPECT_GROWTH * multiplier
                fixed = fix_immovable(sample, system, multiplier)
                mark_alive(sample, system)
                if fixed:
                    start(sample, system)
                    newest, saved, mean, multiplier = take(sample, system, 0.0, 0.0)
                    bound, kept, gap_shared = np.inf, -np.inf, np.inf
                    least, stalled, began = np.inf, 0, iteration + 1
                    suspicious = SUSPECT_MULTIPLIER
        iterated = iteration > began
        return iteration, _best_answer(sample, system, bound, gap_shared, kept, iterated, balanced)

    return solve


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
def _best_answer(sample, system, bound, gap_shared, kept, iterated, balanced):
    """Leave the cheapest answer at hand: kept, shared, or as applied; return its gap."""
    if iterated and bound - kept > min(DOUBTFUL_GAP, bound):
        kept = _keep(sample, settle(sample, system, G, EXCESS, balanced), kept)
        loose = settle(sample, system, G, LOOSE_EXCESS, balanced) - LOOSE_GAIN
        if bound - kept > LOOSE_GAIN:
            kept = _keep(sample, loose, kept)
    if bound - kept <= min(gap_shared, bound):
        for i in range(num_chunks(sample)):
            b = chunk(sample, i)
            for j in range(3):
                b[ANSWER + j] = b[KEPT + j]
        return max(bound - kept, 0.0)
    if gap_shared <= bound:
        share_torques(sample, system)
        return gap_shared
    clear(sample)
    return bound


@fused
def _find_step(sample, system, mean, slow, careful, patient):
    """Find the Newton step from where the mean of s·z is ``mean``; return its two lengths."""
    number = splat(0.0)
    for i in range(num_chunks(sample)):
        number += chunk(sample, i)[CONES]

    # predict how far one can go towards the optimum, and what that leaves of s·z
    primal, dual, moved, dual_moved, both = predict(sample, system)
    primal, dual = min(1.0, primal), min(1.0, dual)
    change = primal * moved + dual * dual_moved + primal * dual * both
    left = min(max(1.0 + change / (mean * total(number)), 0.0), 1.0)

    # choose what to aim at and how near to the boundary to go
    target, reach = mean * left * left, max(REACH, 1.0 - REACH_LOSS * left)
    if careful:
        target = target * left * left
        reach = max(CAREFUL_REACH, 1.0 - CAREFUL_REACH_LOSS * left)
    if patient:  # aim low only as far as the prediction has gone well
        missing = 1.0 - min(primal, dual)
        target, reach = mean * max(PATIENT_CENTRING, missing * missing), PATIENT_REACH

    # correct
    primal, dual, moved, dual_moved, both = correct(sample, system, target, slow or patient)
    if not abs(both) < np.inf:
        return 0.0, 0.0
    reach = min(reach, LONGEST_REACH)
    return min(1.0, reach * primal), min(1.0, reach * dual)
