"""CSV: split into lines here, so that every bad one has its number; parsed by pyarrow."""

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.formats.chunks import Chunk, Column

BLOCK = 4 << 20  # [bytes] read at once
SEPARATORS = (",", ";", "\t")
LINE_FEED, RETURN = 10, 13


class CsvSource:
    """A text file with one header line.

    Comma, semicolon or tab separate its fields, whichever the header has most of. They may be
    quoted, but a quoted field must end on its line. Empty lines are passed over.
    """

    def __init__(self, path: Path, decimal: str = "."):
        try:
            import pyarrow.csv  # noqa: F401
        except ImportError as error:
            raise MissingExtra("reading CSV", "analysis") from error
        self.grips: FloatArray | None = None
        self.left_out: list[str] = []
        self._path, self._decimal = path, decimal
        with path.open("rb") as file:
            header = file.readline()
            self._body = file.tell()
        text = self._decode(header.removeprefix(b"\xef\xbb\xbf"), "line 1")
        if not text.strip():
            seen = "a blank line" if header.endswith(b"\n") else "an empty file"
            raise InvalidInput(
                f"{path}, line 1 must name the columns, got {seen}; begin the file with its header"
            )
        if "\r" in text:
            raise InvalidInput(
                f"{path}: lines must end with a line feed, got carriage returns alone; save the "
                "file with the line ends of Unix or Windows"
            )
        self._separator = max(SEPARATORS, key=text.count)
        if decimal == self._separator:
            raise InvalidInput(
                f"{path}: decimal must not be what separates the columns, got {decimal!r} for both;"
                " separate them with semicolons"
            )
        self.columns = [name.strip() for name in self._fields(text)]

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read block by block; what is carried stays text."""
        size = max(self._path.stat().st_size, 1)
        row, line, rest = 1, 2, b""
        with self._path.open("rb") as file:
            file.seek(self._body)
            while True:
                read = file.read(BLOCK)
                block = rest + read
                if not block:
                    return
                end = block.rfind(b"\n") + 1 if read else len(block)
                block, rest = block[:end], block[end:]
                if not block:
                    continue  # a line longer than a block
                if not block.endswith(b"\n"):
                    block += b"\n"
                lines = _Lines(block, self)
                if lines.rows:
                    progress = min(1.0, file.tell() / size)
                    yield self._chunk(lines, numbers, carried, row, line, progress)
                row, line = row + lines.rows, line + len(lines.ends)

    def _chunk(
        self,
        lines: "_Lines",
        numbers: Sequence[str],
        carried: Sequence[str],
        row: int,
        line: int,
        progress: float,
    ) -> Chunk:
        table = self._parse(lines.good_bytes(), numbers, carried)
        good = lines.good[lines.kept]
        in_file = line + np.flatnonzero(lines.kept)
        values, texts = {}, {}
        for name in numbers:
            values[name] = _spread(_numbers(table[name], self._decimal), good, np.nan)
        for name in carried:
            texts[name] = _spread(table[name].to_numpy(), good, "")

        def text(at: int, column: str) -> str:
            fields = self._fields(lines.text(int(in_file[at]) - line))
            return fields[self.columns.index(column)]

        return Chunk(
            numbers=values,
            carried=texts,
            rows=lines.rows,
            first_row=row,
            progress=progress,
            place=lambda at: f"line {in_file[at]}",
            text=text,
            fields=np.where(good, 0, lines.fields[lines.kept]),
        )

    def _parse(self, data: bytes, numbers: Sequence[str], carried: Sequence[str]):
        """The columns as pyarrow parses them; as text where one of them is not all numbers."""
        import pyarrow as pa
        from pyarrow import csv as arrow

        if not data:  # every line lacks fields or has too many; pyarrow takes none for a fault
            kinds = dict.fromkeys(numbers, pa.float64()) | dict.fromkeys(carried, pa.string())
            return pa.schema(list(kinds.items())).empty_table()
        for kind in (pa.float64(), pa.string()):
            types = {**dict.fromkeys(numbers, kind), **dict.fromkeys(carried, pa.string())}
            try:
                return arrow.read_csv(
                    pa.BufferReader(data),
                    arrow.ReadOptions(column_names=self.columns, block_size=2 * BLOCK),
                    arrow.ParseOptions(delimiter=self._separator),
                    arrow.ConvertOptions(
                        column_types=types,
                        include_columns=list(types),
                        decimal_point=self._decimal,
                    ),
                )
            except pa.ArrowInvalid as error:
                if kind == pa.string():
                    raise InvalidInput(f"{self._path} must be CSV in UTF-8, got {error}") from error
        raise AssertionError

    def _fields(self, text: str) -> list[str]:
        return next(csv.reader([text], delimiter=self._separator), [])

    def _decode(self, line: bytes, where: str) -> str:
        try:
            return line.decode().rstrip("\r\n")
        except UnicodeDecodeError as error:
            raise InvalidInput(
                f"{self._path}, {where} must be UTF-8 text, got {line[error.start :][:8]!r}; save "
                "the file in that encoding"
            ) from error


class _Lines:
    """Where the lines of a block are, and which of them have as many fields as the header."""

    def __init__(self, block: bytes, source: CsvSource):
        self._block, self._source = block, source
        self._codes = np.frombuffer(block, dtype=np.uint8)
        self.ends: IntArray = np.flatnonzero(self._codes == LINE_FEED)
        self.starts: IntArray = np.concatenate([[0], self.ends[:-1] + 1])
        separators = self._codes == ord(source._separator)
        self.fields: IntArray = np.add.reduceat(separators, self.starts, dtype=np.int64) + 1
        if b'"' in block:
            self._count_quoted()
        length = self.ends - self.starts
        self.kept: BoolArray = (length > 1) | ((length == 1) & (self._codes[self.starts] != RETURN))
        self.good: BoolArray = self.kept & (self.fields == len(source.columns))
        self.rows = int(self.kept.sum())

    def good_bytes(self) -> bytes:
        """The lines that have all their fields."""
        if self.good.all():
            return self._block
        return self._codes[np.repeat(self.good, self.ends - self.starts + 1)].tobytes()

    def text(self, number: int) -> str:
        """One line."""
        line = self._block[self.starts[number] : self.ends[number]]
        return line.decode(errors="replace").rstrip("\r")

    def _count_quoted(self) -> None:
        quoted = np.add.reduceat(self._codes == ord('"'), self.starts, dtype=np.int64)
        for number in np.flatnonzero(quoted).tolist():
            fields = len(self._source._fields(self.text(number)))
            self.fields[number] = fields if quoted[number] % 2 == 0 else -1


def _numbers(column, decimal: str) -> FloatArray:
    """Numbers of a pyarrow column; NaN where a text is none."""
    import pyarrow as pa

    if column.type == pa.float64():
        return column.to_numpy()
    texts = column.to_pylist()
    return np.fromiter((_number(text, decimal) for text in texts), np.float64, len(texts))


def _number(text: str, decimal: str) -> float:
    try:
        return np.nan if "_" in text else float(text.replace(decimal, "."))
    except ValueError:
        return np.nan


def _spread(values: npt.NDArray, good: BoolArray, missing: object) -> Column:
    """Put values where a row is good, and something else where it is not."""
    if good.all():
        return values
    spread = np.full(len(good), missing, dtype=values.dtype)
    spread[good] = values
    return spread
