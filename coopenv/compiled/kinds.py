"""Decorators that compile functions with numba, one for each kind of use."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import guvectorize, njit
from numba.core.compiler_lock import global_compiler_lock
from numba.extending import intrinsic, register_jitable

from coopenv.compiled.cache import forget_loop
from coopenv.compiled.dependencies import ANYWHERE, known

TINY = 1e-300  # keeps divisions finite where the numerator is zero as well

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

_CACHED: dict[str, Any] = {"error_model": "numpy", "nogil": True, "cache": True}
_FUSED: dict[str, Any] = {"error_model": "numpy", "nogil": True, "fastmath": {"contract"}}
_HELPER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a function that Python or other kernels call."""
    return njit(**_CACHED)(known(function))


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a function into each kernel that calls it."""
    return njit(**_CACHED, forceinline=True)(known(function))


def anywhere(function: Kernel) -> Kernel:
    """Leave a function to Python as it is, and compile it into each kernel that calls it."""
    ANYWHERE.add(function)
    register_jitable(error_model="numpy", forceinline=True)(known(function))
    return function


def fused(function: Callable[..., Any]) -> Any:
    """Compile a helper of kernels in which products and sums may be fused."""
    return njit(**_FUSED, **_HELPER)(function)


def fused_inlined(function: Callable[..., Any]) -> Any:
    """Compile such a helper into each kernel that calls it."""
    return njit(**_FUSED, **_HELPER, forceinline=True)(function)


def fused_entry(function: Callable[..., Any]) -> Any:
    """Compile the function through which Python calls kernels whose products and sums are fused."""
    return njit(**_FUSED, cache=True)(known(function))


def in_llvm(function: Callable[..., Any]) -> Any:
    """Make a function of compiled code whose body is in LLVM's terms.

    Its first parameter comes from numba, the others from the caller: no type checker can know.
    """
    return intrinsic(function)


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
        made = guvectorize([signature], layout, cache=True)(known(kernel))
        if not _is_linked(made):
            forget_loop(kernel)
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
    with global_compiler_lock:  # without a cache it is compiled again
        return all(builder.build(builder._cres[signature])[1] for signature in builder._sigs)
