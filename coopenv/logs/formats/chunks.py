"""Types of file formats: chunks of columns, their source (reader) and their sink (writer)."""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.stamps import Stamps
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
    rules: Mapping[str, str] = field(default_factory=dict)  # of single columns
    bad: Mapping[str, BoolArray] = field(default_factory=dict)  # column -> (T,): not even missing
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


class Roles(NamedTuple):
    """What columns are, for those that say something between samples."""

    time: str = ""
    factor: float = 1.0  # of the time, to seconds
    quaternion: tuple[str, ...] = ()  # w, x, y, z
    angle: str = ""  # of the orientation in the plane
    period: float = math.tau  # of the angle, in its unit


class Owner(NamedTuple):
    """A device whose column it is, where several are joined."""

    name: str
    path: str
    part: str = ""  # of a file of several
    delay: float = 0.0  # by which its stamps are said to be late [s]

    @property
    def label(self) -> str:
        """Its file or part, and its name where that is another."""
        place = self.part or Path(self.path).name
        return place if self.name in place else f"{self.name}, {place}"


class Wanted(NamedTuple):
    """Columns that are to be read from a file."""

    numbers: Sequence[str]  # read as numbers
    carried: Sequence[str] = ()  # with the type they have in the file
    stamps: Mapping[str, Stamps] = MappingProxyType({})  # times of ``numbers``, read as seconds

    @property
    def names(self) -> list[str]:
        """All of them, each once."""
        return list(dict.fromkeys((*self.numbers, *self.carried)))

    @property
    def rules(self) -> dict[str, str]:
        """What times must be, in messages."""
        return {name: each.rule for name, each in self.stamps.items()}


class Source(ABC):
    """Reader of a file of one format.

    Parameters
    ----------
    path
        Of a file that exists.
    dialect
        How the file is written, if it is text.
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
    units: Mapping[str, str] = MappingProxyType({})  # column -> unit, where the file says it
    repeated: Collection[str] = ()  # documented names that several columns had
    stamped: str = ""  # a column of time stamps, whatever is said of units
    made: Collection[str] = ()  # columns that are made of others, and are not in the file
    owners: Mapping[str, Owner] = MappingProxyType({})  # column -> device, of several on one clock

    @abstractmethod
    def __init__(self, path: Path, dialect: Dialect, limits: Limits): ...

    def offer(self, names: Iterable[str]) -> None:  # noqa: B027
        """Make parts of arrays columns, such as ``actions:0``, as far as there are such parts."""

    def assign(self, roles: Roles) -> None:  # noqa: B027
        """Say what columns are, before they are read."""

    @property
    def shapes(self) -> Mapping[str, tuple[int, ...]]:
        """Of the arrays that it holds, rows first, if it holds arrays."""
        return {}

    @property
    def num_fields(self) -> int:
        """How many fields a row of the file has, if it is text."""
        return len(self.columns)

    @property
    def notes(self) -> Sequence[str]:
        """What there is to say of the file once all of it is read, a sentence each."""
        return ()

    @abstractmethod
    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read these columns, in the order of the file, some thousand rows at a time.

        Parameters
        ----------
        wanted
            Which columns, and what is made of them.

        Raises
        ------
        InvalidInput
            If the file is damaged, or a column of ``wanted.numbers`` holds something else
            throughout.
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
    sink: type[Sink] | None  # none of a format that is only read
    parts: Callable[[Path, Limits], list[str]] | None = None  # of one that keeps streams apart


PART = re.compile(r"(.+?)((?::\d{1,6})+)", re.DOTALL)  # actions:0, force:1:2


def part_of(name: str) -> tuple[str, tuple[int, ...]] | None:
    """An array and the place in its rows that a name asks for: ``("actions", (0,))``."""
    found = PART.fullmatch(name)
    return None if found is None else (found[1], tuple(map(int, found[2][1:].split(":"))))
