"""Recordings that are arrays under names: which columns they hold, and reading them together."""

import math
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST, effector_names
from coopenv.logs.declared.stamps import Stamps
from coopenv.logs.formats.chunks import (
    CHUNK_ROWS,
    Chunk,
    Column,
    Source,
    Wanted,
    part_of,
    plain,
    rows_at_once,
)
from coopenv.logs.limits import Limits

BLOCKS = ("force", "torque", "grips", "pose", "twist")
CARRIED = "biufUSmM"  # kinds of arrays that can be written to every table
LONG = ("force", "f1x", "time")  # every recording has one of them, as long as it is itself
POSE = {3: (*POSITION[2], *ORIENTATION[2]), 7: (*POSITION[3], *ORIENTATION[3])}

Read = Callable[[str, int, int], npt.NDArray[Any]]  # an array's name, first row, number of rows


class Named(Protocol):
    """An array that is not read yet, rows first."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows first."""
        ...

    @property
    def dtype(self) -> np.dtype:
        """Of its elements."""
        ...


class ArraySource(Source):
    """Arrays ``(T,)`` under the names of columns, or arrays of several columns.

    ``force (T, n, 2 or 3)``, ``torque (T, n)`` or ``(T, n, 3)``, ``grips (n, 2 or 3)`` or
    ``(T, n, 2 or 3)``, ``pose (T, 3 or 7)``, ``twist (T, 3 or 6)`` have their columns in the order
    of the documented names. Columns of others, such as ``actions (T, 4)``, are called ``actions:0``
    and so on where a layout asks for them.

    Parameters
    ----------
    path
        Of the file.
    limits
        On what it may cost.
    arrays
        All that the file has.
    """

    def __init__(self, path: Path, limits: Limits, arrays: Mapping[str, Named]):
        self._path, self._limits = path, limits
        self._arrays = dict(arrays)
        self._decided = any(name in self._arrays for name in LONG)  # how many rows there are
        self._settle(self._length())

    @property
    def shapes(self) -> Mapping[str, tuple[int, ...]]:
        """See `Source`."""
        return {name: self._shape(name) for name in self._arrays}

    def offer(self, names: Iterable[str]) -> None:
        """Make parts of arrays columns, where these names ask for them."""
        asked = {name: part for name in names if (part := part_of(name)) is not None}
        there = [array for array, _ in asked.values() if array in self._arrays]
        if there and not self._decided:
            self._decided = True
            self._settle(self._longest([there[0]]))
        for name, (array, index) in asked.items():
            if array in self._arrays and name not in self._columns:
                self._add_part(name, array, index)

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read all arrays side by side."""
        numbers, carried, stamps = wanted
        for name in numbers:
            self._require_numbers(self._columns[name][0], stamps.get(name))
        arrays = list(dict.fromkeys(self._columns[name][0] for name in wanted.names))
        most = rows_at_once(CHUNK_ROWS, self.row_bytes(arrays))
        with self._reader(arrays) as read_rows:
            for first in range(0, self._rows, most):
                rows = min(most, self._rows - first)
                read = {name: self._oriented(name, read_rows, first, rows) for name in arrays}
                pick = {
                    name: read[self._columns[name][0]][(slice(None), *self._columns[name][1])]
                    for name in wanted.names
                }
                yield Chunk(
                    numbers={name: _numbers(pick[name], stamps.get(name)) for name in numbers},
                    carried={name: plain(self._text(pick[name], name)) for name in carried},
                    rows=rows,
                    first_row=first + 1,
                    progress=(first + rows) / self._rows,
                    rules=wanted.rules,
                )

    @abstractmethod
    def _reader(self, wanted: Sequence[str]) -> AbstractContextManager[Read]:
        """What reads rows of these arrays, always the next ones."""

    def row_bytes(self, wanted: Sequence[str]) -> int:
        """Of these arrays side by side; raises where that is, or one of them asks for, too much."""
        size = sum(
            math.prod(self._shape(name)[1:]) * self._arrays[name].dtype.itemsize for name in wanted
        )
        remedy = "leave out what is not needed"
        self._limits.require("row_bytes", size, f"{self._path}", remedy)
        return size

    def _text(self, values: Column, name: str) -> Column:
        """The same, if it holds no text that is none."""
        return values

    def _shape(self, name: str) -> tuple[int, ...]:
        """Of an array, rows first."""
        return self._arrays[name].shape

    def _oriented(self, name: str, read: Read, first: int, rows: int) -> npt.NDArray[Any]:
        """Rows of an array, of the shape that it is said to have."""
        return read(name, first, rows)

    def _length(self) -> int:
        """Number of rows: that of what every recording has."""
        for name in LONG:
            if name in self._arrays and self._arrays[name].shape:
                return self._longest([name])
        return self._longest(self._arrays)

    def _longest(self, names: Iterable[str]) -> int:
        return max((each[0] for name in names if (each := self._arrays[name].shape)), default=0)

    def _settle(self, rows: int) -> None:
        """Find the columns of a recording of so many rows."""
        self._rows = rows
        self._limits.require("rows", rows, f"{self._path}", "cut it")
        self._columns: dict[str, tuple[str, tuple[int, ...]]] = {}
        grips = self._arrays.get("grips")
        once = grips is not None and len(grips.shape) == 2
        self.grips = self._constant_grips() if once else None
        for name in self._arrays:
            self._add(name)
        self._list()

    def _list(self) -> None:
        self.columns = list(self._columns)
        taken = {name for name, _ in self._columns.values()}
        self.left_out = [
            name
            for name in self._arrays
            if name not in taken and (name != "grips" or self.grips is None)
        ]

    def _require_numbers(self, name: str, stamps: Stamps | None = None) -> None:
        kind = self._arrays[name].dtype
        if stamps is not None and kind.kind not in "MUS":
            raise InvalidInput(
                f"{self._path}, array {name!r} must hold times as text or time stamps, got {kind}; "
                "say their unit, as --time s"
            )
        if stamps is None and kind.kind not in "fiu":
            remedy = "say --time iso if it is time" if kind.kind == "M" else "convert it"
            raise InvalidInput(
                f"{self._path}, array {name!r} must hold numbers, got {kind}; {remedy}"
            )

    def _constant_grips(self) -> FloatArray:
        rows = self._arrays["grips"].shape[0]
        self._require_numbers("grips")
        self._require_few("grips", rows)
        self.row_bytes(["grips"])
        with self._reader(["grips"]) as read:
            return read("grips", 0, rows).astype(np.float64)

    def _require_few(self, name: str, effectors: int) -> None:
        place = f"{self._path}, array {name!r}"
        self._limits.require("effectors", effectors, place, "leave some out")

    def _add(self, name: str) -> None:
        """Enter the columns that an array holds."""
        shape, kind = self._shape(name), self._arrays[name].dtype.kind
        if (name == "grips" and self.grips is not None) or kind not in CARRIED:
            return
        if name in BLOCKS and len(shape) > 1:
            if name not in ("pose", "twist"):
                self._require_few(name, shape[1])
            columns = _block_columns(name, shape[1:])
            if columns is None:
                raise InvalidInput(
                    f"{self._path}, array {name!r} must be of a documented shape, got "
                    f"{shape}; see docs/recordings.md"
                )
        elif len(shape) == 1 and (shape[0] == self._rows or name in ("f1x", "time")):
            columns = {name: ()}
        else:
            return
        self._require_as_long(name)
        for column, index in columns.items():
            if column in self._columns:
                raise InvalidInput(
                    f"{self._path}: {column} must be there once, got it in {name!r} and "
                    f"{self._columns[column][0]!r}; leave one out"
                )
            self._columns[column] = (name, index)
        remedy = "leave out what is not needed"
        self._limits.require("columns", len(self._columns), f"{self._path}", remedy)

    def _require_as_long(self, name: str) -> None:
        length = self._shape(name)[:1]
        if length != (self._rows,):
            raise InvalidInput(
                f"{self._path}, array {name!r} must be as long as the others, {self._rows} rows, "
                f"got {length[0] if length else 'no row'}; cut or fill it"
            )

    def _add_part(self, name: str, array: str, index: tuple[int, ...]) -> None:
        """Enter one column of an array."""
        self._require_as_long(array)
        shape = self._shape(array)[1:]
        inside = len(shape) == len(index) and all(
            k < size for k, size in zip(index, shape, strict=True)
        )
        if not inside or self._arrays[array].dtype.kind not in CARRIED:
            raise InvalidInput(
                f"{self._path}, array {array!r} must have a number at {name!r} in every row, got "
                f"rows of shape {shape} of {self._arrays[array].dtype}; count from 0, one number "
                "an axis"
            )
        self._columns[name] = (array, index)
        self._list()


def _numbers(values: npt.NDArray[Any], stamps: Stamps | None) -> FloatArray:
    if stamps is None:
        return values.astype(np.float64)
    if values.dtype.kind == "M":
        stamped = values.astype("M8[ns]")
        return stamps.of_nanoseconds(stamped.astype(np.int64), ~np.isnat(stamped))
    import pyarrow as pa

    texts = np.char.decode(values, "utf-8", "replace") if values.dtype.kind == "S" else values
    return stamps.of_texts(pa.array(texts.tolist(), pa.string()))


def _block_columns(name: str, shape: tuple[int, ...]) -> dict[str, tuple[int, ...]] | None:
    """Documented columns of an array of that shape beyond its rows, and where they are in it."""
    if name in ("pose", "twist"):
        known = POSE if name == "pose" else {len(names): names for names in TWIST.values()}
        names = known.get(shape[0]) if len(shape) == 1 else None
        return None if names is None else {each: (j,) for j, each in enumerate(names)}
    kind = {"force": "f", "torque": "t", "grips": "r"}[name]
    if name == "torque" and len(shape) == 1:
        return {each: (i,) for i, (each,) in enumerate(effector_names(kind, shape[0], 2))}
    if len(shape) != 2 or shape[1] not in ((3,) if name == "torque" else (2, 3)):
        return None
    groups = effector_names(kind, *shape)
    return {each: (i, j) for i, group in enumerate(groups) for j, each in enumerate(group)}
