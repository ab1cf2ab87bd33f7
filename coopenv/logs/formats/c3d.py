"""C3D files of motion capture: analog channels and markers, each at its own rate, frame by frame.

Through the library c3d, which is plain Python: what damaged files make of others, in machine code,
ends the interpreter.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.units import is_unit
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Source, Wanted, rows_at_once
from coopenv.logs.formats.cleaning import numbered
from coopenv.logs.formats.damage import parsing
from coopenv.logs.limits import Limits, shown

TIME = "time"
ANALOGS, POINTS = "analogs", "points"
AXES = ("x", "y", "z")


class C3dSource(Source):
    """Analog channels, called by their labels, or markers: ``label.x``, ``label.y``, ``label.z``.

    Parameters
    ----------
    path, dialect, limits
        See `Source`.
    part
        ``"analogs"`` or ``"points"``; may be left out where the file has one of them.
    """

    def __init__(self, path: Path, dialect: Dialect, limits: Limits, part: str = ""):
        self._path = path
        with _opened(path) as reader:
            there = _parts(reader)
            part = part or (there[0] if len(there) == 1 else "")
            if part not in there:
                raise InvalidInput(
                    f"{path}: part must be one of those that it has, got {shown(part)!r}; has: "
                    f"{', '.join(there) or 'none'}"
                )
            self._analog = part == ANALOGS
            self._each = int(reader.analog_per_frame) if self._analog else 1
            self._rate = float(reader.point_rate) * self._each
            self._frames = max(int(reader.last_frame) - int(reader.first_frame) + 1, 0)
            labels = [_label(each) for each in _labels(reader, self._analog)]
            units = _units(reader, self._analog, len(labels))
            size = 4 * (4 * int(reader.point_used) + int(reader.analog_used) * self._each)
        if not 0 < self._rate < np.inf:
            raise InvalidInput(
                f"{path} must have a rate of {part}, got {self._rate:g}; export it again"
            )
        limits.require("row_bytes", size, f"{path}", "export less of it")
        names = [each or f"{part}:{k}" for k, each in enumerate(labels)]
        if not self._analog:
            names = [f"{each}.{axis}" for each in names for axis in AXES]
            units = [each for each in units for _ in AXES]
        columns, _ = numbered(names)
        limits.require("columns", len(columns), f"{path}", "leave out what is not needed")
        self.columns = [TIME, *columns]
        self.units = {name: unit for name, unit in zip(columns, units, strict=True) if unit}
        self.units[TIME] = "s"
        self._at = {name: k for k, name in enumerate(columns)}
        self._most = max(1, rows_at_once(CHUNK_ROWS, size) // self._each)

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read some thousand frames at a time; markers that were not seen are missing."""
        row = 1
        with _opened(self._path) as reader:
            frames = reader.read_frames(copy=True)
            while part := list(islice(frames, self._most)):
                table = np.concatenate([self._rows(*each[1:]) for each in part])
                time = (row - 1 + np.arange(len(table))) / self._rate
                pick = {name: table[:, self._at[name]] for name in self._at}
                pick[TIME] = time
                yield Chunk(
                    numbers={name: pick[name] for name in wanted.numbers},
                    carried={name: pick[name] for name in wanted.carried},
                    rows=len(table),
                    first_row=row,
                    progress=min(1.0, (row - 1 + len(table)) / (self._frames * self._each or 1)),
                )
                row += len(table)
        if row - 1 < self._frames * self._each:
            raise InvalidInput(
                f"{self._path} must have {self._frames:,} frames as it says, got "
                f"{(row - 1) // self._each:,}; export it again"
            )

    def _rows(self, points: Any, analog: Any) -> np.ndarray:
        """Rows of a frame: one, or as many as it has analog samples."""
        if self._analog:
            return np.asarray(analog, dtype=np.float64).T
        place = np.asarray(points[:, :3], dtype=np.float64)
        place[points[:, 3] < 0] = np.nan  # not seen
        return place.reshape(1, -1)


def parts(path: Path, limits: Limits) -> list[str]:
    """Which of analog channels and markers a file has."""
    with _opened(path) as reader:
        return _parts(reader)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """A reader of the file."""
    missing = MissingExtra("reading C3D", "formats")
    with (
        parsing(path, "a whole C3D file", "export it again", missing=missing),
        path.open("rb") as file,
        warnings.catch_warnings(),
        np.errstate(all="ignore"),
    ):
        import c3d

        warnings.simplefilter("ignore")  # what is cut is told by its frames
        yield c3d.Reader(file)


def _parts(reader: Any) -> list[str]:
    there = {ANALOGS: reader.analog_used, POINTS: reader.point_used}
    return [name for name, count in there.items() if count]


def _labels(reader: Any, analog: bool) -> list[str]:
    """Labels, as many as there are channels or markers."""
    count = int(reader.analog_used if analog else reader.point_used)
    group = reader.get("ANALOG" if analog else "POINT")
    found = [] if group is None or group.get("LABELS") is None else group.get("LABELS").string_array
    labels = [str(each) for each in np.ravel(found)]
    return [*labels, *[""] * count][:count]


def _label(text: str) -> str:
    return " ".join(text.replace("\0", " ").split())


def _units(reader: Any, analog: bool, count: int) -> list[str]:
    """Units of channels or markers, as far as the file says them."""
    group = reader.get("ANALOG" if analog else "POINT")
    found = [] if group is None or group.get("UNITS") is None else group.get("UNITS").string_array
    units = [_label(str(each)) for each in np.ravel(found)]
    if not analog:
        units = units[:1] * count
    return [each if each and is_unit(each) else "" for each in [*units, *[""] * count][:count]]
