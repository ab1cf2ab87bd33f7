"""Conic solver for any number of effectors, in the plane or in space: a cone program for Clarabel.

Slow (milliseconds a sample) but general, and the oracle for the special solvers. Every vector is
measured in its own length, directions that are fixed anyway are taken out of the program, and where
all forces agree the answer is written down without iterating: there the feasible set is a point,
and an interior-point method loses half its digits.

Accuracy: a ball relaxed by ε lets the cost fall by √ε where the feasible set is thin, and Clarabel
relaxes every one. Its answer is therefore brought back into the balls (`feasible`), and its
multipliers through weak duality (`bound`), so that the optimum is within cost ± gap whatever
Clarabel says. The gap is large where no good plausible wrench or no good multipliers are found:
where forces nearly agree, or differ by factors of 10⁴ and more, and for some wrenches of small
integers. `docs/decomposition.md` says how large.

Source: Donner, Endo & Buss 2018, eqs. 17-21.
"""

from functools import partial
from typing import Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, in_rows
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.conic.bound import Bound, Duals, best_bound, default_duals
from coopenv.wrench.conic.cone_program import ConeProgram
from coopenv.wrench.conic.feasible import plausible, rounding_of, with_torques_shared
from coopenv.wrench.conic.parts import (
    PARALLEL,
    Parts,
    Prices,
    balance_unit,
    cost_of,
    direction,
    norm,
    parts_of,
    saving_of,
    sum_over,
)
from coopenv.wrench.conic.program import wrench_program
from coopenv.wrench.grasp import sum_at_centre
from coopenv.wrench.settings import Settings

TOLERANCE = 1e-10  # asked of Clarabel: feasibility, and gap relative to the applied cost
ACCEPTED = 1e-5  # gap and residuals up to which an early stop is not tried in other units
VANISHING = 1e-100  # part of the largest component below which the others' squares would underflow
GOOD = 1e-10  # gap in parts of J(h) that is not worth more work
POOR = 1e-4  # the same from which on Clarabel's nearly plausible answer is kept
UNSEEN = 1e-16  # of the largest part of h_I: what balance may miss without our seeing it
OVERFLOWING = 1e100  # beyond this a number of Clarabel's, in our units, tells nothing
TOGETHER = 256  # samples whose answers are judged and mended at once


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., n, 2)`` or ``(..., n, 3)`` [m], of any batch shape.
    settings
        Torque weight and whether induced torque is costed.
    """
    return partial(_solve, grips, settings)


def _solve(grips: FloatArray, settings: Settings, applied: FloatArray) -> Answer:
    """Manipulation wrenches and gaps [N]; samples one after the other."""
    w = settings.torque_weight
    weights = Prices(1.0 - w, w, settings.include_induced * w)
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    wrenches, places = in_rows(applied, batch), in_rows(grips, batch)
    largest = np.abs(wrenches).max(axis=(-1, -2), keepdims=True, initial=0.0)
    wrenches = np.where(np.abs(wrenches) > VANISHING * largest, wrenches, 0.0)
    manipulation, gap = _agreeing(wrenches, grips.shape[-1]), np.zeros(len(wrenches))
    unanswered = np.flatnonzero(np.isnan(manipulation[:, 0, 0]))
    for first in range(0, len(unanswered), TOGETHER):
        some = unanswered[first : first + TOGETHER]
        manipulation[some], gap[some] = _solve_samples(wrenches[some], places[some], weights)
    return Answer(manipulation.reshape(*batch, *applied.shape[-2:]), gap.reshape(batch))


def _agreeing(applied: FloatArray, dimension: int) -> FloatArray:
    """Answers where all forces agree, NaN elsewhere.

    Then the forces are all needed and the torques are shared along their sum (eqs. 22-23); where
    they agree too, the answer is the applied wrench itself.
    """
    force, torque = applied[..., :dimension], applied[..., dimension:]
    manipulation = applied.copy()
    differ = ~_parallel(torque)
    manipulation[differ] = with_torques_shared(applied[differ], dimension)
    manipulation[~_parallel(force)] = np.nan
    return manipulation


def _parallel(vectors: FloatArray) -> BoolArray:
    """Whether all vectors ``(..., n, d)`` of a sample point in the same direction, or vanish."""
    resultant = vectors.sum(axis=-2, keepdims=True)
    towards = direction(resultant)
    along = (vectors * towards).sum(axis=-1, keepdims=True)
    across = norm(vectors - along * towards)
    return np.asarray(((along[..., 0] >= 0.0) & (across <= PARALLEL * norm(vectors))).all(axis=-1))


def _solve_samples(
    applied: FloatArray, grips: FloatArray, weights: Prices
) -> tuple[FloatArray, FloatArray]:
    """Samples ``(m, n, k)``: Clarabel for each, then for all what its answers are worth."""
    whole = parts_of(applied, grips)
    cost = cost_of(whole, weights)
    duals = default_duals(whole, weights)
    manipulation = np.empty_like(applied)
    for i in range(len(applied)):
        own = Duals(*(values[i] for values in duals))
        sample = Parts(*(part[i] for part in whole))
        program, parts = wrench_program(sample, grips[i], weights, float(cost[i]), own)
        solution = _run(program)
        if solution is None:
            manipulation[i] = applied[i]  # and the default duals
            continue
        program.write_multipliers(solution)
        x = np.array(solution.x)
        manipulation[i] = [np.concatenate([f.value(x), t.value(x)]) for f, t in parts]
    bound = best_bound(whole, grips, weights, duals)
    wanted = bound.shortfall - GOOD * cost
    internal, saved, nearly = plausible(applied - manipulation, applied, grips, weights, wanted)
    surely = saved.copy()
    poor = (saved < bound.shortfall - POOR * cost) & ~np.isnan(nearly[:, 0, 0])
    if poor.any():  # a better answer, though its gap is no smaller
        internal[poor] = nearly[poor]
        saved[poor] = saving_of(parts_of(internal, grips), whole, weights)[poor]
    slack = np.minimum(_slack(internal, whole, grips, bound), np.maximum(saved, 0.0))  # J* ≤ J(h)
    gap = np.maximum(np.abs(bound.shortfall - saved), np.maximum(saved - surely, slack))
    return applied - internal, gap


def _slack(internal: FloatArray, whole: Parts, grips: FloatArray, bound: Bound) -> FloatArray:
    """Estimate how far below J* the cost may be, as answers are plausible only to rounding [N]."""
    parts = parts_of(internal, grips)
    missing = np.abs(sum_at_centre(internal, grips)) + UNSEEN * balance_unit(parts, grips)
    worth = sum_over(bound.balls, rounding_of(parts, whole, grips))
    return worth + (bound.balance * missing).sum(axis=-1)


def _run(program: ConeProgram) -> Any:
    """Solve in our units and, where that does not come far, in Clarabel's; what came farther.

    None where both broke down.
    """
    best, least = None, np.inf
    for equilibrate in (False, True):  # our units are better nearly always
        solution = program.solve(TOLERANCE, equilibrate)
        gap = abs(solution.obj_val - solution.obj_val_dual)
        error = np.max([gap, solution.r_prim, solution.r_dual])
        numbers = np.concatenate([solution.x, solution.z])
        if not (np.abs(numbers) <= OVERFLOWING).all():
            continue
        if best is None or error < least:
            best, least = solution, error
        if error <= ACCEPTED:
            break
    return best
