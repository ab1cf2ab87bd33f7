"""The one way we compile: NumPy gufuncs for everything that runs at every step."""

from collections.abc import Callable
from typing import Any

from numba import guvectorize
from numba.np.ufunc.wrappers import GufWrapperCache

COMPILED: dict[str, Any] = {"error_model": "numpy", "cache": True}
"""Options of the helpers that kernels call, ``@njit(**COMPILED)``: dividing by zero is no error."""


TINY = 1e-300  # keeps divisions finite where the numerator is zero as well


def gufunc(layout: str, signature: str) -> Callable[[Callable[..., None]], Any]:
    """Compile a float64 kernel to a NumPy gufunc that broadcasts over any batch shape.

    The decorator returns NumPy's own ufunc instead of numba's wrapper, which saves 0.7 µs a call.
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
        compiled = guvectorize([signature], layout, cache=True)(kernel)
        if not _is_linked(compiled):
            GufWrapperCache(py_func=kernel).flush()
            compiled = guvectorize([signature], layout, cache=True)(kernel)
        return compiled.ufunc

    return compile_kernel


def _is_linked(compiled: Any) -> bool:
    """Whether every loop of the gufunc has an address.

    Numba caches a kernel and its gufunc loop apart, under a name that differs from process to
    process. Where two processes compile at the same time, the cache can keep the kernel of one and
    the loop of the other: the loop is not found, its address is 0, and the first call would crash,
    in every later process too. (Seen with numba 0.68.)
    """
    builder = compiled.gufunc_builder
    return all(builder.build(builder._cres[signature])[1] for signature in builder._sigs)
