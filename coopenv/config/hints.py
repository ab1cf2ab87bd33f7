"""Checks of values against the annotations of a dataclass or function of this package."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np

from coopenv.errors import InvalidInput

Leaves: TypeAlias = frozenset[Any]


@lru_cache(maxsize=256)
def leaves_of(maker: Callable[..., Any]) -> Mapping[str, Leaves]:
    """Keyword → every type that its annotation names, however deep."""
    hints = get_type_hints(maker)
    return {name: frozenset(_leaves(hint)) for name, hint in hints.items()}


def _leaves(hint: Any) -> list[Any]:
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Literal:
        return [type(part) for part in parts]
    if origin is Callable:
        return [Callable]
    return [origin or hint, *(leaf for part in parts for leaf in _leaves(part))]


def fitted(value: Any, leaves: Leaves, part: str) -> Any:
    """``value``, whole numbers as floats where these are annotated, NumPy's numbers as Python's.

    Raises
    ------
    InvalidInput
        If it is of no annotated type; ``part`` names it.
    """
    if isinstance(value, np.bool_ | np.integer | np.str_):
        value = value.item()
    if isinstance(value, list | tuple):
        fits = not leaves.isdisjoint((tuple, Sequence))
        items = enumerate(value) if fits else ()
        value = type(value)([fitted(item, leaves, f"{part}[{k}]") for k, item in items])
    elif isinstance(value, float):
        value, fits = float(value), not leaves.isdisjoint((float, int))
    elif type(value) is int:
        fits = not leaves.isdisjoint((float, int))
        value = as_float(value, part) if fits and int not in leaves else value
    else:
        fits = any(_is_one(value, leaf) for leaf in leaves)
    if not fits:
        known = sorted({getattr(leaf, "__name__", str(leaf)) for leaf in leaves} - {"UnionType"})
        raise InvalidInput(f"{part} must be made of {', '.join(known)}, got {value!r}; change it")
    return value


def as_float(value: int, part: str) -> float:
    """The number as a double; raises `InvalidInput` where it is too large for one."""
    try:
        return float(value)
    except OverflowError as error:
        raise InvalidInput(
            f"{part} must be a number that a computer can hold, got one of {value.bit_length()} "
            "bits; write an ordinary number"
        ) from error


def _is_one(value: Any, leaf: Any) -> bool:
    if leaf is Any:
        return True
    if leaf is bool or not isinstance(value, bool):
        try:
            return isinstance(value, leaf)
        except TypeError:  # of a union's own type, a name that is still to be resolved
            return False
    return False
