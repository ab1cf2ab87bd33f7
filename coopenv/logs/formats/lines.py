"""Lines of a text table: where they begin, their fields and the numbers in them, damaged ones."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.logs.formats.chunks import Column

LINE_FEED, RETURN = 10, 13
OPEN, BROKEN = -1, -2  # instead of a number of fields: a quotation mark, a carriage return
MISSING = {"", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-"}  # instead of a number


class Lines:
    """Lines of a block of bytes, and which of them have as many fields as the header.

    Parameters
    ----------
    block
        Ends with a line feed.
    first
        Number of the first line in the file, from 1.
    columns, separator
        Of the file.
    split
        From a line and its place to its fields.
    """

    def __init__(
        self,
        block: bytes,
        first: int,
        columns: Sequence[str],
        separator: str,
        split: Callable[[str, str], list[str]],
    ):
        self._block, self._columns, self._split = block, columns, split
        self.first = first
        self._codes = np.frombuffer(block, dtype=np.uint8)
        self.ends: IntArray = np.flatnonzero(self._codes == LINE_FEED)
        self.starts: IntArray = np.concatenate([[0], self.ends[:-1] + 1])
        separators = self._codes == ord(separator)
        self.fields: IntArray = np.add.reduceat(separators, self.starts, dtype=np.int64) + 1
        length = self.ends - self.starts
        self.longest_number = int(length.argmax())
        self.longest = int(length[self.longest_number])  # [bytes]
        if b"\r" in block:
            self._mark_broken()
        if b'"' in block:
            self._count_quoted()
        self.kept: BoolArray = (length > 1) | ((length == 1) & (self._codes[self.starts] != RETURN))
        self.good: BoolArray = self.kept & (self.fields == len(columns))
        self.rows = int(self.kept.sum())

    def number(self, row: int) -> int:
        """Which line, from 0, a row is: lines that are empty are no rows."""
        return int(np.flatnonzero(self.kept)[row])

    def field(self, row: int, column: str) -> str:
        """What a row has in a column."""
        return self._fields(self.number(row))[self._columns.index(column)]

    def good_bytes(self, start: int = 0, stop: int | None = None) -> bytes:
        """Those of the lines that have all their fields."""
        part = slice(start, stop)
        good, starts, ends = self.good[part], self.starts[part], self.ends[part]
        if not good.any():
            return b""
        block = slice(starts[0], ends[-1] + 1)
        if good.all():
            return self._block[block]  # no copy where it is all of it
        return self._codes[block][np.repeat(good, ends - starts + 1)].tobytes()

    def _fields(self, number: int) -> list[str]:
        line = self._block[self.starts[number] : self.ends[number]]
        text = line.decode(errors="replace").rstrip("\r")
        return self._split(text, f"line {self.first + number}")

    def _mark_broken(self) -> None:
        """Lines with a carriage return inside, which others take for the end of a line."""
        returns = np.flatnonzero(self._codes == RETURN)
        alone = returns[self._codes[returns + 1] != LINE_FEED]
        self.fields[np.searchsorted(self.ends, alone)] = BROKEN

    def _count_quoted(self) -> None:
        """Count fields of lines with quotation marks, unless one is left open."""
        quoted = np.add.reduceat(self._codes == ord('"'), self.starts, dtype=np.int64)
        for number in np.flatnonzero((quoted > 0) & (self.fields != BROKEN)).tolist():
            self.fields[number] = len(self._fields(number)) if quoted[number] % 2 == 0 else OPEN


def as_numbers(column: Any, decimal: str) -> tuple[FloatArray, BoolArray | None]:
    """Numbers of a pyarrow column, NaN where a text is none; and where it is not even missing."""
    import pyarrow as pa

    if column.type == pa.float64():
        return column.to_numpy(), None
    texts = column.to_pylist()
    values = np.fromiter((_number(text, decimal) for text in texts), np.float64, len(texts))
    bad = np.zeros(len(texts), np.bool_)
    for row in np.flatnonzero(np.isnan(values)).tolist():
        bad[row] = texts[row].strip().lower() not in MISSING
    return values, bad


def _number(text: str, decimal: str) -> float:
    try:
        if "_" in text or (decimal != "." and "." in text):  # 1.234 may be meant as 1,234
            return np.nan
        return float(text.replace(decimal, "."))
    except ValueError:
        return np.nan


def spread(values: npt.NDArray, good: BoolArray, missing: object) -> Column:
    """Values where a row is good, and something else where it is not."""
    if good.all():
        return values
    made = np.full(len(good), missing, dtype=values.dtype)
    made[good] = values
    return made
