"""Parquet tables: reading and writing them in batches with pyarrow."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Column, Sink, Source


class ParquetSource(Source):
    """A Parquet file with one value a row and column."""

    def __init__(self, path: Path, decimal: str):
        try:
            from pyarrow import ArrowInvalid, parquet, types
        except ImportError as error:
            raise MissingExtra("reading Parquet", "analysis") from error
        self._path = path
        try:
            with parquet.ParquetFile(path) as file:
                schema = file.schema_arrow
        except ArrowInvalid as error:
            raise InvalidInput(f"{path} must be a Parquet file, got {error}; convert it") from error
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
        with parquet.ParquetFile(self._path) as file:
            total = max(file.metadata.num_rows, 1)
            names = [*numbers, *carried]
            for batch in file.iter_batches(batch_size=CHUNK_ROWS, columns=names):
                yield Chunk(
                    numbers={
                        name: batch[name].cast("float64", safe=False).to_numpy(zero_copy_only=False)
                        for name in numbers
                    },
                    carried={name: _as_numpy(batch[name]) for name in carried},
                    rows=batch.num_rows,
                    first_row=row,
                    progress=(row - 1 + batch.num_rows) / total,
                )
                row += batch.num_rows


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

    def close(self) -> None:
        """Finish the file."""
        if self._writer is not None:
            self._writer.close()

    def abandon(self) -> None:
        """Release the file."""
        self.close()


def _as_numpy(column) -> Column:
    from pyarrow import types

    if types.is_dictionary(column.type):
        column = column.dictionary_decode()
    return np.asarray(column.to_numpy(zero_copy_only=False))
