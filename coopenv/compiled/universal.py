"""Gufuncs of NumPy that are compiled, or taken from the cache, when they are first called."""

from collections.abc import Callable
from functools import partial
from typing import Any

from numba import guvectorize
from numba.core.compiler_lock import global_compiler_lock

from coopenv.compiled.cache import forget_loop
from coopenv.compiled.garbage import kept


class Universal(partial):
    """A gufunc that is compiled when it is first called, or asked for what it is.

    A `functools.partial` can be told to call something else: from then on it is NumPy's ufunc that
    is called, without a line of Python in between.
    """

    _kernel: Callable[..., None]
    _layout: str
    _types: str

    def __new__(cls, kernel: Callable[..., None], layout: str, signature: str):
        """Remember what to compile."""
        made = super().__new__(cls, kernel)
        names = {name: getattr(kernel, name) for name in ("__name__", "__module__", "__doc__")}
        made.__setstate__((partial(_first_call, made), (), {}, names))
        made._kernel, made._layout, made._types = kernel, layout, signature
        return made

    @property
    def ufunc(self) -> Any:
        """NumPy's ufunc."""
        with global_compiler_lock, kept():
            if isinstance(self.func, partial):
                made = _compile(self._kernel, self._layout, self._types)
                self.__setstate__((made, (), {}, self.__dict__))
        return self.func

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "ufunc":  # the latter where compiling it failed so
            raise AttributeError(name)
        return getattr(self.ufunc, name)

    def __reduce__(self) -> str:
        return self.__dict__["__name__"]  # by its name, as a function


def _first_call(made: Universal, *arguments: Any, **keywords: Any) -> Any:
    return made.ufunc(*arguments, **keywords)


def _compile(kernel: Callable[..., None], layout: str, signature: str) -> Any:
    made = guvectorize([signature], layout, cache=True)(kernel)
    if not _is_linked(made):
        forget_loop(kernel)
        made = guvectorize([signature], layout, cache=True)(kernel)
    return made.ufunc


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
