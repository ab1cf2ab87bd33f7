"""Solving a batch of samples with the structured solver: the compiled entry that Python calls."""

import numpy as np

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
from coopenv.wrench.structured.interior_point import solve
from coopenv.wrench.structured.tolerances import RETRIED_GAP, TRIFLE

GAP, APPLIED_COST, COST = 0, 1, 2  # columns of a report [N]
ITERATIONS = 3
UNDERCUT = 4  # by how much rounding may have brought the cost below the optimum [N]
REPORT = 5  # columns in all

NUMBER = 8  # bytes
LINE = 64  # bytes to which memory is aligned
SPARE_NUMBERS = 30


@fused_entry
def solve_batch(applied, grips, torque_weight, induced, tolerance, manipulation, report):
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
    """
    chunks = chunks_for(applied.shape[1])
    memory = np.zeros(_numbers_for(chunks))
    sample, system, spare = _parted(memory.ctypes.data, chunks)
    options = Options(torque_weight, induced, tolerance)
    for j in range(applied.shape[0]):
        place = grips[j if grips.shape[0] > 1 else 0]
        answer, own = manipulation[j], report[j]
        _solve_sample(sample, system, spare, applied[j], place, options, answer, own)
    memory[0] = 0.0  # keeps it alive: numba frees it after the last use it sees


@fused
def _numbers_for(chunks):
    """Numbers of memory that a batch needs."""
    blocks = (chunks + 1) * WIDTH * LANES  # one more for sums
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
        if not report[GAP] > max(RETRIED_GAP, options.tolerance) * report[APPLIED_COST]:
            return
        units = fill(sample, wrench, grips, options, spare)
        iterations, gap = 0, 0.0
        if patient:
            align(sample, wrench, grips, units, spare)
        if units.cost > 0.0:
            iterations, gap = solve(sample, system, options.tolerance, patient)
            share_needed(sample, system)
        unit, saved, slack = units.cost * units.force, saving(sample, ANSWER), 0.0
        if iterations > 0:
            gap, saved, slack = _weighed(sample, system, gap, saved)
        slack += neglected(sample, system) if units.cost > 0.0 else 0.0
        if patient:
            if not (gap + slack) * unit < report[GAP] + report[UNDERCUT]:
                return
            turn_back(sample, wrench, spare)
        write(sample, wrench, units, manipulation)
        report[GAP], report[APPLIED_COST] = gap * unit, unit
        report[COST], report[ITERATIONS] = (1.0 - saved) * unit, iterations
        report[UNDERCUT] = slack * unit


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
