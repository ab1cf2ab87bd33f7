"""Gates: where threads of compiled code sleep until another lets them through.

They are locks of Python's own library, which needs no interpreter for them. So a thread that is
woken does not first wait until the one that woke it lets go of the interpreter.
"""

import ctypes

import numpy as np
from llvmlite import ir
from numba import types

from coopenv.compiled.kinds import in_llvm

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


@in_llvm
def pass_through(typingctx, acquire, gate):
    """Sleep until a gate is opened; it is closed again behind who passes."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        kind = ir.FunctionType(ir.IntType(32), (ir.IntType(64), ir.IntType(32)))
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, (arguments[1], ir.Constant(ir.IntType(32), 1)))
        return context.get_dummy_value()

    return types.void(types.intp, types.intp), generate


@in_llvm
def open_gate(typingctx, release, gate):
    """Let who sleeps at a closed gate pass, or the next who comes."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        kind = ir.FunctionType(ir.VoidType(), (ir.IntType(64),))
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, (arguments[1],))
        return context.get_dummy_value()

    return types.void(types.intp, types.intp), generate


@in_llvm
def nap(typingctx, acquire_timed, gate, duration):
    """Sleep ``duration`` [µs] at a gate that nobody opens."""
    del typingctx

    def generate(context, builder, signature, arguments):
        del signature
        word, flag = ir.IntType(64), ir.IntType(32)
        kind = ir.FunctionType(flag, (word, word, flag))
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, (arguments[1], arguments[2], ir.Constant(flag, 0)))
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp), generate
