"""Numba's cache of compiled kernels on disk: stamped with what they depend on, and checked.

Numba takes what a file of its cache holds. One that was cut short, by a full disk or a machine that
went down, raises at every later start; one with a wrong bit runs. Here each file ends in a digest.
A file that does not fit its digest, or cannot be read, counts as not there: the kernel is compiled
again. A file that cannot be written is warned of once, and kernels are compiled in memory.

Numba uses the first folder that it can write. What is missing there is looked for in its other
folders, which may be those of an image that was filled while it was built and is read-only since.
"""

import os
import pickle
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import cache, cached_property
from hashlib import sha256
from io import BufferedWriter
from pathlib import Path
from typing import Any
from uuid import uuid4
from weakref import WeakSet

from numba.core import dispatcher
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    NullCache,
)
from numba.core.compiler_lock import global_compiler_lock
from numba.np.ufunc import ufuncbuilder, wrappers

from coopenv.compiled.dependencies import KERNELS, stamp
from coopenv.compiled.lighter import lighter

DIGEST = 32  # bytes


class Locator:
    """Where numba keeps a kernel of ours, with a stamp of all that the kernel depends on."""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> Any:
        """Numba's own locator for the file, stamped; None for what is not compiled here."""
        if py_func not in KERNELS:
            return None
        others = (kind for kind in CompileResultCacheImpl._locator_classes if kind is not cls)
        found = (kind.from_function(py_func, py_file) for kind in others)
        locator = next((one for one in found if one is not None), None)
        return _stamped(locator, py_func)


def _stamped(locator: Any, py_func: Any) -> Any:
    if locator is not None:
        told = locator.get_source_stamp()
        if isinstance(told, tuple) and os.path.isfile(locator._py_file):
            told = told[1:]  # older numba's time of the file, which changes as an image is packed
        own = stamp(py_func, told)
        locator.get_source_stamp = lambda: own
    return locator


def _read_only(place: Any) -> Any:
    """A kind of numba's locators, for a folder that is there and cannot be written."""

    class Place(place):
        def ensure_cache_path(self) -> None:
            path = self.get_cache_path()
            if not os.path.isdir(path) or os.access(path, os.W_OK):
                raise OSError(f"{path} is not a folder that can be read alone")

        @classmethod
        def from_function(cls, py_func: Any, py_file: str) -> Any:
            return _stamped(super().from_function(py_func, py_file), py_func)

    return Place


class Files(IndexDataCacheFile):
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

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BufferedWriter]:
        """As numba does it, which keeps what it began when it is interrupted."""
        part = f"{filepath}.tmp.{uuid4().hex[:16]}"
        try:
            with open(part, "wb") as file:
                yield file
            os.replace(part, filepath)
        except BaseException:
            with suppress(OSError):
                os.unlink(part)
            raise

    def _digest(self, content: Any) -> bytes:
        digest = sha256(self._version.encode())
        digest.update(content)
        return digest.digest()


def _checked(kind: Any) -> Any:
    """A kind of numba's caches that neither trusts nor needs what is on disk."""

    class Checked(kind):
        elsewhere: Sequence[Any] = ()  # caches to read from after this one

        def __init__(self, py_func: Any):
            super().__init__(py_func)
            base, own = self._impl.filename_base, self._impl.locator.get_source_stamp()
            self._cache_file = Files(self._cache_path, base, own)

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            for load in (super().load_overload, *(one.load_overload for one in self.elsewhere)):
                try:
                    found = load(sig, target_context)
                except Exception:  # of another version of a library, or a file that cannot be read
                    continue
                if found is not None:
                    return found
            return None

        def save_overload(self, sig: Any, data: Any) -> None:
            with _forgiving():
                super().save_overload(sig, data)

        def flush(self) -> None:
            with _forgiving():
                super().flush()

    return Checked


_KernelCache, _LoopCache = _checked(FunctionCache), _checked(wrappers.GufWrapperCache)


@cache
def _read_only_kinds(ours: Any) -> list[Any]:
    """A kind of cache for each kind of folder that cannot be written."""
    kinds = []
    for place in CompileResultCacheImpl._locator_classes:
        if place is not Locator:
            locators = {"_locator_classes": [_read_only(place)]}
            impl = type("ReadOnlyImpl", (ours._impl_class,), locators)
            kinds.append(type("ReadOnly", (ours,), {"_impl_class": impl}))
    return kinds


def _elsewhere(ours: Any, py_func: Any) -> Iterator[Any]:
    """Caches that cannot be written and hold the function compiled as it now stands."""
    for kind in () if py_func in _forgotten else _read_only_kinds(ours):
        try:
            cache = kind(py_func)
        except Exception:  # there is no such folder, or numba takes it for an archive
            continue
        if cache._cache_file._load_index():
            yield cache


def _cache_of(ours: Any, others: Any) -> Callable[[Any], Any]:
    """What makes the cache of a function: ours for ours, numba's for all others."""

    def found(py_func: Any) -> Any:
        elsewhere = list(_elsewhere(ours, py_func))
        try:
            cache = ours(py_func)
        except RuntimeError as error:  # numba found no folder that can be written
            if not elsewhere:
                return _Nowhere(error)
            cache, *elsewhere = elsewhere
        cache.elsewhere = elsewhere
        return cache

    class Later(ours):
        """A cache that is looked for when a kernel is compiled, not when it is imported."""

        def __init__(self, py_func: Any):
            self._py_func = py_func
            self._enabled = True

        @cached_property
        def _found(self) -> Any:
            return found(self._py_func)

        @property
        def cache_path(self) -> Any:
            return self._found.cache_path

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            if not self._enabled:
                return None
            with global_compiler_lock, lighter():
                return self._found.load_overload(sig, target_context)

        def save_overload(self, sig: Any, data: Any) -> None:
            if self._enabled:
                self._found.save_overload(sig, data)

        def flush(self) -> None:
            self._found.flush()

    return lambda py_func: (Later if py_func in KERNELS else others)(py_func)


class _Nowhere(NullCache):
    """A cache that keeps nothing, and says so once there is something to keep."""

    def __init__(self, error: Exception):
        self._error = error

    def save_overload(self, sig: Any, cres: Any) -> None:
        _warn(self._error)


def forget_loop(function: Any) -> None:
    """Have what NumPy calls of a gufunc compiled again."""
    _forgotten.add(function)
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
_forgotten: WeakSet[Any] = WeakSet()  # functions whose read-only code is of no use
CompileResultCacheImpl._locator_classes.insert(0, Locator)

_replaced: dict[str, Any] = {
    "FunctionCache": _cache_of(_KernelCache, FunctionCache),
    "GufWrapperCache": _cache_of(_LoopCache, wrappers.GufWrapperCache),
}
for _module in (dispatcher, ufuncbuilder, wrappers):  # numba has no other door
    vars(_module).update({name: _replaced[name] for name in _replaced.keys() & vars(_module)})
