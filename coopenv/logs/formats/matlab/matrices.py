"""MATLAB files: of version 7.3 through HDF5, older ones through SciPy, which reads them whole.

MATLAB knows no vectors: a matrix of one row or one column is a column here, and one that has a
column a sample, rather than a row, is turned.
"""

import math
import warnings
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.formats.chunks import Source
from coopenv.logs.formats.damage import parsing
from coopenv.logs.formats.hdf5 import data_sets, opened
from coopenv.logs.formats.matlab.elements import Elements
from coopenv.logs.formats.named import BLOCKS, ArraySource, Read
from coopenv.logs.limits import Limits, shown

HEADER = 128  # [bytes] of version 5
COMPRESSED = 15  # kind of an element
PIECE = 1 << 20  # [bytes] inflated at once
DEEPEST = 8  # structures within one another


class MatSource(Source):
    """A MATLAB file of any version; structures have their fields' names after a point.

    Parameters
    ----------
    path, dialect, limits
        See `Source`.
    part
        A structure: then of its fields alone.
    """

    def __new__(cls, path: Path, dialect: Dialect, limits: Limits, part: str = "") -> "MatSource":
        """The source of the file's version."""
        if cls is not MatSource:
            return super().__new__(cls)
        with path.open("rb") as file:
            begin = file.read(HEADER)
        version = _Hdf5Matrices if begin.startswith(b"MATLAB 7.3") else _Matrices
        return version(path, dialect, limits, part)


class _MatrixSource(ArraySource, MatSource):
    """Matrices, rows first whichever way they lie."""

    def _shape(self, name: str) -> tuple[int, ...]:
        shape = self._arrays[name].shape
        if len(shape) != 2 or (name == "grips" and self._rows not in shape):
            return shape
        if self._is_turned(name):
            shape = shape[::-1]
        return shape[:1] if shape[1] == 1 and name not in BLOCKS else shape

    def _is_turned(self, name: str) -> bool:
        """Whether it has a column a sample."""
        shape = self._arrays[name].shape
        return len(shape) == 2 and shape[0] != self._rows and shape[1] == self._rows

    def _oriented(self, name: str, read: Read, first: int, rows: int) -> npt.NDArray[Any]:
        return read(name, first, rows).reshape(rows, *self._shape(name)[1:])

    def _longest(self, names: Iterable[str]) -> int:
        shapes = [self._arrays[name].shape for name in names]
        vectors = [max(shape) for shape in shapes if len(shape) == 2 and min(shape) == 1]
        others = [max(shape) if len(shape) == 2 else shape[0] for shape in shapes if shape]
        return max(vectors or others, default=0)


class _Hdf5Matrices(_MatrixSource):
    """Those of version 7.3, whose axes HDF5 has the other way round."""

    def __init__(self, path: Path, dialect: Dialect, limits: Limits, part: str = ""):
        sets = data_sets(path, limits, part.replace(".", "/"))
        self._sets = {
            name.replace("/", "."): each for name, each in sets.items() if not name.startswith("#")
        }
        turned = {name: _Turned(each.shape[::-1], each.dtype) for name, each in self._sets.items()}
        ArraySource.__init__(self, path, limits, turned)

    @contextmanager
    def _reader(self, wanted: Sequence[str]) -> Iterator[Read]:
        sets = {name: self._sets[name] for name in wanted}
        with opened(self._path, list(sets.values()), self._limits) as file:

            def read(name: str, first: int, rows: int) -> npt.NDArray[Any]:
                places = slice(first, first + rows)
                if self._is_turned(name):
                    return sets[name].read(file, places)
                return sets[name].read(file, (..., places)).T

            yield read


class _Turned:
    """A data set as MATLAB sees it."""

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype):
        self.shape, self.dtype = shape, dtype


class _Matrices(_MatrixSource):
    """Those of version 4 to 7, which are read whole."""

    def __init__(self, path: Path, dialect: Dialect, limits: Limits, part: str = ""):
        self._whole = _loaded(path, limits, part)
        ArraySource.__init__(self, path, limits, self._whole)

    @contextmanager
    def _reader(self, wanted: Sequence[str]) -> Iterator[Read]:
        def read(name: str, first: int, rows: int) -> npt.NDArray[Any]:
            whole, places = self._whole[name], slice(first, first + rows)
            return whole[:, places].T if self._is_turned(name) else whole[places]

        yield read


def _loaded(path: Path, limits: Limits, part: str) -> dict[str, npt.NDArray[Any]]:
    """Arrays of a file, or of a structure of it, by their names."""
    from scipy.io import loadmat, whosmat

    remedy = "save it with -v7.3, or in parts"
    inflated = _inflated(path, limits, remedy)
    with parsing(path, "a MATLAB file", "save it again"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of variables that are there twice
        claimed = 0
        for name, shape, kind in whosmat(path):
            claimed += 8 * math.prod(shape)
            if math.prod(shape) > inflated:
                raise InvalidInput(
                    f"{path}, variable {shown(name)!r} must be as large as it says, {shape} of "
                    f"{kind}, got {inflated:,} bytes in all; save it again"
                )
        limits.require("block_bytes", claimed, f"{path}", remedy)
        content = loadmat(path)
    found = dict(_walk({k: v for k, v in content.items() if not k.startswith("__")}, ""))
    limits.require("columns", len(found), f"{path}", "leave out what is not needed")
    if not part:
        return found
    fields = {name[len(part) + 1 :]: v for name, v in found.items() if name.startswith(f"{part}.")}
    if not fields:
        raise InvalidInput(
            f"{path}: part must be one of its structures, got {shown(part)!r}; has: "
            f"{', '.join(shown(each) for each in list(found)[:20])}"
        )
    return fields


def _walk(
    content: dict[str, Any], prefix: str, depth: int = 0
) -> Iterator[tuple[str, npt.NDArray[Any]]]:
    """Arrays of variables and of the structures among them."""
    for name, value in content.items():
        if not isinstance(value, np.ndarray):  # sparse, or a function
            continue
        if value.dtype.names is not None and value.size == 1 and depth < DEEPEST:
            record = value.reshape(-1)[0]
            fields = {field: record[field] for field in value.dtype.names}
            yield from _walk(fields, f"{prefix}{name}.", depth + 1)
        else:
            yield f"{prefix}{name}", value


def _inflated(path: Path, limits: Limits, remedy: str) -> int:
    """How large the content of a file is once it is inflated [bytes]; raises at the limit."""
    size = path.stat().st_size
    limits.require("block_bytes", size, f"{path}", remedy)
    total, at = 0, HEADER
    with path.open("rb") as file:
        head = file.read(HEADER)
        orders: dict[bytes, Literal["little", "big"]] = {b"IM": "little", b"MI": "big"}
        order = orders.get(head[126:128])
        if order is None:  # version 4 is not compressed
            return size
        while at + 8 <= size:
            file.seek(at)
            tag = file.read(8)
            kind = int.from_bytes(tag[:4], order)
            length = int.from_bytes(tag[4:], order)
            held = min(length, size - at - 8)  # whatever it claims
            if kind == COMPRESSED:
                whole = _inflation(file.read(held), limits.block_bytes - total)
                total += 8 + len(whole)
            else:
                file.seek(at)
                whole = file.read(8 + held)
                total += 8 + length
            limits.require("block_bytes", total, f"{path}", remedy)
            _require_elements(path, whole, order, at)
            at += 8 + length
    return total


def _require_elements(path: Path, data: bytes, order: Literal["little", "big"], place: int) -> None:
    """Raise where SciPy could not go through what a variable is made of."""
    try:
        Elements(data, order).require_matrix()
    except ValueError as error:
        raise InvalidInput(
            f"{path}, variable at byte {place} must be whole and of elements that MATLAB has, got "
            f"{error}; save it again"
        ) from None


def _inflation(data: bytes, most: int) -> bytes:
    """What compressed data inflates to, as far as a limit; where it is damaged, until there."""
    inflate, made, size = zlib.decompressobj(), [], 0
    try:
        while data and size <= most:
            made.append(inflate.decompress(data, PIECE))
            size += len(made[-1])
            data = inflate.unconsumed_tail
    except zlib.error:
        pass
    return b"".join(made)
