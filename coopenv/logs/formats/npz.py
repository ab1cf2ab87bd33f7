"""NPZ archives, one array a column or one a quantity: reading and writing them piece by piece.

NumPy alone does it; no extra is needed.
"""

import json
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.formats.arrays import Array, archive_of
from coopenv.logs.formats.chunks import Column, Sink
from coopenv.logs.formats.named import ArraySource, Read
from coopenv.logs.limits import Limits, shown

MOST_TEXT = 1 << 30  # [bytes] of a column in an archive


class NpzSource(ArraySource):
    """Arrays of an archive."""

    def __init__(self, path: Path, dialect: Dialect, limits: Limits):
        try:
            with archive_of(path, limits) as archive:
                self._files = {
                    entry.filename.removesuffix(".npy"): Array(archive, entry)
                    for entry in archive.infolist()
                    if entry.filename.endswith(".npy")
                }
                super().__init__(path, limits, self._files)
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            if isinstance(error, InvalidInput):
                raise
            raise InvalidInput(
                f"{path} must be an NPZ file of plain arrays, got {shown(error, 200)}; write it "
                "with numpy.savez"
            ) from error

    @contextmanager
    def _reader(self, wanted: Sequence[str]) -> Iterator[Read]:
        with archive_of(self._path, self._limits) as archive, ExitStack() as stack:
            files = {name: self._files[name].open(archive, stack) for name in wanted}

            def read(name: str, first: int, rows: int) -> npt.NDArray[Any]:
                try:
                    return files[name].read(rows)
                except InvalidInput as error:
                    raise InvalidInput(f"{self._path}: {error}") from error

            yield read

    def row_bytes(self, wanted: Sequence[str]) -> int:
        """See `ArraySource`; an array in Fortran order is read whole."""
        whole = 0
        for name in wanted:
            array = self._files[name]
            if array.fortran:
                whole += array.size
                place = f"{self._path}, array {name!r} in Fortran order"
                self._limits.require("block_bytes", whole, place, "save it in C order")
        return super().row_bytes(wanted)

    def _text(self, values: Column, name: str) -> Column:
        """The same, if it holds no code that is no character."""
        if values.dtype.kind == "U" and values.dtype.itemsize:
            code = np.ascontiguousarray(values).view(f"{values.dtype.byteorder}u4")
            if ((code > sys.maxunicode) | ((code >= 0xD800) & (code < 0xE000))).any():
                raise InvalidInput(
                    f"{self._path}, array {name!r} must hold text, got codes that are no "
                    "characters; write the file again"
                )
        return values


class NpzSink(Sink):
    """One array a column; numbers wait in temporary files, as an archive takes whole arrays."""

    def __init__(self, path: Path):
        self._path = path
        self._files: dict[str, IO[bytes]] = {}
        self._others: dict[str, list[Column]] = {}
        self._rows = 0
        self._done = ""

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
                self._files[name] = self._beside()
            self._files[name].write(np.ascontiguousarray(values).data)
        self._rows += len(next(iter(columns.values())))

    def _beside(self) -> IO[bytes]:
        """An open file that goes with the process.

        Where the system makes none without a name, it has one for a moment: as that of the archive
        begins, so that a sweep finds it.
        """
        return tempfile.TemporaryFile(dir=self._path.parent, prefix=f"{self._path.name}.")

    def describe(self, done: Sequence[str]) -> None:
        """Corrections as an array ``corrections`` of no dimension, a JSON list of sentences."""
        self._done = json.dumps(list(done), ensure_ascii=False)

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
                    values = _plain(np.concatenate(parts), name)
                    np.lib.format.write_array(entry, values, allow_pickle=False)
            if self._done and not {"corrections"} & {*self._files, *self._others}:
                with archive.open(zipfile.ZipInfo("corrections.npy"), "w") as entry:
                    np.lib.format.write_array(entry, np.array(self._done), allow_pickle=False)

    def abandon(self) -> None:
        """Release the temporary files."""
        for file in self._files.values():
            file.close()


def _plain(values: Column, name: str) -> Column:
    """Text as an array that needs no pickle, in which every one has the room of the longest."""
    if values.dtype != object:
        return values
    texts = ["" if value is None else str(value) for value in values]
    size = 4 * len(texts) * max(map(len, texts), default=0)
    if size > MOST_TEXT:
        raise InvalidInput(
            f"column {name!r} must need at most {MOST_TEXT:,} bytes where each text has the room "
            f"of the longest, got {size:,}; write CSV or Parquet, or leave it out"
        )
    return np.array(texts)
