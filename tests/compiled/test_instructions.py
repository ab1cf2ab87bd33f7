"""Functions of compiled code that are made of instructions."""

import ctypes

from llvmlite import ir
from numba import types

from coopenv.compiled import compiled, instructions

LARGEST = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)(max)


@instructions.instruction(types.intp, types.intp, types.intp)
def twice_and(builder, value, more):
    """Twice the value, and more."""
    return builder.add(builder.add(value, value), more)


@instructions.instruction(types.intp, types.intp, types.intp, types.intp)
def at_address(builder, address, a, b):
    """What the function at an address makes of two numbers."""
    return instructions.call(builder, ir.IntType(64), address, a, b)


@compiled
def together(address, a, b):
    return at_address(address, twice_and(a, b), twice_and(b, a))


def test_kernels_run_instructions_and_call_addresses():
    address = ctypes.cast(LARGEST, ctypes.c_void_p).value
    assert together(address, 3, 4) == 11  # of 10 and 11
