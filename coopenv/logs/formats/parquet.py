"""Parquet tables: reading and writing them in batches with pyarrow."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.stamps import Stamps
from coopenv.logs.formats.arrow import (
    as_numpy,
    bytes_of_rows,
    is_list,
    is_number,
    is_text,
    place_of_lists,
    seconds,
)
from coopenv.logs.formats.chunks import (
    CHUNK_ROWS,
    Chunk,
    Column,
    Sink,
    Source,
    Wanted,
    part_of,
    plain,
    rows_at_once,
)
from coopenv.logs.limits import Limits, shown

FOOTER = 64 << 20  # [bytes] of what a file says of itself at its end
READ = 1 << 20  # [bytes] of a column at once


class ParquetSource(Source):
    """A Parquet file with one value a row and column, or lists of numbers."""

    def __init__(self, path: Path, dialect: Dialect, limits: Limits):
        try:
            from pyarrow import parquet, types
        except ImportError as error:
            raise MissingExtra("reading Parquet", "analysis") from error
        self._path, self._limits = path, limits
        _require_footer(path)
        with _parsing(path), parquet.ParquetFile(path) as file:
            self._require_small(file.metadata)
            schema = file.schema_arrow
        self.columns = [entry.name for entry in schema if not types.is_nested(entry.type)]
        self.left_out = [entry.name for entry in schema if types.is_nested(entry.type)]
        self._types = {entry.name: entry.type for entry in schema}
        self._parts: dict[str, tuple[str, int]] = {}  # column -> list, place in it

    def offer(self, names: Iterable[str]) -> None:
        """Make places of lists columns, where these names ask for them."""
        for name in names:
            part = part_of(name)
            if part is None or name in self.columns or not is_list(self._types.get(part[0])):
                continue
            listed, (index, *more) = part
            kind = self._types[listed].value_type
            if more or not is_number(kind):
                raise InvalidInput(
                    f"{self._path}, column {listed!r} must be lists of numbers for {name!r}, got "
                    f"lists of {kind}; give one number, or convert it"
                )
            self._parts[name] = (listed, index)
            self._types[name] = kind
            self.columns.append(name)
            self.left_out = [each for each in self.left_out if each != listed]

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read batch by batch; what is carried keeps its type."""
        from pyarrow import parquet

        numbers, carried, stamps = wanted
        for name in numbers:
            self._require_kind(name, stamps)
        row = 1
        read = dict.fromkeys(self._parts.get(name, (name,))[0] for name in wanted.names)
        texts = [name for name in read if is_text(self._types[name]) and name not in stamps]
        with (
            _parsing(self._path),
            parquet.ParquetFile(self._path, buffer_size=READ, read_dictionary=texts) as file,
        ):
            total = max(file.metadata.num_rows, 1)
            for batch in self._batches(file, list(read)):
                yield Chunk(
                    numbers={name: self._numbers(batch, name, stamps) for name in numbers},
                    carried={name: plain(as_numpy(batch[name])) for name in carried},
                    rows=batch.num_rows,
                    first_row=row,
                    progress=(row - 1 + batch.num_rows) / total,
                    rules=wanted.rules,
                )
                row += batch.num_rows

    def _require_kind(self, name: str, stamps: Mapping[str, Stamps]) -> None:
        """Raise unless a column holds numbers, or times if it is said to."""
        from pyarrow import types

        kind = self._types[name]
        if name in stamps and not (
            types.is_timestamp(kind) or types.is_string(kind) or types.is_large_string(kind)
        ):
            raise InvalidInput(
                f"{self._path}, column {name!r} must hold times as text or time stamps, got "
                f"{kind}; say their unit, as --time s"
            )
        if name not in stamps and not is_number(kind):
            remedy = "say --time iso if it is time" if types.is_timestamp(kind) else "convert it"
            raise InvalidInput(
                f"{self._path}, column {name!r} must hold numbers, got {kind}; {remedy}"
            )

    def _numbers(self, batch: Any, name: str, stamps: Mapping[str, Stamps]) -> FloatArray:
        """A column of numbers, NaN where there is none."""
        if name in stamps:
            return seconds(batch[name], stamps[name])
        if name in self._parts:
            listed, place = self._parts[name]
            return place_of_lists(batch[listed], place)
        return batch[name].cast("float64", safe=False).to_numpy(zero_copy_only=False)

    def _batches(self, file: Any, names: list[str]) -> Iterator[Any]:
        """Rows as pyarrow reads them, in parts where they hold much text."""
        first = 1
        for batch in _small_batches(file, names, rows_at_once(CHUNK_ROWS, 8 * len(names))):
            size = sum(bytes_of_rows(column) for column in batch.columns)  # of each row
            longest = int(np.max(size)) + 8 * len(names)
            place = f"{self._path}, row {first + int(np.argmax(size))}"
            self._limits.require("row_bytes", longest, place, "shorten it")
            part = rows_at_once(batch.num_rows, longest)
            for start in range(0, batch.num_rows, part):
                yield batch.slice(start, part)
            first += batch.num_rows

    def _require_small(self, metadata: Any) -> None:
        """Raise where what a file says of itself is beyond a limit."""
        require, path = self._limits.require, f"{self._path}"
        require("columns", metadata.num_columns, path, "leave out what is not needed")
        require("rows", metadata.num_rows, path, "cut it")
        for number in range(metadata.num_row_groups):
            size = metadata.row_group(number).total_byte_size
            place = f"{path}, row group {number + 1}"
            require("block_bytes", size, place, "write it in smaller ones")


class ParquetSink(Sink):
    """Each column keeps the type of its first rows."""

    def __init__(self, path: Path):
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError as error:
            raise MissingExtra("writing Parquet", "analysis") from error
        self._path = path
        self._writer: Any = None

    def write(self, columns: Mapping[str, Column]) -> None:
        """Append rows."""
        import pyarrow as pa
        from pyarrow import parquet

        if self._writer is None:
            types = {name: pa.array(values).type for name, values in columns.items()}
            known = [
                (name, pa.string() if pa.types.is_null(kind) else kind)
                for name, kind in types.items()
            ]
            self._writer = parquet.ParquetWriter(self._path, pa.schema(known))
        arrays = []
        for name, values in columns.items():
            kind = self._writer.schema.field(name).type
            try:
                missing = not pa.types.is_floating(kind)
                arrays.append(pa.array(values, type=kind, from_pandas=missing))
            except (pa.ArrowInvalid, pa.ArrowTypeError) as error:
                raise InvalidInput(
                    f"column {name!r} must be of one type to be written to Parquet, got {kind} and "
                    f"later something else ({error}); write CSV"
                ) from error
        self._writer.write_table(pa.table(arrays, schema=self._writer.schema))

    def describe(self, done: Sequence[str]) -> None:
        """Corrections as metadata ``corrections``, a JSON list of sentences."""
        if self._writer is not None:
            text = json.dumps(list(done), ensure_ascii=False)
            self._writer.add_key_value_metadata({"corrections": text})

    def close(self) -> None:
        """Finish the file."""
        if self._writer is not None:
            self._writer.close()

    def abandon(self) -> None:
        """Release the file."""
        self.close()


@contextmanager
def _parsing(path: Path) -> Iterator[None]:
    """Say of what pyarrow does not understand which file it is; it raises `OSError` there too."""
    from pyarrow import ArrowException

    try:
        yield
    except (ArrowException, OSError) as error:
        if isinstance(error, OSError) and error.errno:
            raise
        raise InvalidInput(
            f"{path} must be a Parquet file, got {shown(error, 200)}; convert it, or write it again"
        ) from error


def _small_batches(file: Any, names: list[str], rows: int) -> Iterator[Any]:
    """So many rows at once, or fewer.

    Of the row groups that it is asked for pyarrow keeps all that it has read until it has read all
    of them, so that only few are asked for at a time.
    """
    groups: list[int] = []
    there, last = 0, file.num_row_groups - 1
    for number in range(last + 1):
        groups.append(number)
        there += file.metadata.row_group(number).num_rows
        if there >= rows or number == last:
            for batch in file.iter_batches(batch_size=rows, row_groups=groups, columns=names):
                if batch.num_rows:
                    yield batch
            groups, there = [], 0


def _require_footer(path: Path) -> None:
    """Raise where a file says that what it says of itself is longer than any should."""
    with path.open("rb") as file:
        file.seek(max(path.stat().st_size - 8, 0))
        end = file.read(8)
    size = int.from_bytes(end[:4], "little")
    if end[4:] == b"PAR1" and size > FOOTER:
        raise InvalidInput(
            f"{path} must be a Parquet file with a footer of at most {FOOTER:,} bytes, got "
            f"{size:,}; write it with larger row groups, or again if it is damaged"
        )
