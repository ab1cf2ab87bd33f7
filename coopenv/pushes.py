"""Discrete actions: tables of pushes, of which an agent gives the number of one."""

from collections.abc import Sequence
from itertools import product
from math import sqrt
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, plain_array, stated_array
from coopenv.errors import InvalidInput, UnknownName

Table: TypeAlias = tuple[tuple[float, ...], ...]

MOST_PUSHES = 10**4

_NOTHING = (0.0, 0.0, 0.0)
_ALONG = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0))
_TURNS = ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
_SOFTLY = tuple(tuple(0.3 * part for part in row) for row in (*_ALONG, *_TURNS))
_SLANTED = tuple((x * sqrt(0.5), y * sqrt(0.5), 0.0) for x, y in product((1.0, -1.0), repeat=2))
_STRENGTHS = (0.0, 1.0, -1.0)

# Rows (fx, fy, tz) as an action of action="wrench" has them; the first is no push.
PUSHES: dict[str, Table] = {
    # one thing at a time, at full strength
    "axes": (_NOTHING, *_ALONG, *_TURNS),
    # the same at full strength or at three tenths of it, where full pushes are too coarse to stop
    "fine": (_NOTHING, *_ALONG, *_TURNS, *_SOFTLY),
    # forces in eight directions, or a torque
    "compass": (_NOTHING, *_ALONG, *_SLANTED, *_TURNS),
    # nothing, forwards or backwards on each axis, in all combinations
    "grid": tuple((x, y, turn) for x, y, turn in product(_STRENGTHS, repeat=3)),
}


def read_pushes(value: Any) -> str | Table:
    """The name of a table of `PUSHES`, or a table of one's own as tuples.

    Raises
    ------
    UnknownName
        For a name that does not exist.
    InvalidInput
        Unless a table has two rows or more, all different, of three numbers in [−1, 1] each.
    """
    if isinstance(value, str):
        if value not in PUSHES:
            raise UnknownName("pushes", value, PUSHES)
        return value
    rows = stated_array(value, "pushes")
    if rows.ndim != 2 or rows.shape[1] != 3 or not 2 <= len(rows) <= MOST_PUSHES:
        raise InvalidInput(
            f"pushes must be from 2 to {MOST_PUSHES} rows (fx, fy, tz), got an array of shape "
            f"{rows.shape}; name a table ({', '.join(PUSHES)}), or write "
            "((0, 0, 0), (1, 0, 0), ...)"
        )
    if (np.abs(rows) > 1).any():
        row = int(np.argwhere(np.abs(rows) > 1)[0, 0])
        raise InvalidInput(
            f"pushes must be in [-1, 1], in parts of the limits, got {rows[row].tolist()} in row "
            f"{row}; raise force_limit or torque_limit"
        )
    if len(np.unique(rows, axis=0)) < len(rows):
        raise InvalidInput(
            f"pushes must all be different, got {len(np.unique(rows, axis=0))} of {len(rows)} "
            "rows; drop the repeated ones"
        )
    return tuple(tuple(row) for row in rows.tolist())


def table_of(pushes: str | Sequence[Sequence[float]]) -> FloatArray:
    """``(push, 3)``: fx, fy, tz in parts of the limits, agent frame."""
    return np.array(PUSHES[pushes] if isinstance(pushes, str) else pushes, dtype=np.float64)


def push_numbers(
    value: npt.ArrayLike, name: str, shape: tuple[int, ...], count: int
) -> npt.NDArray[np.integer]:
    """``value`` as numbers of pushes of that ``shape``, or raise `InvalidInput`.

    They are not looked at beyond that: `check_numbers` does.
    """
    given = plain_array(value, name)
    if given.shape != shape:
        raise InvalidInput(
            f"{name} must have shape {shape}, one number of a push an agent, got {given.shape}; "
            "see action_space"
        )
    if given.dtype.kind not in "iu":
        raise InvalidInput(
            f"{name} must be whole numbers from 0 to {count - 1}, got an array of {given.dtype}; "
            "give numbers of pushes, or choose action='wrench'"
        )
    return given


def check_numbers(given: npt.NDArray[np.integer], name: str, count: int) -> None:
    """Raise `InvalidInput` unless all are numbers of one of ``count`` pushes."""
    wrong = (given < 0) | (given >= count)
    if wrong.any():
        where = tuple(int(i) for i in np.argwhere(wrong)[0])
        place = f" at index {where}" if where else ""
        raise InvalidInput(
            f"{name} must be from 0 to {count - 1}, got {given[where]}{place}; there are {count} "
            "pushes"
        )


def pushed(
    action: npt.ArrayLike, shape: tuple[int, ...], table: FloatArray, restart: BoolArray | None
) -> FloatArray:
    """The pushes ``(world, learner, 3)`` that numbers ``(world, learner)`` stand for.

    They are 0 in worlds that ``restart`` marks, whatever number is given there.

    Raises
    ------
    InvalidInput
        If numbers have another shape, are not whole, or another world's are of no push.
    """
    given = push_numbers(action, "action", shape, len(table))
    if restart is None:
        check_numbers(given, "action", len(table))
        return table[given]
    check_numbers(np.where(restart[:, None], 0, given), "action", len(table))
    return np.where(restart[:, None, None], 0.0, table[np.where(restart[:, None], 0, given)])


def nearest(action: FloatArray, table: FloatArray | None) -> FloatArray | IntArray:
    """Number of the push nearest to each action ``(..., 3)``, the first of equals.

    Without a table actions are not discrete and stay as they are.
    """
    if table is None:
        return action
    apart = np.square(action[..., None, :] - table).sum(axis=-1)
    return apart.argmin(axis=-1)
