"""HDF5 files: data sets as arrays, read in slices; and MATLAB files of version 7.3, which are HDF5.

Links to other files are not followed, and what is stored in other files is left out.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.formats.named import ArraySource, Read
from coopenv.logs.limits import Limits, shown

if TYPE_CHECKING:
    import h5py

DEEPEST = 16  # groups within one another


@dataclass(frozen=True, slots=True)
class DataSet:
    """A data set of a file, or a field of one."""

    path: str
    field: str  # none if empty
    shape: tuple[int, ...]
    dtype: np.dtype
    piece: int  # [bytes] that are inflated at once, whatever is read of them

    def read(self, file: "h5py.File", places: Any) -> npt.NDArray[Any]:
        """Some of it."""
        found: Any = file[self.path]
        return np.asarray(found.fields(self.field)[places] if self.field else found[places])


class Hdf5Source(ArraySource):
    """Data sets by their paths: ``left/force`` is an array, ``left/force:0`` a column of it.

    Fields of compound data sets are called as if they were in a group of that name.

    Parameters
    ----------
    path, dialect, limits
        See `Source`.
    part
        A group: then of its data sets alone, by their paths in it.
    """

    def __init__(self, path: Path, dialect: Dialect, limits: Limits, part: str = ""):
        self._sets = data_sets(path, limits, part)
        super().__init__(path, limits, self._sets)

    @contextmanager
    def _reader(self, wanted: Sequence[str]) -> Iterator[Read]:
        sets = {name: self._sets[name] for name in wanted}
        with opened(self._path, list(sets.values()), self._limits) as file:
            yield lambda name, first, rows: sets[name].read(file, slice(first, first + rows))


def data_sets(path: Path, limits: Limits, part: str = "") -> dict[str, DataSet]:
    """All data sets of a file, or of a group of it, by their paths.

    Raises
    ------
    InvalidInput
        If it is no HDF5 file, has no such group, or more data sets than the limit.
    """
    found: dict[str, DataSet] = {}
    with opened(path, [], limits) as file:
        group = _group(path, file, part)
        for name, each in _walk(group, ""):
            for field, shape, dtype in _arrays(each):
                called = f"{name}/{field}" if field else name
                chunk = math.prod(each.chunks or ()) * each.dtype.itemsize if each.chunks else 0
                found[called] = DataSet(str(each.name), field, shape, dtype, chunk)
            limits.require("columns", len(found), f"{path}", "leave out what is not needed")
    return found


@contextmanager
def opened(path: Path, sets: Sequence[DataSet], limits: Limits) -> "Iterator[h5py.File]":
    """The file, with room for the pieces of these data sets, which stay until they are used up."""
    try:
        import h5py
    except ImportError as error:
        raise MissingExtra("reading HDF5", "formats") from error
    pieces = sum(each.piece for each in sets)
    limits.require("block_bytes", pieces, f"{path}", "write its data sets in smaller chunks")
    room = max([1 << 20, *(each.piece for each in sets)])  # [bytes] a data set
    if not h5py.is_hdf5(path):
        raise InvalidInput(
            f"{path} must be an HDF5 file, got one that is none; convert it, or write it again"
        )
    with h5py.File(path, "r", rdcc_nbytes=room, locking=False) as file:
        yield file


def _group(path: Path, file: "h5py.File", part: str) -> Any:
    """A group of the file, or all of it."""
    import h5py

    if not part:
        return file
    group = file.get(part) if isinstance(file.get(part, getlink=True), h5py.HardLink) else None
    if not isinstance(group, h5py.Group):
        raise InvalidInput(
            f"{path}: part must be one of its groups, got {shown(part)!r}; has: "
            f"{', '.join(shown(each) for each in list(file)[:20])}"
        )
    return group


def _walk(group: Any, prefix: str, depth: int = 0) -> "Iterator[tuple[str, h5py.Dataset]]":
    """Data sets of a group and the groups in it, but for those that are elsewhere."""
    import h5py

    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        each = group.get(name)
        if isinstance(each, h5py.Group) and depth < DEEPEST:
            yield from _walk(each, f"{prefix}{name}/", depth + 1)
        elif isinstance(each, h5py.Dataset) and not (each.is_virtual or each.external):
            yield f"{prefix}{name}", each


def _arrays(found: "h5py.Dataset") -> Iterator[tuple[str, tuple[int, ...], np.dtype]]:
    """What a data set holds: field, shape and type; nothing where that is no array."""
    if found.shape is None:  # as that of a null space
        return
    fields = found.dtype.fields
    held = {"": found.dtype} if fields is None else {name: each[0] for name, each in fields.items()}
    for name, dtype in held.items():
        yield name, found.shape + dtype.shape, dtype.base
