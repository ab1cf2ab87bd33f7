"""Gates: where threads of compiled code sleep until another lets them through.

They are locks of Python's own library, which needs no interpreter for them. So a thread that is
woken does not first wait until the one that woke it lets go of the interpreter.
"""

import ctypes

import numpy as np
from llvmlite import ir
from numba import types

from coopenv.compiled import instructions

ACQUIRE, ACQUIRE_TIMED, RELEASE = range(3)  # entries of `functions`


def functions() -> np.ndarray:
    """Addresses of what `pass_through`, `nap` and `open_gate` call, in this process."""
    names = "PyThread_acquire_lock", "PyThread_acquire_lock_timed", "PyThread_release_lock"
    found = (getattr(ctypes.pythonapi, name) for name in names)
    return np.array([ctypes.cast(one, ctypes.c_void_p).value for one in found], dtype=np.int64)


def new_gate() -> int:
    """Address of a gate that is closed."""
    allocate, acquire = (
        ctypes.pythonapi.PyThread_allocate_lock,
        ctypes.pythonapi.PyThread_acquire_lock,
    )
    allocate.restype, acquire.argtypes = ctypes.c_void_p, (ctypes.c_void_p, ctypes.c_int)
    gate = allocate()
    if not gate:
        raise MemoryError("memory must suffice for a lock; free some")
    acquire(gate, 1)
    return gate


@instructions.instruction(types.void, types.intp, types.intp)
def pass_through(builder, acquire, gate):
    """Sleep until a gate is opened; it is closed again behind who passes."""
    flag = ir.IntType(32)
    instructions.call(builder, flag, acquire, gate, ir.Constant(flag, 1))


@instructions.instruction(types.void, types.intp, types.intp)
def open_gate(builder, release, gate):
    """Let who sleeps at a closed gate pass, or the next who comes."""
    instructions.call(builder, ir.VoidType(), release, gate)


@instructions.instruction(types.void, types.intp, types.intp, types.intp)
def nap(builder, acquire_timed, gate, duration):
    """Sleep ``duration`` [µs] at a gate that nobody opens."""
    flag = ir.IntType(32)
    instructions.call(builder, flag, acquire_timed, gate, duration, ir.Constant(flag, 0))
