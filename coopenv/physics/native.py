"""What compiled code calls of the physics engine's library, by the addresses of its functions."""

from llvmlite import ir
from numba import types

from coopenv.compiled import instructions

STEP, EACH_BODY, SET_BODY, GET_BODY = range(4)  # entries of an array of addresses
NUM_CALLS = 4
SPACE, COMMANDS, REPORTS = range(3)  # of what a space is known by: it, and what it reads and writes
NUM_HANDLES = 3


@instructions.instruction(types.void, types.intp, types.intp, types.float64)
def step_space(builder, step, space, duration):
    """``cpSpaceStep(space, duration)``."""
    instructions.call(builder, ir.VoidType(), step, space, duration)


@instructions.instruction(types.void, types.intp, types.intp, types.intp, types.intp)
def each_body(builder, each, space, function, data):
    """``cpSpaceEachBody(space, function, data)``."""
    instructions.call(builder, ir.VoidType(), each, space, function, data)
