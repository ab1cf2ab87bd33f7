"""What compiled code calls of the physics engine's library, by the addresses of its functions."""

from llvmlite import ir
from numba import types

from coopenv.compiled import in_llvm

STEP, EACH_BODY, SET_BODY, GET_BODY = range(4)  # entries of an array of addresses
NUM_CALLS = 4
SPACE, COMMANDS, REPORTS = range(3)  # of what a space is known by: it, and what it reads and writes
NUM_HANDLES = 3


@in_llvm
def step_space(typingctx, step, space, duration):
    """``cpSpaceStep(space, duration)``."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        kind = ir.FunctionType(ir.VoidType(), (ir.IntType(64), ir.DoubleType()))
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.float64), generate


@in_llvm
def each_body(typingctx, each, space, function, data):
    """``cpSpaceEachBody(space, function, data)``."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        kind = ir.FunctionType(ir.VoidType(), (ir.IntType(64),) * 3)
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp, types.intp), generate
