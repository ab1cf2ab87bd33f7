"""Whole recordings of the formats that are only read, for damage; each is made once."""

import gzip
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from tests.logs import cases, devices
from tests.logs.kinds import KINDS, recorded

Made = bytes | dict[str, bytes]  # a file, or the files of a folder by their names


@cache
def _content(name: str) -> bytes:
    """Of the file of a kind on the page on recordings."""
    kind = next(each for each in KINDS if each.name == name)
    with TemporaryDirectory() as folder:
        return kind.write(Path(folder)).read_bytes()


def compressed(rng: np.random.Generator) -> bytes:
    """Compressed CSV, of which what is inside is sometimes wrong rather than the compression."""
    text = bytearray(cases_text())
    if rng.random() < 0.5:
        at = int(rng.integers(len(text)))
        text[at : at + 2] = rng.bytes(2)
    return gzip.compress(bytes(text), mtime=0)


@cache
def cases_text() -> bytes:
    """A table as CSV."""
    with TemporaryDirectory() as folder:
        return cases.save(recorded(), Path(folder) / "a.csv").read_bytes()


def of(*names: str) -> Callable[[np.random.Generator], bytes]:
    """One of these kinds."""
    return lambda rng: _content(names[int(rng.integers(len(names)))])


def folder(rng: np.random.Generator) -> dict[str, bytes]:
    """A rosbag2 as ROS 2 writes it, sometimes without one of its files."""
    files = dict(_bag(("MCAP", "SQLITE3")[int(rng.integers(2))]))
    if rng.random() < 0.1:
        del files[sorted(files)[int(rng.integers(2))]]
    return files


@cache
def _bag(storage: str) -> tuple[tuple[str, bytes], ...]:
    with TemporaryDirectory() as place:
        made = devices.rosbag2_folder(recorded(), Path(place), storage)
        return tuple((each.name, each.read_bytes()) for each in sorted(made.iterdir()))


# suffix, none of a folder; what makes a whole file; the package that reads it
WHOLE: tuple[tuple[str, Callable[[np.random.Generator], Made], str], ...] = (
    (".csv.gz", compressed, "pyarrow"),
    (
        ".mat",
        of("MATLAB 5 to 7", "MATLAB, a structure with a column a sample, compressed"),
        "scipy",
    ),
    (".mat", of("MATLAB 4"), "scipy"),
    (".mat", of("MATLAB 7.3"), "h5py"),
    (".h5", of("HDF5, a data set a column", "HDF5, a compound data set"), "h5py"),
    (".mcap", of("rosbag2, MCAP"), "rosbags"),
    (".db3", of("rosbag2, SQLite: `.db3`"), "rosbags"),
    ("", folder, "rosbags"),
    (".bag", of("ROS 1 bag"), "rosbags"),
    (".c3d", of("C3D"), "c3d"),
)

_MATRICES: dict[str, Any] = {
    "columns": {name: f"trial.F:{k}" for k, name in enumerate(list(recorded())[1:])}
}
LAYOUTS: dict[str, tuple[dict[str, Any], ...]] = {  # suffix -> how such files are read
    ".mat": ({}, _MATRICES, {"columns": {"time": "trial.t", **_MATRICES["columns"]}}),
    ".h5": tuple(
        next(each.layout for each in KINDS if each.name == name)
        for name in ("HDF5, a data set a column", "HDF5, a compound data set")
    ),
    ".mcap": (devices.OF_TOPICS,),
    ".db3": (devices.OF_TOPICS,),
    ".bag": (devices.OF_TOPICS,),
    "": (devices.OF_TOPICS,),
    ".c3d": ({"clock": "analogs"},),
}
