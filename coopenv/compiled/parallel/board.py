"""The board: where threads find work, and how compiled code reads and changes it.

It has one job at a time, in parts. Its ticket says which job, in the upper half, and in a quarter
each the first part that nobody has taken and the first behind those: who takes one off an end and
finds the ticket as it was has that part, and as long as a part is not done the job stays. So nobody
works on a job with another's arguments.

Who put the job there takes parts from the front, helpers from the back. So a part is done mostly by
the thread that did it in the last job, in whose cache its rows still are.
"""

import numpy as np
from llvmlite import ir
from numba import types

from coopenv.compiled import instructions

_WORD = 8  # [bytes]
LINE = 16  # words: what one thread writes often lies in lines of its own
TICKET, DONE, OWNER, AWAKE, CLOSED, TASK, ARGUMENTS, COUNT, PARTS, FAILED, NAP, BED = (
    LINE * number for number in range(12)
)
_SIZE = LINE * 12
JOB_BITS = 32  # where the number of a job begins in a ticket
END_BITS = 16  # of a ticket: the first part that is left, and before which they end
ONE_FRONT = 2**END_BITS  # a ticket's step to the next first part
MOST_PARTS = ONE_FRONT - 1


def new_board() -> np.ndarray:
    """An empty board."""
    return np.zeros(_SIZE, dtype=np.int64)


def _place(builder, board, offset):
    """Pointer to a word of a board at an address."""
    at = builder.add(board, builder.mul(offset, ir.Constant(offset.type, _WORD)))
    return builder.inttoptr(at, ir.IntType(64).as_pointer())


@instructions.instruction(types.intp, types.intp, types.intp)
def read(builder, board, offset):
    """The word at ``offset`` of the board at an address, as all threads see it."""
    return builder.load_atomic(_place(builder, board, offset), "seq_cst", _WORD)


@instructions.instruction(types.void, types.intp, types.intp, types.intp)
def write(builder, board, offset, value):
    """Write a word, so that whoever sees it sees also what was written before."""
    builder.store_atomic(value, _place(builder, board, offset), "seq_cst", _WORD)


@instructions.instruction(types.intp, types.intp, types.intp, types.intp)
def add(builder, board, offset, value):
    """Add to a word; what it was before."""
    return builder.atomic_rmw("add", _place(builder, board, offset), value, "seq_cst")


@instructions.instruction(types.boolean, types.intp, types.intp, types.intp, types.intp)
def exchanged(builder, board, offset, expected, value):
    """Whether a word was as ``expected``, and has become ``value``."""
    place = _place(builder, board, offset)
    return builder.extract_value(builder.cmpxchg(place, expected, value, "seq_cst", "seq_cst"), 1)
