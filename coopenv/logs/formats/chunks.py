"""Files as a sequence of chunks of columns, whatever their format."""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray
from coopenv.errors import InvalidInput

CHUNK_ROWS = 16_384
SUFFIXES = (".csv", ".tsv", ".txt", ".npz", ".parquet")
Column = npt.NDArray[Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Chunk:
    """Consecutive rows of a file."""

    numbers: dict[str, FloatArray]  # column of the file -> (T,), NaN where there is no number
    carried: dict[str, Column]  # column of the file -> (T,)
    rows: int
    first_row: int  # its number in the file, from 1, the header not counted
    progress: float  # share of the file that has been read, in [0, 1]
    place: Callable[[int], str]  # how to call a row of the chunk: "line 17"
    text: Callable[[int, str], str]  # what is written in a row and column
    fields: IntArray | None = None  # (T,) number of fields where it is wrong, else 0; CSV only


class Source(Protocol):
    """A file that is open for reading."""

    columns: list[str]
    grips: FloatArray | None  # (n, 2 or 3) if the file says them once, in its own unit
    left_out: list[str]  # what the file holds beside columns

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read the columns that are numbers and those that are only carried."""
        ...


def open_source(path: str | os.PathLike, decimal: str = ".") -> Source:
    """The file's reader, chosen by its suffix.

    Raises
    ------
    InvalidInput
        If there is no such file, or its suffix or content is not understood.
    MissingExtra
        If reading it needs the extra ``analysis``.
    """
    path = Path(path)
    if not path.is_file():
        raise InvalidInput(f"file must exist, got {str(path)!r}; check its name")
    kind = suffix_of(path)
    if kind == ".npz":
        from coopenv.logs.formats.npz import NpzSource

        return NpzSource(path)
    if kind == ".parquet":
        from coopenv.logs.formats.parquet import ParquetSource

        return ParquetSource(path)
    from coopenv.logs.formats.text import CsvSource

    return CsvSource(path, decimal)


def suffix_of(path: Path) -> str:
    """The format a name asks for."""
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise InvalidInput(
            f"file must end in one of {', '.join(SUFFIXES)}, got {path.name!r}; convert or rename "
            "it"
        )
    return ".csv" if kind in (".tsv", ".txt") else kind


def row_number(first_row: int) -> Callable[[int], str]:
    """Calls rows of files without lines by their number."""
    return lambda row: f"row {first_row + row}"


def value_of(numbers: dict[str, FloatArray]) -> Callable[[int, str], str]:
    """Tells what is in a row and column of files that hold numbers."""
    return lambda row, column: str(numbers[column][row])
