"""Text tables, CSV and TSV: reading them line by line, and writing CSV.

A file is split into lines here, so that every bad one has its number; pyarrow parses the fields.
"""

import csv
import io
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.formats.chunks import Chunk, Column, Sink, Source, Wanted
from coopenv.logs.formats.cleaning import BLANKS, cleaner, split
from coopenv.logs.formats.encoded import Text
from coopenv.logs.formats.head import SHORTEN, HeadReader
from coopenv.logs.formats.lines import Lines, as_numbers, spread
from coopenv.logs.limits import Limits, shown

BLOCK = 4 << 20  # [bytes] read at once
WRITTEN = 8192  # rows made text at once: of more, the text alone takes tens of megabytes


class TextSource(Source):
    """A text file with a row a line, of the form that a `Dialect` says.

    Comma, semicolon, tab or bar separate its fields, whichever the header has most of, or blanks if
    it has none of these. They may be quoted, but a quoted field must end on its line. Empty lines
    are passed over.
    """

    def __init__(self, path: Path, dialect: Dialect, limits: Limits):
        try:
            import pyarrow.csv  # noqa: F401
        except ImportError as error:
            raise MissingExtra("reading CSV", "analysis") from error
        self._path, self._decimal, self._limits = path, dialect.decimal, limits
        self._rule = "a finite number" + " without a point (--decimal ,)" * (self._decimal == ",")
        self._text = Text(path, dialect.encoding)
        with self._text.open() as file:
            self._head = HeadReader(path, dialect, limits).read(file)
        head = self._head
        self.columns, self.units, self.repeated = head.columns, head.units, head.repeated
        self.separator = "\t" if head.separator == BLANKS else head.separator
        self._clean = cleaner(
            head.separator, dialect.comment, columns=len(head.columns), empty=head.empty
        )

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read block by block; what is carried stays text."""
        row, line = 1, self._head.line
        for block, progress in self._blocks():
            lines = Lines(block, line, self.columns, self.separator, self.split)
            if lines.longest > self._limits.row_bytes:
                place = f"{self._path}, line {line + lines.longest_number}"
                self._limits.require("row_bytes", "more", place, SHORTEN)
            if lines.rows:
                yield self._chunk(lines, wanted, row, progress)
            row, line = row + lines.rows, line + len(lines.ends)

    def _chunk(self, lines: Lines, wanted: Wanted, first_row: int, progress: float) -> Chunk:
        """Rows of a block."""
        table = self._parse(lines, wanted)
        good = lines.good[lines.kept]
        read: dict[str, FloatArray] = {}
        bad: dict[str, BoolArray] = {}
        for name in wanted.numbers:
            if name in wanted.stamps:
                values, wrong = wanted.stamps[name].of_texts(table[name]), None
            else:
                values, wrong = as_numbers(table[name], self._decimal)
            read[name] = spread(values, good, np.nan)
            if wrong is not None:
                bad[name] = spread(wrong, good, True)
        return _TextChunk(
            numbers=read,
            carried={name: spread(table[name].to_numpy(), good, "") for name in wanted.carried},
            rows=lines.rows,
            first_row=first_row,
            progress=progress,
            rule=self._rule,
            rules=wanted.rules,
            bad=bad,
            fields=np.where(good, 0, lines.fields[lines.kept]),
            lines=lines,
        )

    def split(self, line: str, place: str) -> list[str]:
        """Fields of a line, without quotation marks."""
        return split(self._path, line, self.separator, place)

    def _blocks(self) -> Iterator[tuple[bytes, float]]:
        """Whole lines of the body, each with its line feed, and the share that has been read."""
        for block, progress in self._read():
            yield (block if self._clean is None else self._clean(block)), progress

    def _read(self) -> Iterator[tuple[bytes, float]]:
        """The same as they are in the file."""
        rest = bytearray()  # of a line that goes on
        with self._text.open() as file:
            file.skip(self._head.body)
            while True:
                read = file.read(BLOCK)
                end = read.rfind(b"\n") + 1
                if read and not end and len(rest) + len(read) <= self._limits.row_bytes:
                    rest += read
                elif end:
                    block = b"".join((rest, memoryview(read)[:end]))
                    rest = bytearray(memoryview(read)[end:])
                    yield block, file.progress
                else:  # the last line, or one that is too long
                    if rest or read:
                        yield bytes(rest + read + b"\n"), 1.0
                    return

    def _parse(self, lines: Lines, wanted: Wanted) -> Any:
        """The columns as pyarrow parses them; all as text where a number is not one."""
        import pyarrow as pa

        texts = dict.fromkeys([*wanted.carried, *wanted.stamps], pa.string())
        types = dict.fromkeys(wanted.numbers, pa.float64()) | texts
        data = lines.good_bytes()
        if not data:  # every line lacks fields or has too many; pyarrow takes none for a fault
            return pa.schema(list(types.items())).empty_table()
        try:
            return self._table(data, types)
        except pa.ArrowInvalid:
            pass
        types = dict.fromkeys(wanted.numbers, pa.string()) | texts
        try:
            return self._table(data, types)
        except pa.ArrowInvalid as error:
            place, why = self._first_refused(lines, types, error)
            raise InvalidInput(
                f"{self._path}, {place} must be CSV in UTF-8, got {shown(why, 200)}; say its "
                "--encoding, or save it again"
            ) from error

    def _first_refused(
        self, lines: Lines, types: dict[str, Any], why: Exception
    ) -> tuple[str, Exception]:
        """The first line that pyarrow does not take, and what it says; found by halving."""
        import pyarrow as pa

        low, high = 0, len(lines.good)
        while high - low > 1:
            middle = (low + high) // 2
            data = lines.good_bytes(low, middle)
            try:
                if data:
                    self._table(data, types)
                low = middle
            except pa.ArrowInvalid as error:
                high, why = middle, error
        return f"line {lines.first + low}", why

    def _table(self, data: bytes, types: dict[str, Any]) -> Any:
        import pyarrow as pa
        from pyarrow import csv as arrow

        return arrow.read_csv(
            pa.BufferReader(data),
            arrow.ReadOptions(column_names=self.columns, block_size=max(2 * BLOCK, len(data) + 1)),
            arrow.ParseOptions(delimiter=self.separator),
            arrow.ConvertOptions(
                column_types=types, include_columns=list(types), decimal_point=self._decimal
            ),
        )


class TextSink(Sink):
    """CSV; numbers in the shortest form that reads back the same, NaN as an empty field."""

    def __init__(self, path: Path):
        try:
            import pyarrow.csv  # noqa: F401
        except ImportError as error:
            raise MissingExtra("writing CSV", "analysis") from error
        self._file = path.open("wb")
        self._begun = False
        self._pool = ThreadPoolExecutor(1)  # writes numbers as text while the next are computed
        self._pending: Future[None] | None = None

    def write(self, columns: Mapping[str, Column]) -> None:
        """Append rows, of which the first are preceded by the header."""
        import pyarrow as pa

        if not self._begun:
            header = io.StringIO()
            csv.writer(header, lineterminator="\n").writerow(columns)
            self._file.write(header.getvalue().encode())
            self._begun = True
        arrays = [_array(values) for values in columns.values()]
        self._wait()
        self._pending = self._pool.submit(self._append, pa.table(arrays, names=list(columns)))

    def close(self) -> None:
        """Finish the file."""
        self._wait()
        self.abandon()

    def abandon(self) -> None:
        """Release the file, without the rows that wait."""
        self._pool.shutdown(cancel_futures=True)
        self._file.close()

    def _append(self, table: Any) -> None:
        for first in range(0, table.num_rows, WRITTEN):
            self._file.write(_as_text(table.slice(first, WRITTEN)))

    def _wait(self) -> None:
        """Until the rows before are written; raises what went wrong with them."""
        if self._pending is not None:
            self._pending.result()
            self._pending = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _TextChunk(Chunk):
    """Rows named by their lines, with what is written there."""

    lines: Lines

    def place(self, row: int) -> str:
        return f"line {self.lines.first + self.lines.number(row)}"

    def text(self, row: int, column: str) -> str:
        return self.lines.field(row, column)


def _array(values: Column) -> Any:
    """A pyarrow array; as text where values are of several types."""
    import pyarrow as pa

    try:
        return pa.array(values, from_pandas=True)
    except (pa.ArrowInvalid, pa.ArrowTypeError, pa.ArrowNotImplementedError):
        return pa.array([None if value is None else str(value) for value in values], pa.string())


def _as_text(table: Any) -> Any:
    """A buffer of the rows of a pyarrow table as CSV, quoted only where it is needed."""
    import pyarrow as pa
    from pyarrow import csv as arrow

    for quoting in ("none", "needed"):
        out = pa.BufferOutputStream()
        try:
            options = arrow.WriteOptions(include_header=False, quoting_style=quoting)
            arrow.write_csv(table, out, options)
        except pa.ArrowInvalid:
            continue
        return out.getvalue()
    raise InvalidInput("columns must be numbers and text to be written to CSV; write Parquet")
