"""Array types, and the checks that every input passes once at the door."""

from math import isfinite
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput

FloatArray: TypeAlias = npt.NDArray[np.float64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
IntArray: TypeAlias = npt.NDArray[np.int64]


def finite_array(value: Any, name: str) -> FloatArray:
    """Convert to float64 and raise `InvalidInput` unless every element is a finite number."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidInput(
            f"{name} must be an array of numbers, got {value!r}; pass nested lists or a NumPy array"
        ) from error
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InvalidInput(
            f"{name} must be finite, got {array[where]} at index {where}; "
            "remove or interpolate missing samples first"
        )
    return array


def positive(value: Any, name: str, *, unit: str = "", or_zero: bool = False) -> float:
    """Return ``value`` as a float, or raise `InvalidInput` unless it is finite and positive."""
    number = _number(value, name)
    if number < 0 or (number == 0 and not or_zero):
        rule = "zero or positive" if or_zero else "positive"
        raise InvalidInput(f"{name} must be {rule}, got {value!r}; give it in {unit or 'SI units'}")
    return number


def whole(value: Any, name: str, *, at_least: int) -> int:
    """Return ``value`` as an int, or raise `InvalidInput` unless it is whole and large enough."""
    number = _number(value, name)
    if number != int(number) or number < at_least:
        raise InvalidInput(
            f"{name} must be a whole number of at least {at_least}, got {value!r}; change it"
        )
    return int(number)


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool | np.bool_):
        raise InvalidInput(f"{name} must be a number, got {value!r}; pass a float")
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{name} must be a number, got {value!r}; pass a float") from error
    if not isfinite(number):
        raise InvalidInput(f"{name} must be finite, got {value!r}; pass an ordinary number")
    return number
