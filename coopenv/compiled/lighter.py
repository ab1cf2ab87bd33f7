"""What numba does over and over while it compiles a kernel, done in less time.

It goes through all instructions of a function six times for the variables in them, has LLVM read a
module for the size of every type that it meets, and tells of every call of LLVM, to nobody.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from llvmlite import binding
from llvmlite import ir as llvm
from numba.core import ir

_NO_VARIABLES = frozenset((str, int, float, bool, type(None), ir.Loc))
_sizes: dict[Any, int] = {}


@contextmanager
def lighter() -> Iterator[None]:
    """For whoever holds numba's lock of compilation, until this ends."""
    with ExitStack() as changed:
        changed.enter_context(_replaced(ir.Inst, "_rec_list_vars", _variables))
        changed.enter_context(_replaced(llvm.Type, "get_abi_size", _size))
        lock = getattr(getattr(binding.ffi, "lib", None), "_lock", None)
        changed.enter_context(_replaced(lock, "_cblist", []))
        yield


@contextmanager
def _replaced(owner: Any, name: str, value: Any) -> Iterator[None]:
    """Nothing is replaced in a numba that has no such thing."""
    if not hasattr(owner, name):
        yield
        return
    before = getattr(owner, name)
    setattr(owner, name, value)
    try:
        yield
    finally:
        setattr(owner, name, before)


def _variables(instruction: Any, value: Any) -> list[Any]:
    """The variables in what an instruction holds, as numba finds them."""
    if type(value) in _NO_VARIABLES:
        return []
    if isinstance(value, ir.Var):
        return [value]
    if isinstance(value, ir.Inst):
        return value.list_vars()
    if isinstance(value, dict):
        value = value.values()
    elif not isinstance(value, list | tuple):
        return []
    found = []
    for one in value:
        if type(one) not in _NO_VARIABLES:
            found += _variables(instruction, one)
    return found


_size_of: Any = getattr(llvm.Type, "get_abi_size", None)


def _size(kind: Any, target_data: Any, context: Any = None) -> int:
    """Bytes of a type; LLVM is asked once for each that is written alike."""
    key = str(kind), target_data, context
    if key not in _sizes:
        _sizes[key] = _size_of(kind, target_data, context)
    return _sizes[key]
