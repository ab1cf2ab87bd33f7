"""Arrays of an NPZ archive, read row by row; what they say of their size is checked before.

No more is read at once than a row or a list of contents may have, whatever an archive claims or
inflates to. Nothing is unpickled.
"""

import io
import math
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput
from coopenv.logs.limits import Limits, shown

DIRECTORY = 32 << 20  # [bytes] of an archive's list of contents
HEADER = 12 + 10_000  # [bytes] of an array; NumPy takes no longer one


@contextmanager
def archive_of(path: Path, limits: Limits) -> Iterator[zipfile.ZipFile]:
    """The archive of that name, open for reading, if its list of contents is not too long."""
    with _Careful(io.FileIO(path)) as file, zipfile.ZipFile(file) as archive:
        file.most = None
        remedy = "leave out what is not needed"
        limits.require("columns", len(archive.infolist()), f"{path}", remedy)
        yield archive


class Array:
    """An array in an archive, of which rows are read one after the other.

    Raises
    ------
    ValueError
        If it is not as NumPy writes them, of Python objects, or shorter than its header says.
    """

    def __init__(self, archive: zipfile.ZipFile, entry: zipfile.ZipInfo):
        self._entry = entry
        called = f"array {shown(entry.filename)!r}"
        if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError(f"{called}, compressed otherwise than NumPy does")
        with archive.open(entry) as file:
            self.shape, self.fortran, self.dtype, self._start = _header(file.read(HEADER), called)
        if self.dtype.hasobject:
            raise ValueError(f"{called} of Python objects")
        if any(length < 0 for length in self.shape):
            raise ValueError(f"{called} of shape {self.shape}")
        if self.dtype.itemsize == 0:
            raise ValueError(f"{called} of elements without size")
        self.size = math.prod(self.shape) * self.dtype.itemsize  # [bytes]
        there = entry.file_size - self._start
        if self.size > there:
            raise ValueError(f"{called} of {there:,} bytes that says it has {self.size:,}")
        self.fortran &= len(self.shape) > 1

    @property
    def row_bytes(self) -> int:
        """Of a row, as it is read."""
        return math.prod(self.shape[1:]) * self.dtype.itemsize

    def open(self, archive: zipfile.ZipFile, stack: ExitStack) -> "Rows":
        """Ready to read its first row; an array in Fortran order is read at once."""
        file = stack.enter_context(archive.open(self._entry))
        file.read(self._start)
        if not self.fortran:
            return Rows(file, self.dtype, np.empty((0, *self.shape[1:])))
        whole = np.frombuffer(_read(file, self.size), self.dtype)
        return Rows(None, self.dtype, whole.reshape(self.shape[::-1]).T)  # its rows are scattered


class Rows:
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
        data = _read(self._file, math.prod(shape) * self._dtype.itemsize)
        return np.frombuffer(data, self._dtype).reshape(shape)


class _Careful(io.BufferedReader):
    """A file from which no more than ``most`` bytes are read at once.

    ``zipfile`` reads a list of contents as long as the file says it is.
    """

    most: int | None = DIRECTORY

    def read(self, size: int | None = -1, /) -> bytes:
        if self.most is not None and size is not None and size > self.most:
            raise ValueError(f"a list of contents of {size:,} bytes")
        return super().read(size)


def _read(file: IO[bytes], size: int) -> bytes:
    """So many bytes, or an error of ours."""
    try:
        data = file.read(size)
    except (OSError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InvalidInput(f"arrays must be whole, got {error}; write the file again") from error
    if len(data) < size:
        raise InvalidInput("arrays must be whole, got one that ends early; write the file again")
    return data


def _header(begin: bytes, called: str) -> tuple[tuple[int, ...], bool, np.dtype, int]:
    """Shape, whether in Fortran order, type of the elements, and how long the header is."""
    file = io.BytesIO(begin)
    try:
        version = np.lib.format.read_magic(file)
        older = np.lib.format.read_array_header_1_0
        shape, fortran, dtype = (older if version[0] == 1 else np.lib.format.read_array_header_2_0)(
            file
        )
    except (MemoryError, RecursionError, TypeError, SyntaxError) as error:  # deep nesting, others
        raise ValueError(f"{called} whose header is none: {shown(error)}") from error
    return shape, fortran, dtype, file.tell()
