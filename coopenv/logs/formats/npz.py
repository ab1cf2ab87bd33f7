"""NPZ archives, one array a column or one a quantity: reading and writing them piece by piece.

NumPy alone does it; no extra is needed.
"""

import shutil
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.columns import ORIENTATION, POSITION, TWIST, effector_names
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Column, Sink, Source

BLOCKS = ("force", "torque", "grips", "pose", "twist")
POSE = {3: (*POSITION[2], *ORIENTATION[2]), 7: (*POSITION[3], *ORIENTATION[3])}


class NpzSource(Source):
    """Arrays ``(T,)`` under the names of columns, or arrays of several columns.

    ``force (T, n, 2 or 3)``, ``torque (T, n)`` or ``(T, n, 3)``, ``grips (n, 2 or 3)`` or
    ``(T, n, 2 or 3)``, ``pose (T, 3 or 7)``, ``twist (T, 3 or 6)`` have their columns in the order
    of the documented names.
    """

    def __init__(self, path: Path, decimal: str):
        self._path = path
        try:
            with zipfile.ZipFile(path) as archive:
                self._arrays = {
                    entry.removesuffix(".npy"): _Array(archive, entry)
                    for entry in archive.namelist()
                    if entry.endswith(".npy")
                }
                self._columns: dict[str, tuple[str, tuple[int, ...]]] = {}
                self.grips = self._constant_grips(archive)
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            if isinstance(error, InvalidInput):
                raise
            raise InvalidInput(
                f"{path} must be an NPZ file of plain arrays, got {error}; write it with "
                "numpy.savez"
            ) from error
        self._rows = self._length()
        for name, array in self._arrays.items():
            self._add(name, array)
        self.columns = list(self._columns)
        taken = {name for name, _ in self._columns.values()}
        self.left_out = [name for name in self._arrays if name not in taken and name != "grips"]

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read all arrays side by side."""
        for name in numbers:
            self._require_numbers(self._columns[name][0])
        wanted = dict.fromkeys(self._columns[name][0] for name in (*numbers, *carried))
        with zipfile.ZipFile(self._path) as archive, ExitStack() as stack:
            files = {name: self._arrays[name].open(archive, stack) for name in wanted}
            for first in range(0, self._rows, CHUNK_ROWS):
                rows = min(CHUNK_ROWS, self._rows - first)
                read = self._read(files, rows)
                pick = {
                    name: read[self._columns[name][0]][(slice(None), *self._columns[name][1])]
                    for name in (*numbers, *carried)
                }
                yield Chunk(
                    numbers={name: pick[name].astype(np.float64) for name in numbers},
                    carried={name: pick[name] for name in carried},
                    rows=rows,
                    first_row=first + 1,
                    progress=(first + rows) / self._rows,
                )

    def _read(self, files: dict[str, "_Rows"], rows: int) -> dict[str, npt.NDArray[Any]]:
        """The next rows of some arrays."""
        try:
            return {name: file.read(rows) for name, file in files.items()}
        except InvalidInput as error:
            raise InvalidInput(f"{self._path}: {error}") from error

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
        with ExitStack() as stack:
            rows = {"grips": array.open(archive, stack)}
            return self._read(rows, array.shape[0])["grips"].astype(np.float64)

    def _length(self) -> int:
        """Number of rows: that of the forces, which every recording has."""
        for name in ("force", "f1x", "time"):
            if name in self._arrays and self._arrays[name].shape:
                return self._arrays[name].shape[0]
        lengths = [array.shape[0] for array in self._arrays.values() if array.shape]
        return max(lengths, default=0)

    def _add(self, name: str, array: "_Array") -> None:
        """Enter the columns that an array holds."""
        if name == "grips" and self.grips is not None:
            return
        if name in BLOCKS and len(array.shape) > 1:
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


class NpzSink(Sink):
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


class _Array:
    """An array in the archive, of which rows are read one after the other."""

    def __init__(self, archive: zipfile.ZipFile, entry: str):
        self._entry = entry
        with archive.open(entry) as file:
            self.shape, self._fortran, self.dtype = _header(file)
        if self.dtype.hasobject:
            raise ValueError(f"array {entry!r} of Python objects")

    def open(self, archive: zipfile.ZipFile, stack: ExitStack) -> "_Rows":
        """Ready to read its first row."""
        file = stack.enter_context(archive.open(self._entry))
        if self._fortran and len(self.shape) > 1:  # its rows are scattered: all of it, then
            return _Rows(None, self.dtype, np.lib.format.read_array(file))
        _header(file)
        return _Rows(file, self.dtype, np.empty((0, *self.shape[1:])))


class _Rows:
    """What is left to read of an array."""

    def __init__(self, file: IO[bytes] | None, dtype: np.dtype, whole: npt.NDArray[Any]):
        self._file, self._dtype, self._whole = file, dtype, whole
        self._at = 0

    def read(self, rows: int) -> npt.NDArray[Any]:
        """The next rows."""
        if self._file is None:
            self._at += rows
            return self._whole[self._at - rows : self._at]
        shape = (rows, *self._whole.shape[1:])
        size = int(np.prod(shape)) * self._dtype.itemsize
        try:
            data = self._file.read(size)
        except (OSError, zipfile.BadZipFile, zlib.error) as error:
            raise InvalidInput(
                f"arrays must be whole, got {error}; write the file again"
            ) from error
        if len(data) < size:
            raise InvalidInput(
                "arrays must be whole, got one that ends early; write the file again"
            )
        return np.frombuffer(data, self._dtype).reshape(shape)


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype]:
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0
    return (read if version[0] == 1 else np.lib.format.read_array_header_2_0)(file)


def _plain(values: Column) -> Column:
    """Text as an array that needs no pickle."""
    if values.dtype != object:
        return values
    return np.array(["" if value is None else str(value) for value in values])
