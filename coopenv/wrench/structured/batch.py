"""Solving a batch of samples with the structured solver: the compiled entry that Python calls."""

from functools import cache

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import fused, fused_entry
from coopenv.compiled.lanes.memory import TABLE_WIDTH, array_at, four_at, table_at
from coopenv.compiled.lanes.vectors import LANES
from coopenv.wrench.structured.agreement import room_in, share_needed
from coopenv.wrench.structured.alignment import align, turn_back
from coopenv.wrench.structured.balance import SYSTEM
from coopenv.wrench.structured.blocks import (
    ANSWER,
    WIDTH,
    Options,
    Sample,
    Spare,
    chunks_for,
    fill,
    write,
)
from coopenv.wrench.structured.bound import neglected, saving, undercut
from coopenv.wrench.structured.feasible import clear, fit
from coopenv.wrench.structured.interior_point import solving
from coopenv.wrench.structured.tolerances import RETRIED_GAP, TRIFLE

GAP, APPLIED_COST, COST = 0, 1, 2  # columns of a report [N]
ITERATIONS = 3
UNDERCUT = 4  # by how much rounding may have brought the cost below the optimum [N]
REPORT = 5  # columns in all

NUMBER = 8  # bytes
LINE = 64  # bytes to which memory is aligned
SPARE_NUMBERS = 30


@fused_entry
def solve_batch(applied, grips, torque_weight, induced, tolerance, manipulation, report, memory):
    """Solve samples one after the other.

    Parameters
    ----------
    applied
        ``(m, n, 3)`` or ``(m, n, 6)`` [N, N·m].
    grips
        ``(m, n, 2)`` or ``(m, n, 3)``, or the same with m = 1 for all samples [m].
    torque_weight
        w of eq. 17.
    induced
        s of eq. 17, 0.0 or 1.0.
    tolerance
        Wanted gap, relative to the applied cost.
    manipulation
        To be written, as ``applied``.
    report
        To be written, ``(m, REPORT)``: `GAP`, `APPLIED_COST`, `COST`, `ITERATIONS`, `UNDERCUT`.
    memory
        To work in, as `memory_for` makes it.

    Returns
    -------
    Zero: no answer is lacking.
    """
    sample, system, spare = _parted(memory.ctypes.data, chunks_for(applied.shape[1]))
    options = Options(torque_weight, induced, tolerance)
    for j in range(applied.shape[0]):
        place = grips[j if grips.shape[0] > 1 else 0]
        answer, own = manipulation[j], report[j]
        _solve_sample(sample, system, spare, applied[j], place, options, answer, own)
    return 0


@fused_entry
def solve_usual(applied, grips, torque_weight, induced, tolerance, manipulation, report, memory):
    """`solve_batch` without what few samples need; of these `ITERATIONS` are below zero.

    It is compiled in less time, and what it answers is answered alike.

    Returns
    -------
    How many samples these are.
    """
    lacking = 0
    sample, system, spare = _parted(memory.ctypes.data, chunks_for(applied.shape[1]))
    options = Options(torque_weight, induced, tolerance)
    for j in range(applied.shape[0]):
        place = grips[j if grips.shape[0] > 1 else 0]
        units = fill(sample, applied[j], place, options, spare)
        iterations, gap, saved, slack = _answer_usual(sample, system, units, tolerance, False)
        write(sample, applied[j], units, manipulation[j])
        _tell(report[j], units, iterations, gap, saved, slack)
        if iterations < 0 or _is_doubtful(report[j], tolerance):
            report[j, ITERATIONS] = -1.0
            lacking += 1
    return lacking


def memory_for(num_effectors: int) -> FloatArray:
    """Memory for samples of so many effectors, one after the other; a thread needs its own."""
    return np.zeros(_numbers_for(num_effectors))


@cache
def _numbers_for(num_effectors: int) -> int:
    blocks = (chunks_for(num_effectors) + 1) * WIDTH * LANES  # one more for sums
    return blocks + SYSTEM * TABLE_WIDTH + SPARE_NUMBERS + LINE // NUMBER


@fused
def _parted(address, chunks):
    """Sample, system and spare memory at an address."""
    first = (address + LINE - 1) // LINE * LINE
    sample = Sample(four_at(first), chunks)
    at = first + NUMBER * (chunks + 1) * WIDTH * LANES
    system = table_at(at)
    at += NUMBER * SYSTEM * TABLE_WIDTH
    spare = Spare(
        array_at(at, 6),
        array_at(at + 6 * NUMBER, 3),
        array_at(at + 9 * NUMBER, (3, 3)),
        array_at(at + 18 * NUMBER, 3),
        array_at(at + 21 * NUMBER, (3, 3)),
    )
    return sample, system, spare


@fused
def _solve_sample(sample, system, spare, wrench, grips, options, manipulation, report):
    """Answer a sample; where that is not certified, try again with patience and keep the better."""
    report[GAP], report[APPLIED_COST], report[UNDERCUT] = np.inf, 0.0, 0.0
    for patient in (False, True):
        if not _is_doubtful(report, options.tolerance):
            return
        units = fill(sample, wrench, grips, options, spare)
        if patient:
            align(sample, wrench, grips, units, spare)
        iterations, gap, saved, slack = _answer(sample, system, units, options.tolerance, patient)
        if patient:
            if not (gap + slack) * units.cost * units.force < report[GAP] + report[UNDERCUT]:
                return
            turn_back(sample, wrench, spare)
        write(sample, wrench, units, manipulation)
        _tell(report, units, iterations, gap, saved, slack)


@fused
def _is_doubtful(report, tolerance):
    """Whether the gap is such that a second attempt is made."""
    return report[GAP] > max(RETRIED_GAP, tolerance) * report[APPLIED_COST]


@fused
def _tell(report, units, iterations, gap, saved, slack):
    """Write the row of a report."""
    unit = units.cost * units.force
    report[GAP], report[APPLIED_COST] = gap * unit, unit
    report[COST], report[ITERATIONS] = (1.0 - saved) * unit, iterations
    report[UNDERCUT] = slack * unit


def _answering(for_all):
    """Make what leaves an answer in the blocks, by `solving`."""
    solve = solving(for_all)

    @fused
    def answer(sample, system, units, tolerance, patient):
        """Return iterations, gap, saving and slack."""
        iterations, gap = 0, 0.0
        if units.cost > 0.0:
            iterations, gap = solve(sample, system, tolerance, patient)
            share_needed(sample, system)
        saved, slack = saving(sample, ANSWER), 0.0
        if iterations > 0:
            gap, saved, slack = _weighed(sample, system, gap, saved)
        slack += neglected(sample, system) if units.cost > 0.0 else 0.0
        return iterations, gap, saved, slack

    return answer


@fused
def _weighed(sample, system, gap, saved):
    """Return gap, saving and slack of the answer; a trifle that may be rounding is taken back."""
    fit(sample)
    left = saving(sample, ANSWER)
    gap += max(saved - left, 0.0)
    depth, shared = room_in(sample, system)
    slack = undercut(sample, system, left, left - shared, depth)
    if slack < left or left > TRIFLE:
        return gap, left, slack
    clear(sample)
    return max(gap + left, 0.0), 0.0, 0.0  # left is negative where sharing torques cost rounding


_answer, _answer_usual = _answering(for_all=True), _answering(for_all=False)
