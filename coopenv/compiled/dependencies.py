"""What compiled code depends on: files and constants found from what its module imports."""

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from hashlib import sha256
from os.path import dirname
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any
from weakref import WeakSet

import numpy as np
from numba.core.dispatcher import Dispatcher

KERNELS: WeakSet[Any] = WeakSet()  # the Python functions of all that is cached
ANYWHERE: WeakSet[Any] = WeakSet()  # those that Python calls as they are
_PACKAGES: set[str] = set()  # where they come from; helpers are looked for nowhere else
_looked_through: set[tuple[str, str]] = set()  # modules and files whose named tuples were noted
_imported: dict[str, tuple[int, int]] = {}  # files that kernels come from, as they were then


def known(function: Callable[..., Any]) -> Callable[..., Any]:
    """Remember a function whose code goes into the cache, or into what does."""
    KERNELS.add(function)
    seen(function)
    return function


def seen(function: Callable[..., Any]) -> None:
    """Remember what the file of a function is like as it is imported.

    So are those of the named tuples that it can use; a module has them before its first function.
    """
    file, module = function.__code__.co_filename, function.__module__
    _PACKAGES.add(module.partition(".")[0])
    _note(file)
    if (module, file) in _looked_through:
        return
    _looked_through.add((module, file))
    for value in function.__globals__.values():
        if _is_named_tuple(value):
            file = getattr(sys.modules.get(value.__module__), "__file__", None)
            if file and file not in _imported:
                _note(file)


def _note(file: str) -> None:
    if os.path.isfile(file):
        _imported[file] = _age(file)


def stamp(function: Any, own: object) -> str:
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
        elif is_constant(value):
            yield name, value


def is_constant(value: Any) -> bool:
    """Whether it is a number, or a tuple of numbers."""
    if isinstance(value, tuple):
        return all(map(is_constant, value))
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
    if isinstance(value, FunctionType) and value in ANYWHERE:
        return value.__module__
    if _is_named_tuple(value):
        return value.__module__
    return getattr(getattr(value, "_defn", None), "__module__", None)


def _is_named_tuple(value: Any) -> bool:
    return isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields")


def _content(module: ModuleType) -> bytes:
    """What is in the module's file, or what never was if that is not what was imported."""
    file = getattr(module, "__file__", None)
    if not file or not os.path.isfile(file):
        return b""
    if _imported.get(file, _age(file)) != _age(file):
        return os.urandom(16)
    return Path(file).read_bytes()


def _age(file: str) -> tuple[int, int]:
    found = os.stat(file)
    return found.st_mtime_ns, found.st_size
