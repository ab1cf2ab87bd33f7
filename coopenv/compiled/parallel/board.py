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

from coopenv.compiled.kinds import in_llvm

_WORD = 8  # [bytes]
LINE = 16  # words: what one thread writes often lies in lines of its own
TICKET, DONE, OWNER, AWAKE, CLOSED, TASK, ARGUMENTS, COUNT, PARTS, FAILED, NAP, BED = (
    LINE * number for number in range(12)
)
_SIZE = LINE * 12
JOB_BITS = 32  # where the number of a job begins in a ticket
END_BITS = 16  # of a ticket: the first part that is left, and before which they end
MOST_PARTS = 2**END_BITS - 1


def new_board() -> np.ndarray:
    """An empty board."""
    return np.zeros(_SIZE, dtype=np.int64)


def _place(context, builder, board, offset):
    """Pointer to a word of a board at an address."""
    del context
    at = builder.add(board, builder.mul(offset, ir.Constant(offset.type, _WORD)))
    return builder.inttoptr(at, ir.IntType(64).as_pointer())


@in_llvm
def read(typingctx, board, offset):
    """The word at ``offset`` of the board at an address, as all threads see it."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        return builder.load_atomic(_place(context, builder, *arguments), "seq_cst", _WORD)

    return types.intp(types.intp, types.intp), generate


@in_llvm
def write(typingctx, board, offset, value):
    """Write a word, so that whoever sees it sees also what was written before."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        builder.store_atomic(
            arguments[2], _place(context, builder, *arguments[:2]), "seq_cst", _WORD
        )
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp), generate


@in_llvm
def add(typingctx, board, offset, value):
    """Add to a word; what it was before."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        place = _place(context, builder, *arguments[:2])
        return builder.atomic_rmw("add", place, arguments[2], "seq_cst")

    return types.intp(types.intp, types.intp, types.intp), generate


@in_llvm
def exchanged(typingctx, board, offset, expected, value):
    """Whether a word was as ``expected``, and has become ``value``."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        place = _place(context, builder, *arguments[:2])
        found = builder.cmpxchg(place, *arguments[2:], "seq_cst", "seq_cst")
        return builder.extract_value(found, 1)

    return types.boolean(types.intp, types.intp, types.intp, types.intp), generate
