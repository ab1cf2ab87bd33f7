"""Numba's cache of compiled kernels on disk: stamped with what they depend on, and checked.

Numba takes what a file of its cache holds. One that was cut short, by a full disk or a machine that
went down, raises at every later start; one with a wrong bit runs. Here each file ends in a digest.
A file that does not fit its digest, or cannot be read, counts as not there: the kernel is compiled
again. A file that cannot be written is warned of once, and kernels are compiled in memory.
"""

import pickle
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba.core import dispatcher
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    NullCache,
)
from numba.np.ufunc import ufuncbuilder, wrappers

from coopenv.compiled.dependencies import KERNELS, stamp

DIGEST = 32  # bytes


class _Locator:
    """Where numba keeps a kernel of ours, with a stamp of all that the kernel depends on."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """Numba's own locator for the file, stamped; None for what is not compiled here."""
        if py_func not in KERNELS:
            return None
        others = (kind for kind in CompileResultCacheImpl._locator_classes if kind is not cls)
        found = (kind.from_function(py_func, py_file) for kind in others)
        locator = next((one for one in found if one is not None), None)
        if locator is not None:
            own = stamp(py_func, locator.get_source_stamp())
            locator.get_source_stamp = lambda: own
        return locator


class _Files(IndexDataCacheFile):
    """Files of a kernel, each with a digest of its content and of numba's version at its end."""

    def _load_index(self) -> dict[Any, str]:
        try:
            stamp, overloads = self._read(self._index_path)
        except Exception:  # damaged pickles raise all kinds
            return {}
        return overloads if stamp == self._source_stamp else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _read(self, path: str) -> Any:
        content = memoryview(Path(path).read_bytes())
        if self._digest(content[:-DIGEST]) != content[-DIGEST:]:
            raise ValueError(f"{path} is damaged")
        return pickle.loads(content[:-DIGEST])

    def _write(self, path: str, content: Any) -> None:
        pickled = self._dump(content)
        with self._open_for_write(path) as file:
            file.write(pickled + self._digest(pickled))

    def _digest(self, content: Any) -> bytes:
        digest = sha256(self._version.encode())
        digest.update(content)
        return digest.digest()


def _checked(kind: Any) -> Any:
    """A kind of numba's caches that neither trusts nor needs what is on disk."""

    class Checked(kind):
        def __init__(self, py_func: Any):
            super().__init__(py_func)
            base, own = self._impl.filename_base, self._impl.locator.get_source_stamp()
            self._cache_file = _Files(self._cache_path, base, own)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # of another version of a library, or a file that cannot be read
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            with _forgiving():
                super().save_overload(sig, data)

        def flush(self) -> None:
            with _forgiving():
                super().flush()

    return Checked


_KernelCache, _LoopCache = _checked(FunctionCache), _checked(wrappers.GufWrapperCache)


def _cache_of(ours: Any, others: Any) -> Callable[[Any], Any]:
    """What makes the cache of a function: ours for ours, numba's for all others."""

    def make(py_func: Any) -> Any:
        if py_func not in KERNELS:
            return others(py_func)
        try:
            return ours(py_func)
        except RuntimeError as error:  # numba found no folder that can be written
            _warn(error)
            return NullCache()

    return make


def forget_loop(function: Any) -> None:
    """Have what NumPy calls of a gufunc compiled again."""
    wrappers.GufWrapperCache(py_func=function).flush()


@contextmanager
def _forgiving() -> Iterator[None]:
    try:
        yield
    except OSError as error:
        _warn(error)


def _warn(error: Exception) -> None:
    if not _warned:
        _warned.append(error)
        warnings.warn(
            f"the cache of compiled kernels must be writable, got: {error}; kernels are compiled "
            "anew at every start until it is (NUMBA_CACHE_DIR names another folder)",
            stacklevel=2,
        )


_warned: list[Exception] = []
CompileResultCacheImpl._locator_classes.insert(0, _Locator)

_replaced: dict[str, Any] = {
    "FunctionCache": _cache_of(_KernelCache, FunctionCache),
    "GufWrapperCache": _cache_of(_LoopCache, wrappers.GufWrapperCache),
}
for _module in (dispatcher, ufuncbuilder, wrappers):  # numba has no other door
    vars(_module).update({name: _replaced[name] for name in _replaced.keys() & vars(_module)})
