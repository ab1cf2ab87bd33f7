"""Array types, rows of arrays, and checks of the numbers, ranges and arrays that users give."""

from collections.abc import Sequence
from itertools import chain
from math import isfinite
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput

FloatArray: TypeAlias = npt.NDArray[np.float64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
IntArray: TypeAlias = npt.NDArray[np.int64]
Range: TypeAlias = tuple[float, float]  # lowest and highest; both may be the same

LARGEST = 1e12  # of any magnitude in SI units: products of a few still have room in a float
FLAT = {bool, float, int, np.float64, np.ndarray}  # types in which nothing can be masked
NESTED = {list, tuple}
MOST_LEVELS = 64  # of lists within lists; NumPy makes no array of more
FARTHEST = 1e6  # [m] and [rad]; beyond, rounding of a position or an angle shows

Array = TypeVar("Array", bound=npt.NDArray[Any])
Item = TypeVar("Item")

_PLAIN = {float, int, np.float64}
_UNREAL = (str, bytes, complex, np.complexfloating, np.datetime64, np.timedelta64)


def finite_array(value: Any, name: str) -> FloatArray:
    """Convert to float64 and raise `InvalidInput` unless every element is a finite number."""
    array = number_array(value, name)
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InvalidInput(
            f"{name} must be finite, got {array[where]} at index {where}; "
            "remove or interpolate missing samples first"
        )
    return array


def stated_array(value: Any, name: str) -> FloatArray:
    """`finite_array` of a parameter: True and False, which NumPy takes for 1 and 0, are no numbers.

    For what is read once, since it looks at every element.
    """
    given = finite_array(value, name)
    kinds = set(map(type, value)) if isinstance(value, list | tuple) else {type(value)}
    if not kinds <= _PLAIN:
        elements = np.asarray(value, dtype=object).ravel().tolist()
        if any(isinstance(each, bool | np.bool_) for each in elements):
            raise InvalidInput(
                f"{name} must be made of numbers, got {value!r}; write 1.0 or 0.0 if that is meant"
            )
    return given


def number_array(value: Any, name: str) -> FloatArray:
    """Convert to float64 and raise `InvalidInput` unless every element is a real number or NaN."""
    _refuse_masked(value, name)
    try:
        given = np.asarray(value)
        unreal = any(isinstance(each, _UNREAL) for each in _objects(given))
        if given.dtype.kind not in "biufO" or unreal:  # text would be read, parts be dropped
            raise TypeError(f"real numbers are needed, not {given.dtype}")
        return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(
            f"{name} must be an array of numbers, got {value!r}; pass nested lists or a NumPy array"
        ) from error


def plain_array(value: Any, name: str) -> npt.NDArray[Any]:
    """An array of booleans, whole or real numbers as it is, or raise `InvalidInput`.

    For actions: quicker than `number_array`, copies nothing, and takes no arrays of objects.
    """
    if type(value) is not np.ndarray:
        _refuse_masked(value, name)
        try:
            value = np.asarray(value)
        except (TypeError, ValueError) as error:
            raise InvalidInput(
                f"{name} must be an array of numbers, got {value!r}; pass rows of equal length"
            ) from error
    if value.dtype.kind not in "fiub":
        raise InvalidInput(
            f"{name} must be an array of numbers, got one of {value.dtype}; convert it to "
            "float32 or float64"
        )
    return value


def booleans(marks: npt.ArrayLike, name: str, num_worlds: int) -> BoolArray:
    """An array of one boolean a world, or raise `InvalidInput`."""
    marked = plain_array(marks, name)
    if marked.dtype != np.bool_ or marked.shape != (num_worlds,):
        raise InvalidInput(
            f"{name} must be {num_worlds} booleans, got {marked.dtype} of shape "
            f"{marked.shape}; pass for example terminated | truncated"
        )
    return marked


def positive(
    value: Any,
    name: str,
    *,
    unit: str = "",
    or_zero: bool = False,
    at_least: float = 0.0,
    at_most: float = LARGEST,
) -> float:
    """Return ``value`` as a float, or raise `InvalidInput` unless it is positive and in bounds."""
    given = number(value, name)
    if given < 0 or (given == 0 and not or_zero):
        rule = "zero or positive" if or_zero else "positive"
        raise InvalidInput(f"{name} must be {rule}, got {value!r}; give it in {unit or 'SI units'}")
    if given > at_most or given < at_least:
        rule = f"at most {at_most:g}" if given > at_most else f"at least {at_least:g}"
        raise InvalidInput(f"{name} must be {rule}, got {value!r}; give it in {unit or 'SI units'}")
    return given


def whole(value: Any, name: str, *, at_least: int, at_most: int | None = None) -> int:
    """Return ``value`` as an int, or raise `InvalidInput` unless it is whole and in bounds."""
    exact = isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)
    given = int(value) if exact else number(value, name)  # a float would round large seeds
    if given != int(given) or given < at_least:
        raise InvalidInput(
            f"{name} must be a whole number of at least {at_least}, got {value!r}; change it"
        )
    if at_most is not None and given > at_most:
        raise InvalidInput(f"{name} must be at most {at_most}, got {value!r}; lower it")
    return int(given)


def number(value: Any, name: str) -> float:
    """Return ``value`` as a float, or raise `InvalidInput` unless it is a finite number."""
    if type(value) is float and isfinite(value):
        return value  # as they mostly are in what resets draw
    if value is None or isinstance(value, bool | np.bool_):  # NumPy makes NaN of None
        raise InvalidInput(f"{name} must be a number, got {value!r}; pass a float")
    try:
        array = number_array(value, name)
    except InvalidInput as error:
        raise InvalidInput(f"{name} must be a number, got {value!r}; pass a float") from error
    if array.ndim:
        raise InvalidInput(f"{name} must be one number, got {value!r}; pass a float")
    given = array.item()
    if not isfinite(given):
        raise InvalidInput(f"{name} must be finite, got {value!r}; pass an ordinary number")
    return given


def number_range(value: Any, name: str) -> Range:
    """Return ``value`` as (low, high), or raise `InvalidInput` unless two numbers in order."""
    ends = stated_array(value, name)
    if ends.shape != (2,):
        raise InvalidInput(f"{name} must be (low, high), got {value!r}; give two numbers")
    low, high = ends.tolist()
    if low > high:
        raise InvalidInput(f"{name} must be (low, high), got {value!r}; swap them")
    return low, high


def positive_range(
    value: Any,
    name: str,
    *,
    or_zero: bool = False,
    at_least: float = 0.0,
    at_most: float = LARGEST,
) -> Range:
    """Return ``value`` as (low, high), or raise `InvalidInput` unless 0 < low <= high, in bounds.

    With ``or_zero`` the low end may be zero.
    """
    low, high = number_range(value, name)
    if low < 0 or (low == 0 and not or_zero):
        rule = "not begin below zero" if or_zero else "begin above zero"
        raise InvalidInput(f"{name} must {rule}, got {value!r}; raise its low end")
    if low < at_least:
        raise InvalidInput(
            f"{name} must not begin below {at_least:.4g}, got {value!r}; raise its low end"
        )
    if high > at_most:
        raise InvalidInput(
            f"{name} must not end above {at_most:.4g}, got {value!r}; lower its high end"
        )
    return low, high


def between(ends: Range, fraction: float) -> float:
    """The number at ``fraction`` in [0, 1] of the way from the low end to the high one."""
    low, high = ends
    return min(low + fraction * (high - low), high)


def with_rows(array: Array, rows: IntArray, values: Any) -> Array:
    """A copy of an array with some rows set to others."""
    copy = array.copy()
    copy[rows] = values
    return copy


def with_items(things: Sequence[Item], rows: IntArray, values: Sequence[Item]) -> tuple[Item, ...]:
    """`with_rows` for a sequence of any objects: a tuple, in which some are others."""
    changed = list(things)
    for row, value in zip(rows.tolist(), values, strict=True):
        changed[row] = value
    return tuple(changed)


def has_items(things: Sequence[Item], rows: IntArray, values: Sequence[Item]) -> bool:
    """Whether `with_items` would change nothing."""
    pairs = zip(rows.tolist(), values, strict=True)
    return all(things[row] is value or things[row] == value for row, value in pairs)


def in_rows(array: FloatArray, batch: tuple[int, ...], core: int = 2) -> FloatArray:
    """Broadcast to a batch shape and make one axis of it; the last ``core`` axes stay.

    Not copied where NumPy need not, and then perhaps read-only.
    """
    shape = array.shape[array.ndim - core :]
    return np.broadcast_to(array, (*batch, *shape)).reshape(-1, *shape)


def _objects(array: npt.NDArray[Any]) -> list[Any]:
    """Elements of an array of any Python objects; none of an array of numbers."""
    return array.ravel().tolist() if array.dtype == object else []


def _refuse_masked(value: Any, name: str) -> None:
    """Raise where numbers are masked, in rows too: as a plain array they would count again."""
    masked = _count_masked(value)
    if masked:
        raise InvalidInput(f"{name} must have no masked values, got {masked}; fill or drop them")


def _count_masked(value: Any) -> int:
    """Masked elements of an array, or of arrays in lists and tuples, looked at level by level.

    Of each level the types tell whether there is anything to look at, so that long lists of plain
    numbers cost little.
    """
    count, level = 0, [value]
    for _ in range(MOST_LEVELS):
        kinds = set(map(type, level))
        if kinds <= FLAT:
            break
        if not kinds <= NESTED:
            count += sum(int(np.ma.count_masked(each)) for each in level if np.ma.isMA(each))
            level = [each for each in level if isinstance(each, list | tuple)]
        level = list(chain.from_iterable(level))
    return count
