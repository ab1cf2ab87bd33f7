"""Parquet tables: reading and writing them in batches with pyarrow."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.formats.chunks import (
    CHUNK_ROWS,
    Chunk,
    Column,
    Sink,
    Source,
    plain,
    rows_at_once,
)
from coopenv.logs.limits import Limits, shown

FOOTER = 64 << 20  # [bytes] of what a file says of itself at its end
READ = 1 << 20  # [bytes] of a column at once


class ParquetSource(Source):
    """A Parquet file with one value a row and column."""

    def __init__(self, path: Path, decimal: str, limits: Limits):
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

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read batch by batch; what is carried keeps its type."""
        from pyarrow import parquet, types

        for name in numbers:
            kind = self._types[name]
            if not (types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind)):
                raise InvalidInput(
                    f"{self._path}, column {name!r} must hold numbers, got {kind}; convert it"
                )
        row = 1
        texts = [name for name in carried if _is_text(self._types[name])]
        with (
            _parsing(self._path),
            parquet.ParquetFile(self._path, buffer_size=READ, read_dictionary=texts) as file,
        ):
            total = max(file.metadata.num_rows, 1)
            for batch in self._batches(file, [*numbers, *carried]):
                yield Chunk(
                    numbers={
                        name: batch[name].cast("float64", safe=False).to_numpy(zero_copy_only=False)
                        for name in numbers
                    },
                    carried={name: plain(_as_numpy(batch[name])) for name in carried},
                    rows=batch.num_rows,
                    first_row=row,
                    progress=(row - 1 + batch.num_rows) / total,
                )
                row += batch.num_rows

    def _batches(self, file: Any, names: list[str]) -> Iterator[Any]:
        """Rows as pyarrow reads them, in parts where they hold much text."""
        first = 1
        for batch in file.iter_batches(
            batch_size=rows_at_once(CHUNK_ROWS, 8 * len(names)), columns=names
        ):
            if not batch.num_rows:
                continue
            size = sum(_text_bytes(column) for column in batch.columns)  # of each row
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


def _is_text(kind: Any) -> bool:
    from pyarrow import types

    return types.is_string(kind) or types.is_binary(kind)


def _text_bytes(column: Any) -> Any:
    """How long the text of each row ``(T,)`` is [bytes]; 0 where there is none."""
    from pyarrow import compute, types

    listed = types.is_dictionary(column.type)
    texts = column.dictionary if listed else column
    if not (_is_text(texts.type) or _is_large(texts.type)):
        return 0
    length = compute.call_function("binary_length", [texts])
    if listed:
        length = compute.take(length, column.indices)
    return compute.fill_null(length, 0).to_numpy(zero_copy_only=False)


def _is_large(kind: Any) -> bool:
    from pyarrow import types

    return types.is_large_string(kind) or types.is_large_binary(kind)


def _as_numpy(column: Any) -> Column:
    """A column as an array; a text that many rows have is one object."""
    from pyarrow import types

    if not types.is_dictionary(column.type):
        return np.asarray(column.to_numpy(zero_copy_only=False))
    if not _is_text(column.type.value_type):
        return np.asarray(column.dictionary_decode().to_numpy(zero_copy_only=False))
    texts = np.array([*column.dictionary.to_pylist(), None], dtype=object)
    places = column.indices.fill_null(len(texts) - 1)  # the last is none
    return texts[places.to_numpy(zero_copy_only=False)]
