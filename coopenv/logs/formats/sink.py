"""Tables written piece by piece: CSV, NPZ, Parquet."""

import csv
import io
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.formats.chunks import Column


class Sink(Protocol):
    """Where a table goes, some rows at a time, every time the same columns."""

    def write(self, columns: Mapping[str, Column]) -> None:
        """Append rows."""
        ...

    def close(self) -> None:
        """Finish the file."""
        ...

    def abandon(self) -> None:
        """Let go of the file, which nobody wants any more."""
        ...


def open_sink(kind: str, path: Path) -> Sink:
    """A sink for the format ``.csv``, ``.npz`` or ``.parquet`` at ``path``, whatever its name."""
    return {".csv": CsvSink, ".npz": NpzSink, ".parquet": ParquetSink}[kind](path)


class CsvSink:
    """Numbers in the shortest form that reads back the same; NaN is an empty field."""

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
        """Append rows."""
        import pyarrow as pa

        if not self._begun:
            header = io.StringIO()
            csv.writer(header, lineterminator="\n").writerow(columns)
            self._file.write(header.getvalue().encode())
            self._begun = True
        arrays = [pa.array(values, from_pandas=True) for values in columns.values()]
        self._wait()
        self._pending = self._pool.submit(self._append, pa.table(arrays, names=list(columns)))

    def close(self) -> None:
        """Finish the file."""
        self._wait()
        self.abandon()

    def abandon(self) -> None:
        """Let go of the file."""
        self._pool.shutdown(cancel_futures=True)
        self._file.close()

    def _append(self, table: Any) -> None:
        self._file.write(_csv_text(table))

    def _wait(self) -> None:
        """Until the rows before are written; raises what went wrong with them."""
        if self._pending is not None:
            self._pending.result()
            self._pending = None


class ParquetSink:
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
        """Let go of the file."""
        self.close()


class NpzSink:
    """One array a column; numbers wait in temporary files, as an archive takes whole arrays."""

    def __init__(self, path: Path):
        self._path = path
        self._files: dict[str, IO[bytes]] = {}
        self._others: dict[str, list[Column]] = {}
        self._rows = 0

    def write(self, columns: Mapping[str, Column]) -> None:
        """Append rows."""
        for name, values in columns.items():
            known = name in self._files
            if not known and (name in self._others or values.dtype != np.float64):
                self._others.setdefault(name, []).append(values)
                continue
            # integers are read as float64 wherever some are missing, which may be the first rows
            values = values.astype(np.float64, copy=False)
            if not known:
                self._files[name] = tempfile.TemporaryFile(dir=self._path.parent)  # noqa: SIM115
            self._files[name].write(np.ascontiguousarray(values).data)
        self._rows += len(next(iter(columns.values())))

    def close(self) -> None:
        """Put the archive together."""
        form = {"descr": "<f8", "fortran_order": False, "shape": (self._rows,)}
        with zipfile.ZipFile(self._path, "w") as archive:
            for name, file in self._files.items():
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as entry:
                    np.lib.format.write_array_header_1_0(entry, form)
                    file.seek(0)
                    shutil.copyfileobj(file, entry, 1 << 20)
                file.close()
            for name, parts in self._others.items():
                with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as entry:
                    values = _plain(np.concatenate(parts))
                    np.lib.format.write_array(entry, values, allow_pickle=False)

    def abandon(self) -> None:
        """Let go of the temporary files."""
        for file in self._files.values():
            file.close()


def _csv_text(table: Any) -> bytes:
    """Rows as text, quoted only where it is needed."""
    import pyarrow as pa
    from pyarrow import csv as arrow

    for quoting in ("none", "needed"):
        out = pa.BufferOutputStream()
        try:
            options = arrow.WriteOptions(include_header=False, quoting_style=quoting)
            arrow.write_csv(table, out, options)
        except pa.ArrowInvalid:
            continue
        return out.getvalue().to_pybytes()
    raise InvalidInput("columns must be numbers and text to be written to CSV; write Parquet")


def _plain(values: Column) -> Column:
    """Text as an array that needs no pickle."""
    if values.dtype != object:
        return values
    return np.array(["" if value is None else str(value) for value in values])
