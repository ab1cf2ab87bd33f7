"""Compilation with numba: one spelling for each kind, and a cache that knows what a kernel uses.

``@compiled``
    Called from Python or from other kernels; cached on disk.
``@inlined``
    Always put into the kernel that calls it, where a call would cost more than the work.
``@anywhere``
    The same arithmetic for all: Python calls it as it is, with numbers or arrays of any shape, and
    a kernel that calls it has it compiled in.
``@gufunc(layout, signature)``
    A NumPy ufunc over any batch shape.
``@fused``, ``@fused_inlined``, ``@fused_entry``
    The same for code in which a product and a sum may become one instruction: helpers, which
    only compiled code can call and which are cached with whoever calls them, and the function that
    Python calls.

Between kernels, numbers that belong together go as a named tuple, at no cost. What Python calls
takes its arrays one by one, as unpacking a named tuple takes longer than a small batch.

In all of them dividing by zero is no error, and the interpreter's lock is released (for gufuncs by
NumPy).

Numba recompiles a cached kernel when the kernel's own file changes. Here a kernel is recompiled
also when a file changes from which it takes compiled helpers or named tuples, directly or through
others, and when a constant does: what it depends on is found from what its module imports.
"""

import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from hashlib import sha256
from os.path import dirname
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, TypeVar
from weakref import WeakSet

import numpy as np
from numba import guvectorize, njit
from numba.core.caching import CompileResultCacheImpl
from numba.core.dispatcher import Dispatcher
from numba.extending import register_jitable
from numba.np.ufunc.wrappers import GufWrapperCache

TINY = 1e-300  # keeps divisions finite where the numerator is zero as well

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

_CACHED: dict[str, Any] = {"error_model": "numpy", "nogil": True, "cache": True}
_FUSED: dict[str, Any] = {"error_model": "numpy", "nogil": True, "fastmath": {"contract"}}
_HELPER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that Python or other kernels call."""
    return njit(**_CACHED)(_known(function))


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it."""
    return njit(**_CACHED, forceinline=True)(_known(function))


def anywhere(function: Kernel) -> Kernel:
    """Leave a function to Python as it is, and compile it into each kernel that calls it."""
    _ANYWHERE.add(function)
    register_jitable(error_model="numpy", forceinline=True)(_known(function))
    return function


def fused(function: Callable[..., Any]) -> Any:
    """Compile a helper of kernels in which products and sums may be fused."""
    return njit(**_FUSED, **_HELPER)(function)


def fused_inlined(function: Callable[..., Any]) -> Any:
    """Compile such a helper into each kernel that calls it."""
    return njit(**_FUSED, **_HELPER, forceinline=True)(function)


def fused_entry(function: Callable[..., Any]) -> Any:
    """Compile the function through which Python calls kernels whose products and sums are fused."""
    return njit(**_FUSED, cache=True)(_known(function))


def gufunc(layout: str, signature: str) -> Callable[[Callable[..., None]], Any]:
    """Compile a float64 kernel to a NumPy gufunc that broadcasts over any batch shape.

    The decorator returns NumPy's own ufunc instead of numba's wrapper, which is slower to call.
    NumPy releases the interpreter lock while the kernel runs.

    A kernel must not divide by zero nor take the root of a negative number, even in a branch that
    is not taken (LLVM may compute both): NumPy would warn. Nor may it allocate: numba's allocator
    is not set up when a gufunc comes from the cache.

    Parameters
    ----------
    layout
        NumPy's signature, such as ``"(n,k),(n,d)->(k)"``.
    signature
        Numba's, such as ``"void(float64[:,:], float64[:,:], float64[:])"``.
    """

    def compile_kernel(kernel: Callable[..., None]) -> Any:
        made = guvectorize([signature], layout, cache=True)(_known(kernel))
        if not _is_linked(made):
            GufWrapperCache(py_func=kernel).flush()
            made = guvectorize([signature], layout, cache=True)(kernel)
        return made.ufunc

    return compile_kernel


def _is_linked(made: Any) -> bool:
    """Whether every loop of the gufunc has an address.

    Numba caches a kernel and its gufunc loop apart, under a name that differs from process to
    process. Where two processes compile at the same time, the cache can keep the kernel of one and
    the loop of the other: the loop is not found, its address is 0, and the first call would crash,
    in every later process too. (Seen with numba 0.68.)
    """
    builder = made.gufunc_builder
    return all(builder.build(builder._cres[signature])[1] for signature in builder._sigs)


_KERNELS: WeakSet[Any] = WeakSet()  # the Python functions of all that is cached
_ANYWHERE: WeakSet[Any] = WeakSet()  # those that Python calls as they are
_PACKAGES: set[str] = set()  # where they come from; helpers are looked for nowhere else


def _known(function: Callable[..., Any]) -> Callable[..., Any]:
    _KERNELS.add(function)
    _PACKAGES.add(function.__module__.partition(".")[0])
    return function


class _Locator:
    """Where numba keeps a kernel of ours, with a stamp of all that the kernel depends on."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """Numba's own locator for the file, stamped; None for what is not compiled here."""
        if py_func not in _KERNELS:
            return None
        others = (kind for kind in CompileResultCacheImpl._locator_classes if kind is not cls)
        found = (kind.from_function(py_func, py_file) for kind in others)
        locator = next((one for one in found if one is not None), None)
        if locator is not None:
            stamp = _stamp(py_func, locator.get_source_stamp())
            locator.get_source_stamp = lambda: stamp
        return locator


CompileResultCacheImpl._locator_classes.insert(0, _Locator)


def _stamp(function: Any, own: object) -> str:
    """Digest of ``own``, the files and constants that compiled code of the function can contain."""
    digest = sha256(repr(own).encode())
    for module in sorted(_reached(function), key=lambda module: module.__name__):
        digest.update(_content(module))
        for name, value in _constants(module):
            digest.update(f"{name}={value!r};".encode())
    return digest.hexdigest()


def _constants(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Numbers, and tuples and arrays of them, by their names in a module."""
    for name, value in sorted(vars(module).items()):
        if isinstance(value, np.ndarray):
            yield name, value.tobytes()
        elif _is_constant(value):
            yield name, value


def _is_constant(value: Any) -> bool:
    if isinstance(value, tuple):
        return all(map(_is_constant, value))
    return isinstance(value, int | float | np.number)


def _reached(function: Any) -> set[ModuleType]:
    """The function's module, and all whose helpers and named tuples can go into its kernels."""
    held = [cell.cell_contents for cell in function.__closure__ or ()]
    waiting = [sys.modules[function.__module__], *_modules(map(_home, held))]
    reached = set(waiting)
    while waiting:
        new = _uses(waiting.pop()) - reached
        reached |= new
        waiting.extend(new)
    return reached


def _uses(module: ModuleType) -> set[ModuleType]:
    """Modules that a module holds or has compiled things from; remembered once it is imported."""
    if getattr(module.__spec__, "_initializing", False):
        return _uses_now(module)
    return _uses_once(module)


@cache
def _uses_once(module: ModuleType) -> set[ModuleType]:
    return _uses_now(module)


def _uses_now(module: ModuleType) -> set[ModuleType]:
    values = list(vars(module).values())
    held = {value for value in values if _is_ours(value) or _is_beside(value, module)}
    for value in held:
        values = [*values, *vars(value).values()]
    return held | _modules(map(_home, values))


def _modules(names: Iterable[str | None]) -> set[ModuleType]:
    found = (sys.modules.get(name) for name in set(names) if name)
    return {module for module in found if module is not None and _is_ours(module)}


def _is_ours(value: Any) -> bool:
    return isinstance(value, ModuleType) and value.__name__.partition(".")[0] in _PACKAGES


def _is_beside(value: Any, module: ModuleType) -> bool:
    """Whether a value is a module whose file lies in the same folder as another's."""
    if not isinstance(value, ModuleType):
        return False
    folders = [dirname(getattr(one, "__file__", None) or "") for one in (value, module)]
    return folders[0] == folders[1] != ""


def _home(value: Any) -> str | None:
    """Name of the module that defines a compiled function, an intrinsic or a named tuple."""
    if isinstance(value, Dispatcher):
        return value.py_func.__module__
    if isinstance(value, FunctionType) and value in _ANYWHERE:
        return value.__module__
    if isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
        return value.__module__
    return getattr(getattr(value, "_defn", None), "__module__", None)


def _content(module: ModuleType) -> bytes:
    file = getattr(module, "__file__", None)
    return Path(file).read_bytes() if file and Path(file).is_file() else b""
