"""Decorators that compile functions with numba, one for each kind of use."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit
from numba.extending import intrinsic, register_jitable

from coopenv.compiled.dependencies import ANYWHERE, known, seen
from coopenv.compiled.garbage import Entry
from coopenv.compiled.parts import also_part, part
from coopenv.compiled.universal import Universal

TINY = 1e-300  # keeps divisions finite where the numerator is zero as well

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

_PLAIN: dict[str, Any] = {"error_model": "numpy", "nogil": True}
_FUSED: dict[str, Any] = {"error_model": "numpy", "nogil": True, "fastmath": {"contract"}}
_ENTRY: dict[str, Any] = {"cache": True, "no_cfunc_wrapper": True, "pipeline_class": Entry}


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that Python or other kernels call."""
    kernel = njit(**_PLAIN, **_ENTRY)(known(function))
    return also_part(kernel, **_PLAIN)


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it."""
    kernel = njit(**_PLAIN, **_ENTRY, forceinline=True)(known(function))
    return also_part(kernel, **_PLAIN, forceinline=True)


def anywhere(function: Kernel) -> Kernel:
    """Leave a function to Python as it is, and compile it into each kernel that calls it."""
    ANYWHERE.add(function)
    register_jitable(error_model="numpy", forceinline=True)(known(function))
    return function


def fused(function: Callable[..., Any]) -> Any:
    """Compile a helper of kernels in which products and sums may be fused."""
    seen(function)
    return part(function, **_FUSED)


def fused_inlined(function: Callable[..., Any]) -> Any:
    """Compile such a helper into each kernel that calls it."""
    seen(function)
    return part(function, **_FUSED, forceinline=True)


def fused_entry(function: Callable[..., Any]) -> Any:
    """Compile the function through which Python calls kernels whose products and sums are fused."""
    return njit(**_FUSED, **_ENTRY)(known(function))


def in_llvm(function: Callable[..., Any]) -> Any:
    """Make a function of compiled code whose body is in LLVM's terms.

    Its first parameter comes from numba, the others from the caller: no type checker can know.
    """
    seen(function)
    return intrinsic(function)


def gufunc(layout: str, signature: str) -> Callable[[Callable[..., None]], Any]:
    """Compile a float64 kernel to a NumPy gufunc that broadcasts over any batch shape.

    Compiled is it when it is first called. A later call is one of NumPy's own ufunc, not of numba's
    wrapper, which is slower to call. NumPy releases the interpreter lock while the kernel runs.

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
    return lambda kernel: Universal(known(kernel), layout, signature)
