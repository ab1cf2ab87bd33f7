"""The compiled entry of `structured`: a batch of samples in, certified answers out."""

import inspect
from hashlib import sha256

import numpy as np
from numba import njit, types
from numba.core import cgutils
from numba.np.numpy_support import carray

from coopenv.wrench.structured import (
    agreement,
    alignment,
    blocks,
    curvature,
    interior_point,
    lanes,
    newton,
)
from coopenv.wrench.structured import balance as coupling
from coopenv.wrench.structured import bound as certificate
from coopenv.wrench.structured import cones as second_order
from coopenv.wrench.structured import facial_reduction as faces
from coopenv.wrench.structured import feasible as settling
from coopenv.wrench.structured import memory as fields
from coopenv.wrench.structured import start as central_start
from coopenv.wrench.structured import step as progress
from coopenv.wrench.structured.agreement import share_needed
from coopenv.wrench.structured.alignment import align, turn_back
from coopenv.wrench.structured.blocks import WIDTH, chunks_for, fill, write
from coopenv.wrench.structured.bound import neglected, saving, undercut
from coopenv.wrench.structured.feasible import clear, fit
from coopenv.wrench.structured.interior_point import solve
from coopenv.wrench.structured.lanes import compiled

FILES = (
    agreement,
    alignment,
    blocks,
    central_start,
    certificate,
    coupling,
    curvature,
    faces,
    fields,
    interior_point,
    lanes,
    newton,
    progress,
    second_order,
    settling,
)  # all that goes into the compiled code
LINE = 64  # bytes to which memory is aligned
TRIFLE = 1e-5  # part of J(h) that is not called internal if all of it may be rounding
WANTED = 1e-8  # gap, relative to J(h), above which a second attempt is made


@compiled
def _solve_sample(k, system, spare, wrench, grips, w, induced, tolerance, manipulation, report):
    """Answer a sample; where that is not certified, try again with patience and keep the better."""
    report[0], report[1], report[4] = np.inf, 0.0, 0.0
    for patient in (False, True):
        if not report[0] > max(WANTED, tolerance) * report[1]:
            return
        force, length, cost = fill(k, wrench, grips, w, induced, spare)
        steps, gap = 0, 0.0
        if patient:
            align(k, wrench, grips, (force, length), spare)
        if cost > 0.0:
            steps, gap = solve(k, system, tolerance, patient)
            share_needed(k, system)
        unit, saved, slack = cost * force, saving(k, blocks.ANSWER), 0.0
        if steps > 0:
            gap, saved, slack = _weighed(k, system, gap, saved)
        slack += neglected(k, system) if cost > 0.0 else 0.0
        if patient:
            if not (gap + slack) * unit < report[0] + report[4]:
                return
            turn_back(k, wrench, spare)
        write(k, wrench, force, length, manipulation)
        report[0], report[1] = gap * unit, unit
        report[2], report[3], report[4] = (1.0 - saved) * unit, steps, slack * unit


@compiled
def _weighed(k, system, gap, saved):
    """Return gap, saving and slack of the answer; a trifle that may be rounding is taken back."""
    fit(k)
    left = saving(k, blocks.ANSWER)
    gap += max(saved - left, 0.0)
    slack = undercut(k, system, left)
    if slack < left or left > TRIFLE:
        return gap, left, slack
    clear(k)
    return gap + left, 0.0, 0.0


@lanes.in_llvm
def _pointer(typing_context, address):
    """Take an integer for an address."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(address), generate


@compiled
def _uncounted(address, shape):
    """View of memory whose rows numba does not count the references to: that took half the time."""
    return carray(_pointer(address), shape, np.float64)


def _compile_batch():
    """Compile the entry, cached on disk for as long as none of the files it calls changes.

    numba looks at the file of the entry alone; what a closure holds goes into its key as well.
    """
    text = "".join(map(inspect.getsource, FILES))
    stamp = int(sha256(text.encode()).hexdigest()[:8], 16)

    @njit(error_model="numpy", nogil=True, fastmath={"contract"}, cache=True)
    def solve_batch(applied, grips, w, induced, tolerance, manipulation, report):
        if stamp < 0:
            return
        chunks = chunks_for(applied.shape[1])
        blocks_size = (chunks + 1) * WIDTH * lanes.LANES  # one more for sums
        system_size = coupling.SYSTEM * fields.TABLE_WIDTH
        memory = np.zeros(blocks_size + system_size + 30 + LINE // 8)
        at = (memory.ctypes.data + LINE - 1) // LINE * LINE
        k, system = (fields.four_at(at), chunks), fields.table_at(at + 8 * blocks_size)
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
            _solve_sample(k, system, spare, wrench, place, w, induced, tolerance, answer, report[j])
        memory[0] = 0.0  # what numba may free it after

    return solve_batch


solve_batch = _compile_batch()
"""Solve samples one after the other.

Parameters are ``(m, n, k)`` wrenches, ``(m, n, d)`` grips, or ``(1, n, d)`` for all, the weights,
and the wanted gap relative to J(h). Written are the manipulation wrenches ``(m, n, k)`` and
``(m, 5)``: gap, applied cost and cost [N], iterations, and by how much slack may undercut J* [N].
"""
