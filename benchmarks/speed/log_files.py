"""Recorded files of each kind, as long as is asked for, to measure what reading them costs."""

import gzip
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.logs.formats import open_sink
from coopenv.logs.formats.chunks import CHUNK_ROWS
from tests.logs import devices
from tests.logs.kinds import NAMES, parts

TWIST = ("vx", "vy", "omega")
RATE = 1000.0  # [Hz]
ANALOG_RATE = 20  # samples of a frame; C3D counts frames with 16 bits
GRIPS = (-0.9, 0.0, 0.9, 0.0)  # [m]
CORRECTED: Mapping[str, Any] = {
    "files": {"motion": {"path": "motion.csv"}},
    "sensors": {1: {"rotation": 0.5}, 2: {"rotation": -0.3}},  # [rad]
    "filters": {"wrench": 15.0},  # [Hz]
}


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFile:
    """A kind of file, and what is done to it."""

    name: str
    write: Callable[[Path, int], Path]  # into a folder, so many rows; returns the recording
    out: str  # suffix of the table
    layout: Mapping[str, Any] = field(default_factory=dict)
    picture: bool = False


def drawn(rows: int, names: tuple[str, ...] = (*NAMES, *TWIST), seed: int = 0) -> dict[str, Any]:
    """Times, and random numbers with six digits after the point."""
    rng = np.random.default_rng(seed)
    return {"time": np.arange(rows) / RATE} | {
        name: rng.normal(size=rows).round(6) for name in names
    }


def table(path: Path, columns: Mapping[str, Any]) -> Path:
    """A file of the format that its name asks for, in pieces as other programs write it."""
    sink = open_sink(path)
    rows = len(columns["time"])
    for first in range(0, rows, CHUNK_ROWS):
        sink.write({name: each[first : first + CHUNK_ROWS] for name, each in columns.items()})
    sink.close()
    return path


def _table(suffix: str) -> Callable[[Path, int], Path]:
    return lambda folder, rows: table(folder / f"trial{suffix}", drawn(rows))


def _compressed_text(folder: Path, rows: int) -> Path:
    plain = table(folder / "trial.csv", drawn(rows))
    with plain.open("rb") as file, gzip.open(f"{plain}.gz", "wb", compresslevel=1) as made:
        shutil.copyfileobj(file, made)
    return Path(f"{plain}.gz")


def _compressed_arrays(folder: Path, rows: int) -> Path:
    np.savez_compressed(folder / "trial.npz", **drawn(rows))
    return folder / "trial.npz"


def _lists(folder: Path, rows: int) -> Path:
    import pyarrow as pa
    from pyarrow import parquet

    columns = drawn(rows)
    wrenches = np.stack([columns.pop(name) for name in NAMES], axis=-1)
    offsets = np.arange(0, wrenches.size + 1, len(NAMES), dtype=np.int32)
    lists = pa.ListArray.from_arrays(offsets, wrenches.ravel())
    path = folder / "trial.parquet"
    parquet.write_table(pa.table(columns | {"actions": lists}), path, row_group_size=CHUNK_ROWS)
    return path


def _matlab(folder: Path, rows: int) -> Path:
    from scipy.io import savemat

    savemat(folder / "trial.mat", drawn(rows), do_compression=True)
    return folder / "trial.mat"


def _hdf5(folder: Path, rows: int, *, matlab: bool = False) -> Path:
    import h5py

    path = folder / ("trial.mat" if matlab else "trial.h5")
    with h5py.File(path, "w", userblock_size=512 if matlab else 0) as made:
        for name, each in drawn(rows).items():
            values = each[None] if matlab else each
            made.create_dataset(name, data=values, chunks=True, compression="gzip")
    if matlab:
        with path.open("r+b") as begin:
            begin.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    return path


def _bag(storage: str) -> Callable[[Path, int], Path]:
    return lambda folder, rows: devices.rosbag2(_messages(rows), folder, storage)


def _messages(number: int) -> dict[str, Any]:
    """What is in so many messages: in five of them two rows, and a pose."""
    return drawn(2 * number // 5, NAMES)


def _c3d(folder: Path, rows: int) -> Path:
    import c3d

    columns = drawn(rows, NAMES)
    made = c3d.Writer(point_rate=RATE / ANALOG_RATE, analog_rate=RATE)
    made.set_point_labels(["object"])
    made.set_analog_labels(list(NAMES))
    analog = np.stack([columns[name] for name in NAMES]).astype(np.float32)
    for first in range(0, rows, ANALOG_RATE):
        made.add_frames([(np.zeros((1, 5), np.float32), analog[:, first : first + ANALOG_RATE])])
    with (folder / "trial.c3d").open("wb") as file:
        made.write(file)
    return folder / "trial.c3d"


def joined(suffix: str) -> Callable[[Path, int], Path]:
    """Two files: forces, and a motion at as many rows a second, half a step away."""

    def write(folder: Path, rows: int) -> Path:
        motion = drawn(rows + 1, TWIST, seed=1)
        motion["time"] = motion["time"] - 0.5 / RATE
        table(folder / f"motion{suffix}", motion)
        return table(folder / f"trial{suffix}", drawn(rows, NAMES))

    return write


def corrected(suffix: str) -> dict[str, Any]:
    """What is declared of such two files: joined, both sensors turned, wrenches filtered."""
    return {**CORRECTED, "files": {"motion": {"path": f"motion{suffix}"}}}


ALL: tuple[LogFile, ...] = (
    LogFile(name=".csv", write=_table(".csv"), out=".csv"),
    LogFile(name=".csv, with picture", write=_table(".csv"), out=".csv", picture=True),
    LogFile(name=".npz", write=_table(".npz"), out=".npz"),
    LogFile(name=".npz, with picture", write=_table(".npz"), out=".npz", picture=True),
    LogFile(name=".parquet", write=_table(".parquet"), out=".parquet"),
    LogFile(name=".parquet, with picture", write=_table(".parquet"), out=".parquet", picture=True),
    *(
        LogFile(
            name=f"two {suffix}, joined, filtered and rotated",
            write=joined(suffix),
            out=suffix,
            layout=corrected(suffix),
        )
        for suffix in (".csv", ".npz", ".parquet")
    ),
    LogFile(name=".csv.gz", write=_compressed_text, out=".npz"),
    LogFile(name=".npz, compressed", write=_compressed_arrays, out=".npz"),
    LogFile(name=".parquet, lists", write=_lists, out=".npz", layout={"columns": parts("actions")}),
    LogFile(name=".mat before 7.3", write=_matlab, out=".npz"),
    LogFile(
        name=".mat 7.3", write=lambda folder, rows: _hdf5(folder, rows, matlab=True), out=".npz"
    ),
    LogFile(name=".h5", write=_hdf5, out=".npz"),
    LogFile(name=".c3d", write=_c3d, out=".npz", layout={"clock": "analogs"}),
    LogFile(name=".mcap", write=_bag("MCAP"), out=".npz", layout=devices.OF_TOPICS),
    LogFile(name=".db3", write=_bag("SQLITE3"), out=".npz", layout=devices.OF_TOPICS),
    LogFile(
        name=".bag",
        write=lambda folder, rows: devices.rosbag1(_messages(rows), folder),
        out=".npz",
        layout=devices.OF_TOPICS,
    ),
)
