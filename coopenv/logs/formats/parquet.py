"""Parquet, read by pyarrow in batches."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Column, row_number, value_of


class ParquetSource:
    """A Parquet file with one value a row and column."""

    def __init__(self, path: Path):
        try:
            import pyarrow.parquet as parquet
            from pyarrow import ArrowInvalid
        except ImportError as error:
            raise MissingExtra("reading Parquet", "analysis") from error
        self.grips: FloatArray | None = None
        self._path = path
        try:
            with parquet.ParquetFile(path) as file:
                schema = file.schema_arrow
        except ArrowInvalid as error:
            raise InvalidInput(f"{path} must be a Parquet file, got {error}; convert it") from error
        nested = _nested()
        self.columns = [entry.name for entry in schema if not nested(entry.type)]
        self.left_out = [entry.name for entry in schema if nested(entry.type)]
        self._types = {entry.name: entry.type for entry in schema}

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read batch by batch; what is carried keeps its type."""
        import pyarrow.parquet as parquet
        from pyarrow import types

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
                values = {
                    name: batch[name].cast("float64", safe=False).to_numpy(zero_copy_only=False)
                    for name in numbers
                }
                yield Chunk(
                    numbers=values,
                    carried={name: _as_numpy(batch[name]) for name in carried},
                    rows=batch.num_rows,
                    first_row=row,
                    progress=(row - 1 + batch.num_rows) / total,
                    place=row_number(row),
                    text=value_of(values),
                )
                row += batch.num_rows


def _nested():
    from pyarrow import types

    return types.is_nested


def _as_numpy(column) -> Column:
    from pyarrow import types

    if types.is_dictionary(column.type):
        column = column.dictionary_decode()
    return np.asarray(column.to_numpy(zero_copy_only=False))
