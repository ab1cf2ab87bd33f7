"""NPZ archives, one array a column or one a quantity: reading and writing them piece by piece.

NumPy alone does it; no extra is needed.
"""

import json
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST, effector_names
from coopenv.logs.formats.arrays import Array, Rows, archive_of
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

BLOCKS = ("force", "torque", "grips", "pose", "twist")
CARRIED = "biufUSmM"  # kinds of arrays that can be written to every table
MOST_TEXT = 1 << 30  # [bytes] of a column in an archive
POSE = {3: (*POSITION[2], *ORIENTATION[2]), 7: (*POSITION[3], *ORIENTATION[3])}


class NpzSource(Source):
    """Arrays ``(T,)`` under the names of columns, or arrays of several columns.

    ``force (T, n, 2 or 3)``, ``torque (T, n)`` or ``(T, n, 3)``, ``grips (n, 2 or 3)`` or
    ``(T, n, 2 or 3)``, ``pose (T, 3 or 7)``, ``twist (T, 3 or 6)`` have their columns in the order
    of the documented names.
    """

    def __init__(self, path: Path, decimal: str, limits: Limits):
        self._path, self._limits = path, limits
        try:
            with archive_of(path, limits) as archive:
                self._arrays = {
                    entry.filename.removesuffix(".npy"): Array(archive, entry)
                    for entry in archive.infolist()
                    if entry.filename.endswith(".npy")
                }
                self._columns: dict[str, tuple[str, tuple[int, ...]]] = {}
                self.grips = self._constant_grips(archive)
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            if isinstance(error, InvalidInput):
                raise
            raise InvalidInput(
                f"{path} must be an NPZ file of plain arrays, got {shown(error, 200)}; write it "
                "with numpy.savez"
            ) from error
        self._rows = self._length()
        limits.require("rows", self._rows, f"{path}", "cut it")
        for name, array in self._arrays.items():
            self._add(name, array)
        self.columns = list(self._columns)
        taken = {name for name, _ in self._columns.values()}
        self.left_out = [name for name in self._arrays if name not in taken and name != "grips"]

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read all arrays side by side."""
        for name in numbers:
            self._require_numbers(self._columns[name][0])
        wanted = list(dict.fromkeys(self._columns[name][0] for name in (*numbers, *carried)))
        row_bytes = self._row_bytes(wanted)
        most = rows_at_once(CHUNK_ROWS, row_bytes)
        with archive_of(self._path, self._limits) as archive, ExitStack() as stack:
            files = {name: self._arrays[name].open(archive, stack) for name in wanted}
            for first in range(0, self._rows, most):
                rows = min(most, self._rows - first)
                read = self._read(files, rows)
                pick = {
                    name: read[self._columns[name][0]][(slice(None), *self._columns[name][1])]
                    for name in (*numbers, *carried)
                }
                yield Chunk(
                    numbers={name: pick[name].astype(np.float64) for name in numbers},
                    carried={name: plain(self._text(pick[name], name)) for name in carried},
                    rows=rows,
                    first_row=first + 1,
                    progress=(first + rows) / self._rows,
                )

    def _row_bytes(self, wanted: Sequence[str]) -> int:
        """Of these arrays side by side; raises where that is, or one of them asks for, too much."""
        require, whole = self._limits.require, 0
        for name in wanted:
            array = self._arrays[name]
            if array.fortran:
                whole += array.size
                place = f"{self._path}, array {name!r} in Fortran order"
                require("block_bytes", whole, place, "save it in C order")
        row_bytes = sum(self._arrays[name].row_bytes for name in wanted)
        require("row_bytes", row_bytes, f"{self._path}", "leave out what is not needed")
        return row_bytes

    def _read(self, files: dict[str, Rows], rows: int) -> dict[str, npt.NDArray[Any]]:
        """The next rows of some arrays."""
        try:
            return {name: file.read(rows) for name, file in files.items()}
        except InvalidInput as error:
            raise InvalidInput(f"{self._path}: {error}") from error

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

    def _require_numbers(self, name: str) -> None:
        kind = self._arrays[name].dtype
        if kind.kind not in "fiu":
            raise InvalidInput(
                f"{self._path}, array {name!r} must hold numbers, got {kind}; convert it"
            )

    def _constant_grips(self, archive: zipfile.ZipFile) -> FloatArray | None:
        array = self._arrays.get("grips")
        if array is None or len(array.shape) != 2:
            return None
        self._require_numbers("grips")
        self._require_few("grips", array.shape[0])
        self._row_bytes(["grips"])
        with ExitStack() as stack:
            rows = {"grips": array.open(archive, stack)}
            return self._read(rows, array.shape[0])["grips"].astype(np.float64)

    def _require_few(self, name: str, effectors: int) -> None:
        place = f"{self._path}, array {name!r}"
        self._limits.require("effectors", effectors, place, "leave some out")

    def _length(self) -> int:
        """Number of rows: that of the forces, which every recording has."""
        for name in ("force", "f1x", "time"):
            if name in self._arrays and self._arrays[name].shape:
                return self._arrays[name].shape[0]
        lengths = [array.shape[0] for array in self._arrays.values() if array.shape]
        return max(lengths, default=0)

    def _add(self, name: str, array: Array) -> None:
        """Enter the columns that an array holds."""
        if (name == "grips" and self.grips is not None) or array.dtype.kind not in CARRIED:
            return
        if name in BLOCKS and len(array.shape) > 1:
            if name not in ("pose", "twist"):
                self._require_few(name, array.shape[1])
            columns = _block_columns(name, array.shape[1:])
            if columns is None:
                raise InvalidInput(
                    f"{self._path}, array {name!r} must be of a documented shape, got "
                    f"{array.shape}; see docs/recordings.md"
                )
        elif len(array.shape) == 1 and (array.shape[0] == self._rows or name in ("f1x", "time")):
            columns = {name: ()}
        else:
            return
        if array.shape[0] != self._rows:
            raise InvalidInput(
                f"{self._path}, array {name!r} must be as long as the others, {self._rows} rows, "
                f"got {array.shape[0]}; cut or fill it"
            )
        for column, index in columns.items():
            if column in self._columns:
                raise InvalidInput(
                    f"{self._path}: {column} must be there once, got it in {name!r} and "
                    f"{self._columns[column][0]!r}; leave one out"
                )
            self._columns[column] = (name, index)
        remedy = "leave out what is not needed"
        self._limits.require("columns", len(self._columns), f"{self._path}", remedy)


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


def _block_columns(name: str, shape: tuple[int, ...]) -> dict[str, tuple[int, ...]] | None:
    """Documented columns of an array of that shape beyond its rows, and where they are in it."""
    if name in ("pose", "twist"):
        known = POSE if name == "pose" else {len(names): names for names in TWIST.values()}
        names = known.get(shape[0]) if len(shape) == 1 else None
        return None if names is None else {each: (j,) for j, each in enumerate(names)}
    kind = {"force": "f", "torque": "t", "grips": "r"}[name]
    if name == "torque" and len(shape) == 1:
        return {each: (i,) for i, (each,) in enumerate(effector_names(kind, shape[0], 2))}
    if len(shape) != 2 or shape[1] not in ((3,) if name == "torque" else (2, 3)):
        return None
    groups = effector_names(kind, *shape)
    return {each: (i, j) for i, group in enumerate(groups) for j, each in enumerate(group)}


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
