"""Types of file formats: chunks of columns, their source (reader) and their sink (writer)."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.logs.limits import Limits

CHUNK_ROWS = 16_384
CHUNK_BYTES = 32 << 20  # of wide rows there are fewer in a chunk
Column = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Consecutive rows of a file."""

    numbers: dict[str, FloatArray]  # column of the file -> (T,), NaN where there is no number
    carried: dict[str, Column]  # column of the file -> (T,)
    rows: int
    first_row: int  # its number in the file, from 1, the header not counted
    progress: float  # share of the file that has been read, in [0, 1]
    rule: str = "a finite number"  # what a number must be, in messages
    fields: IntArray | None = None  # (T,) number of fields where it is wrong, else 0; text only

    @property
    def whole(self) -> BoolArray:
        """Which rows ``(T,)`` have as many fields as the header."""
        return np.ones(self.rows, np.bool_) if self.fields is None else self.fields == 0

    def place(self, row: int) -> str:
        """Name of a row of the chunk in messages, such as "row 17"."""
        return f"row {self.first_row + row}"

    def called(self, column: str) -> str:
        """Name of a column in messages."""
        return f"column {column!r}"

    def text(self, row: int, column: str) -> str:
        """Content of the file in a row of the chunk and a column of numbers."""
        return str(self.numbers[column][row])


class Source(ABC):
    """Reader of a file of one format.

    Parameters
    ----------
    path
        Of a file that exists.
    decimal
        What separates decimals, for formats that hold numbers as text.
    limits
        On what the file may cost.

    Raises
    ------
    InvalidInput
        If the file is not of the format, or beyond a limit.
    MissingExtra
        If reading it needs the extra ``analysis``.
    """

    columns: list[str]
    left_out: Sequence[str] = ()  # what the file holds beside columns
    grips: FloatArray | None = None  # (n, 2 or 3) if the file has them once, in its own unit

    @abstractmethod
    def __init__(self, path: Path, decimal: str, limits: Limits): ...

    @abstractmethod
    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read these columns, in the order of the file, some thousand rows at a time.

        Parameters
        ----------
        numbers
            Columns to be read as numbers.
        carried
            Columns that keep the type they have in the file.

        Raises
        ------
        InvalidInput
            If the file is damaged, or a column of ``numbers`` holds something else throughout.
        """


class Sink(ABC):
    """Writer of a table in one format, some rows at a time, always the same columns.

    Parameters
    ----------
    path
        Of the file to be written.

    Raises
    ------
    MissingExtra
        If writing it needs the extra ``analysis``.
    """

    @abstractmethod
    def __init__(self, path: Path): ...

    @abstractmethod
    def write(self, columns: Mapping[str, Column]) -> None:
        """Append rows; each column is ``(T,)``."""

    def describe(self, done: Sequence[str]) -> None:  # noqa: B027
        """Say within the file what was done to the recording, where the format has room for it.

        Before it is closed, after rows were written.
        """

    @abstractmethod
    def close(self) -> None:
        """Finish the file."""

    @abstractmethod
    def abandon(self) -> None:
        """Release the file, which is not wanted any more; it may be half written."""


def rows_at_once(most: int, row_bytes: int) -> int:
    """How many rows of so many bytes are read at once: ``most``, or fewer where they are wide."""
    return max(1, min(most, CHUNK_BYTES // max(row_bytes, 1)))


def plain(column: Column) -> Column:
    """A carried column of a type that every format writes.

    Numbers in the byte order of the machine and of at most 64 bits; bytes as text, with the code of
    those that are none.
    """
    kind, size = column.dtype.kind, column.dtype.itemsize
    if kind == "f" and size not in (4, 8):
        return column.astype(np.float64)
    if kind in "biufU" and not column.dtype.isnative:
        return column.astype(column.dtype.newbyteorder("="))
    if kind == "S":
        column = column.astype(object)
    if column.dtype == object and any(isinstance(each, bytes) for each in column):
        return np.array([_text(each) for each in column], dtype=object)
    return column


def _text(value: Any) -> Any:
    return value.decode(errors="backslashreplace") if isinstance(value, bytes) else value


class Format(NamedTuple):
    """A file format, as the registry lists it."""

    suffixes: tuple[str, ...]  # of names, in small letters; tables get the first by default
    source: type[Source]
    sink: type[Sink]
