"""Values of a layout's tables, checked: every message names the key, as in ``sensors.1.offset``."""

from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, TypeVar

from coopenv.arrays import stated_array
from coopenv.errors import InvalidInput, UnknownName

LARGEST = 1e9  # of a number in a layout
T = TypeVar("T")


def stated(kind: type[T], value: Any, key: str) -> T:
    """An object of a dataclass ``kind``, as it is or from a table of its fields.

    Raises
    ------
    UnknownName
        If the table has a key that is no field; the nearest is named.
    InvalidInput
        If it is no table, or a field that has no default is missing.
    """
    if isinstance(value, kind):
        return value
    if not isinstance(value, Mapping):
        raise InvalidInput(
            f"{key} must be a table, got {value!r}; write [{key}] and its keys below"
        )
    known = [entry.name for entry in fields(kind)]  # type: ignore[arg-type]
    for name in value:
        if name not in known:
            raise UnknownName(f"key of {key}", name, known)
    try:
        return kind(**value)
    except TypeError:
        raise InvalidInput(
            f"{key} must have its keys, got {', '.join(map(str, value)) or 'none'}; known: "
            f"{', '.join(known)}"
        ) from None


def vector(value: Any, key: str, sizes: Iterable[int] = (2, 3)) -> tuple[float, ...]:
    """Numbers, as many as one of ``sizes``."""
    given, sizes = stated_array(value, key), tuple(sizes)
    if given.ndim != 1 or len(given) not in sizes:
        rule = " or ".join(map(str, sizes))
        raise InvalidInput(f"{key} must be {rule} numbers, got {value!r}; list them in brackets")
    if abs(given).max() > LARGEST:
        raise InvalidInput(f"{key} must be at most {LARGEST:g}, got {value!r}; correct it")
    return tuple(given.tolist())


def vector_or_nothing(value: Any, key: str) -> tuple[float, ...]:
    """Numbers of a position, or none of them where nothing is said."""
    return () if isinstance(value, tuple) and not value else vector(value, key)


def square(value: Any, key: str, sizes: Iterable[int]) -> tuple[tuple[float, ...], ...]:
    """A matrix of as many rows and columns as one of ``sizes``, row by row."""
    given = stated_array(value, key)
    if given.ndim != 2 or given.shape[0] != given.shape[1] or len(given) not in tuple(sizes):
        rule = " or ".join(f"{size} by {size}" for size in sizes)
        raise InvalidInput(
            f"{key} must be a matrix of {rule}, got shape {given.shape}; list its rows"
        )
    if abs(given).max() > LARGEST:
        raise InvalidInput(f"{key} must be at most {LARGEST:g}, got {value!r}; correct it")
    return tuple(map(tuple, given.tolist()))


def choice(value: Any, key: str, known: Iterable[str]) -> str:
    """One of the known words."""
    known = tuple(known)
    if value not in known:
        raise UnknownName(key, value, known)
    return value
