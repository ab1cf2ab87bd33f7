"""Structured interior-point solver for any number of effectors, in time linear in their number.

A primal-dual method (`interior_point`), in the plane or in space. The effectors are coupled only by
the balance of force and torque, so every Newton step comes down to one system of 6 equations
(`newton`); four effectors are treated at once (`lanes`). Where the forces agree (`agreement`), as
those of a good team mostly do, the feasible set has no interior and the answer is written down
instead of iterated. Where an answer saves no more than `TRIFLE` and all of that may be rounding,
nothing counts as internal. (The constants named here are in `tolerances`.)

Every answer is balanced and inside every ball to rounding and carries a bound on its suboptimality
from the dual program (`bound`). A sample whose bound is worse than `RETRIED_GAP` is tried again
with shorter, more central steps, balance being taken about the middle of the grips (`alignment`);
one still worse than `ACCEPTED_GAP` is also given to another solver. The answer with the better
bound is kept.

The bound holds for the wrench as the solver reads it. Forces and torques below `NEGLIGIBLE` of the
largest are left as applied (dear torques below `NEGLIGIBLE_DEAR`), which the gap counts. A force
within `RADIAL` of its lever's direction counts as along it. Balance holds to `BALANCED`. Where the
feasible set is thin, the answer may be cheaper than the optimum by the root of rounding; the gap
contains an estimate of it (`bound.undercut`). `docs/decomposition.md` says how good the answers
are.

Source: Donner, Endo & Buss 2018, eqs. 17-21; the reduction and the bound are our own.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, in_rows
from coopenv.wrench.answer import Answer, Prepare, Solve
from coopenv.wrench.cores import on_all_cores
from coopenv.wrench.settings import Settings
from coopenv.wrench.structured.batch import (
    APPLIED_COST,
    GAP,
    ITERATIONS,
    REPORT,
    UNDERCUT,
    memory_for,
    solve_batch,
    solve_usual,
)
from coopenv.wrench.structured.tolerances import ACCEPTED_GAP, WANTED_GAP, WANTED_GAP_IN_PLANE

Kernel = Callable[..., int]  # `solve_usual` or `solve_batch`

WORTH_A_THREAD = 200  # effectors that occupy a core long enough for one to be started


def prepare(grips: FloatArray, settings: Settings, fall_back: Prepare) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., n, 2)`` or ``(..., n, 3)`` [m], of any batch shape.
    settings
        Torque weight and whether induced torque is costed.
    fall_back
        The solver to ask where an answer is not certified.
    """
    return partial(_solve, grips, settings, fall_back)


def _solve(
    grips: FloatArray, settings: Settings, fall_back: Prepare, applied: FloatArray
) -> Answer:
    """Manipulation wrenches, gaps [N], and where the answer is that of the other solver."""
    batch = np.broadcast_shapes(applied.shape[:-2], grips.shape[:-2])
    rows = in_rows(applied, batch)
    places = grips.reshape(1, *grips.shape[-2:]) if grips.ndim == 2 else in_rows(grips, batch)
    tolerance = WANTED_GAP_IN_PLANE if grips.shape[-1] == 2 else WANTED_GAP
    manipulation, report = iterate(rows, places, settings, tolerance)
    gap, applied_cost, undercut = report[:, GAP], report[:, APPLIED_COST], report[:, UNDERCUT]
    fell_back = np.zeros(len(rows), dtype=np.bool_)
    for index in np.flatnonzero(~(gap <= ACCEPTED_GAP * applied_cost)):
        place = places[index if len(places) > 1 else 0]
        answer = _better(fall_back(place, settings), rows[index], gap[index])
        if answer is not None:
            manipulation[index], gap[index] = answer
            fell_back[index], undercut[index] = True, 0.0  # the other has counted its own
    gap = gap + undercut
    shape = (*batch, *applied.shape[-2:])
    return Answer(manipulation.reshape(shape), gap.reshape(batch), fell_back.reshape(batch))


def iterate(
    applied: FloatArray,
    grips: FloatArray,
    settings: Settings,
    tolerance: float = WANTED_GAP,
    kernel: Kernel = solve_usual,
) -> tuple[FloatArray, FloatArray]:
    """Solve without falling back, on all cores where that pays; the same bits on any number.

    Parameters
    ----------
    applied
        ``(m, n, 3)`` or ``(m, n, 6)`` [N, N·m].
    grips
        ``(m, n, d)``, or ``(1, n, d)`` for all [m].
    settings
        Torque weight and whether induced torque is costed.
    tolerance
        Gap at which to stop, relative to the applied cost; below `WANTED_GAP` only as long as it
        falls fast.
    kernel
        What is asked first. Those few samples that `solve_usual` leaves out are given to
        `solve_batch`, which is compiled when there are some.

    Returns
    -------
    Manipulation wrenches, and a report ``(m, REPORT)`` whose columns `batch` names.
    """
    # one signature to compile for: C order, writeable
    applied, grips = (np.require(array, requirements=["C", "W"]) for array in (applied, grips))
    manipulation, report = np.empty(applied.shape), np.empty((len(applied), REPORT))
    weight, induced = settings.torque_weight, float(settings.include_induced)

    def ask(kernel: Kernel, rows: Any, answer: FloatArray, own: FloatArray) -> int:
        place = grips[rows] if len(grips) > 1 else grips
        memory = memory_for(applied.shape[1])
        return kernel(applied[rows], place, weight, induced, tolerance, answer, own, memory)

    def solve(part: slice) -> None:
        if ask(kernel, part, manipulation[part], report[part]) > 0:
            lacking = np.flatnonzero(report[part, ITERATIONS] < 0) + (part.start or 0)
            answer, own = manipulation[lacking], report[lacking]
            ask(solve_batch, lacking, answer, own)
            manipulation[lacking], report[lacking] = answer, own

    on_all_cores(solve, len(applied), WORTH_A_THREAD / applied.shape[1])
    return manipulation, report


def _better(solve: Solve, applied: FloatArray, gap: float) -> tuple[FloatArray, float] | None:
    """Answer of another solver and its own bound [N]; None where that is not below ``gap``."""
    answer = solve(applied)
    if answer.gap is None or not answer.gap < gap:
        return None
    return answer.manipulation, float(answer.gap)
