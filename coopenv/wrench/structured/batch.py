"""The compiled entry of `structured`: a batch of samples in, certified answers out."""

import numpy as np
from numba import types
from numba.core import cgutils
from numba.np.numpy_support import carray

from coopenv.compiled import fused, fused_entry
from coopenv.wrench.structured.agreement import share_needed
from coopenv.wrench.structured.alignment import align, turn_back
from coopenv.wrench.structured.balance import SYSTEM
from coopenv.wrench.structured.blocks import ANSWER, WIDTH, chunks_for, fill, write
from coopenv.wrench.structured.bound import neglected, saving, undercut
from coopenv.wrench.structured.feasible import clear, fit
from coopenv.wrench.structured.interior_point import solve
from coopenv.wrench.structured.lanes import LANES, in_llvm
from coopenv.wrench.structured.memory import TABLE_WIDTH, four_at, table_at
from coopenv.wrench.structured.tolerances import RETRIED_GAP, TRIFLE

LINE = 64  # bytes to which memory is aligned


@fused
def _solve_sample(
    sample, system, spare, wrench, grips, w, induced, tolerance, manipulation, report
):
    """Answer a sample; where that is not certified, try again with patience and keep the better."""
    report[0], report[1], report[4] = np.inf, 0.0, 0.0
    for patient in (False, True):
        if not report[0] > max(RETRIED_GAP, tolerance) * report[1]:
            return
        force, length, cost = fill(sample, wrench, grips, w, induced, spare)
        steps, gap = 0, 0.0
        if patient:
            align(sample, wrench, grips, (force, length), spare)
        if cost > 0.0:
            steps, gap = solve(sample, system, tolerance, patient)
            share_needed(sample, system)
        unit, saved, slack = cost * force, saving(sample, ANSWER), 0.0
        if steps > 0:
            gap, saved, slack = _weighed(sample, system, gap, saved)
        slack += neglected(sample, system) if cost > 0.0 else 0.0
        if patient:
            if not (gap + slack) * unit < report[0] + report[4]:
                return
            turn_back(sample, wrench, spare)
        write(sample, wrench, force, length, manipulation)
        report[0], report[1] = gap * unit, unit
        report[2], report[3], report[4] = (1.0 - saved) * unit, steps, slack * unit


@fused
def _weighed(sample, system, gap, saved):
    """Return gap, saving and slack of the answer; a trifle that may be rounding is taken back."""
    fit(sample)
    left = saving(sample, ANSWER)
    gap += max(saved - left, 0.0)
    slack = undercut(sample, system, left)
    if slack < left or left > TRIFLE:
        return gap, left, slack
    clear(sample)
    return gap + left, 0.0, 0.0


@in_llvm
def _pointer(typing_context, address):
    """Take an integer for an address."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


@fused
def _uncounted(address, shape):
    """View of memory whose rows numba does not count the references to: that took half the time."""
    return carray(_pointer(address), shape, np.float64)


@fused_entry
def solve_batch(applied, grips, w, induced, tolerance, manipulation, report):
    """Solve samples one after the other.

    Parameters are ``(m, n, k)`` wrenches, ``(m, n, d)`` grips, or ``(1, n, d)`` for all, the
    weights, and the wanted gap relative to J(h). Written are the manipulation wrenches
    ``(m, n, k)`` and ``(m, 5)``: gap, applied cost and cost [N], iterations, and by how much slack
    may undercut J* [N].
    """
    chunks = chunks_for(applied.shape[1])
    blocks_size = (chunks + 1) * WIDTH * LANES  # one more for sums
    system_size = SYSTEM * TABLE_WIDTH
    memory = np.zeros(blocks_size + system_size + 30 + LINE // 8)
    at = (memory.ctypes.data + LINE - 1) // LINE * LINE
    sample, system = (four_at(at), chunks), table_at(at + 8 * blocks_size)
    at += 8 * (blocks_size + system_size)
    spare = (
        _uncounted(at, 6),
        _uncounted(at + 48, 3),
        _uncounted(at + 72, (3, 3)),
        _uncounted(at + 144, 3),
        _uncounted(at + 168, (3, 3)),
    )
    for j in range(applied.shape[0]):
        place = grips[j if grips.shape[0] > 1 else 0]
        wrench, answer = applied[j], manipulation[j]
        _solve_sample(
            sample, system, spare, wrench, place, w, induced, tolerance, answer, report[j]
        )
    memory[0] = 0.0  # what numba may free it after
