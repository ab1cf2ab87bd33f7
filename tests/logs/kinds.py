"""Kinds of recorded files as laboratories write them: a small one of each, and how it is read.

The page on recordings lists them, and `tests.logs.test_kinds` reads them.
"""

import gzip
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.logs import cases, devices

NAMES = ("f1x", "f1y", "t1z", "f2x", "f2y", "t2z")
THEIRS = ("Fx", "Fy", "Mz", "Gx", "Gy", "Nz")
ROWS = 8
Table = dict[str, Any]


def recorded() -> Table:
    """What is in every file: columns that change evenly, so that it can be sampled anywhere."""
    time = np.arange(ROWS) / 100
    return {"time": time} | {name: k + 1 + 10 * (k - 2) * time for k, name in enumerate(NAMES)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """A kind of file."""

    name: str
    said: str  # options of the command, or fields of the layout
    write: Callable[[Path], Path]  # into a folder; returns the recording
    layout: dict[str, Any] = field(default_factory=dict)
    needs: str = ""  # a package beyond those for CSV and Parquet
    rows: tuple[int, ...] = tuple(range(ROWS))  # of those recorded that are read


def text(
    columns: Table | None = None,
    *,
    separator: str = ",",
    before: str = "",
    units: str = "",
    end: str = "\n",
    after: str = "",
    header: Iterable[str] | None = None,
    decimal: str = ".",
) -> str:
    """A table as text."""
    given = recorded() if columns is None else columns
    names = list(given) if header is None else list(header)
    lines = [separator.join(names) + after] * bool(names) + [units] * bool(units)
    for row in zip(*given.values(), strict=True):
        cells = [cases.as_text(cell).replace(".", decimal) for cell in row]
        lines.append(separator.join(cells) + after)
    return before + end.join([*lines, ""])


def file(content: str | bytes, name: str = "trial.csv") -> Callable[[Path], Path]:
    """A file of that content."""

    def write(folder: Path) -> Path:
        path = folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def times(form: Callable[[float], str], **said: Any) -> str:
    """A table whose times are text."""
    return text(recorded() | {"time": [form(each) for each in recorded()["time"]]}, **said)


def clock(hours: int, second: float, separator: str = ":") -> str:
    """A time of the day, with milliseconds."""
    whole, rest = divmod(round(1000 * second), 1000)
    return f"{hours + whole // 3600:02}:{whole // 60 % 60:02}:{whole % 60:02}{separator}{rest:03}"


def midnight(second: float) -> str:
    """A time of the day, 30 ms before midnight at first."""
    left = round(1000 * second) - 30
    return f"23:59:59.{1000 + left:03}" if left < 0 else f"00:00:00.{left:03}"


def gaps() -> str:
    """A table in which one device says something in every other row only."""
    columns = recorded()
    for name in NAMES[3:]:
        cells = [cases.as_text(each) for each in columns[name]]
        columns[name] = [
            cell if k % 2 == 0 or k == ROWS - 1 else "" for k, cell in enumerate(cells)
        ]
    return text(columns)


def scaled(**factors: float) -> Table:
    """The columns in other units."""
    return {name: values * factors.get(name[0], 1.0) for name, values in recorded().items()}


def matrix() -> Any:
    """Forces and torques as one array ``(T, 6)``."""
    return np.stack([recorded()[name] for name in NAMES], axis=-1)


def records() -> Any:
    """All columns as one array of records."""
    rows = list(zip(*recorded().values(), strict=True))
    return np.array(rows, dtype=[(name, np.float64) for name in recorded()])


def parts(array: str) -> dict[str, str]:
    """A mapping to its columns."""
    return {name: f"{array}:{k}" for k, name in enumerate(NAMES)}


def npz(arrays: Callable[[], Table]) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        np.savez(folder / "trial.npz", **arrays())
        return folder / "trial.npz"

    return write


def parquet(columns: Callable[[Any], Table]) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        import pyarrow as pa
        from pyarrow import parquet

        parquet.write_table(pa.table(columns(pa)), folder / "trial.parquet")
        return folder / "trial.parquet"

    return write


def mat(arrays: Callable[[], Table], **said: Any) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        from scipy.io import savemat

        savemat(folder / "trial.mat", arrays(), **said)
        return folder / "trial.mat"

    return write


def hdf5(arrays: Callable[[], Table], *, matlab: bool = False) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        import h5py

        path = folder / ("trial.mat" if matlab else "trial.h5")
        with h5py.File(path, "w", userblock_size=512 if matlab else 0) as made:
            for name, values in arrays().items():
                chunks = None if matlab else (3, *np.shape(values)[1:])
                made.create_dataset(name, data=values, chunks=chunks)
        if matlab:
            with path.open("r+b") as begin:
                begin.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
        return path

    return write


def stamped() -> Any:
    """Times as time stamps."""
    since = np.round(recorded()["time"] * 1e9).astype("m8[ns]")
    return np.datetime64("2026-03-01T23:59:59.97", "ns") + since


def beside(left: dict[str, Any] | None = None, right: dict[str, Any] | None = None):
    """Two force sensors as files of their own beside that of the motion, at other times."""

    def write(folder: Path) -> Path:
        for names, name, said in ((NAMES[:3], "left", left), (NAMES[3:], "right", right)):
            made = devices.sampled(recorded(), names, **(said or {}))
            file(text(made), f"{name}.csv")(folder)
        return file(text({"time": recorded()["time"], "mark": np.arange(ROWS)}))(folder)

    return write


KINDS: tuple[Kind, ...] = (
    Kind(name="CSV", said="", write=file(text())),
    Kind(name="TSV", said="", write=file(text(separator="\t"), "trial.tsv")),
    Kind(
        name="semicolons and decimal commas",
        said="`--decimal ,`",
        write=file(text(separator=";", decimal=",")),
        layout={"decimal": ","},
    ),
    Kind(name="bars between fields", said="", write=file(text(separator="|"), "trial.txt")),
    Kind(
        name="one or more blanks between fields",
        said="",
        write=file(text(separator="   ").replace("\n", "  \n "), "trial.txt"),
    ),
    Kind(
        name="a blank after each comma",
        said="",
        write=file(text(separator=", ")),
    ),
    Kind(
        name="lines of Windows, empty lines between",
        said="",
        write=file(text(end="\r\n\r\n")),
    ),
    Kind(
        name="quoted names and fields, a comma within",
        said='`--map "f1x=F, left"`',
        write=file(
            text(
                recorded() | {"note": ['"a, b"'] * ROWS},
                header=["time", '"F, left"', *NAMES[1:], '"note"'],
            )
        ),
        layout={"columns": {"f1x": "F, left"}},
    ),
    Kind(
        name="lines of a preamble before the header",
        said="`--skip-lines 3`",
        write=file(text(before="Serial number;4711\nRate [Hz]: 100\n\n")),
        layout={"skip_lines": 3},
    ),
    Kind(
        name="comments before and among the rows",
        said='`--comment "#"`',
        write=file(text(before="# force sensor, left\n").replace("\n0.04", "\n# paused\n0.04")),
        layout={"comment": "#"},
    ),
    Kind(
        name="the header in a comment, as `numpy.savetxt` writes it",
        said='`--comment "#"`',
        write=file(text(separator=" ", before="# "), "trial.txt"),
        layout={"comment": "#"},
    ),
    Kind(
        name="a row of units below the header",
        said="`--units-row`",
        write=file(
            text(
                scaled(f=1e-3, t=1e3) | {"time": recorded()["time"] * 1e3},
                units="[ms]" + ",kN,kN,N-mm" * 2,
            )
        ),
        layout={"units_row": True},
    ),
    Kind(
        name="no header",
        said="`--no-header --map time=0 f1x=1 …`",
        write=file(text(header=())),
        layout={
            "no_header": True,
            "columns": {name: str(k) for k, name in enumerate(recorded())},
        },
    ),
    Kind(
        name="names that are there twice",
        said="`--map f1x=Fx f2x=Fx.1 …`, counted as pandas does",
        write=file(text(header=["time", *(2 * ("Fx", "Fy", "Mz"))])),
        layout={
            "columns": dict(zip(NAMES, ("Fx", "Fy", "Mz", "Fx.1", "Fy.1", "Mz.1"), strict=True))
        },
    ),
    Kind(
        name="separators at the ends of all lines",
        said="",
        write=file(text(after=",")),
    ),
    Kind(
        name="separators at the ends of rows, not of the header",
        said="",
        write=file(text(separator=";", after=";").replace(";\n", "\n", 1)),
    ),
    Kind(
        name="UTF-8 with a byte order mark",
        said="",
        write=file(text().encode("utf-8-sig")),
    ),
    Kind(name="UTF-16 with a byte order mark", said="", write=file(text().encode("utf-16"))),
    Kind(name="UTF-16 without one", said="", write=file(text().encode("utf-16-le"))),
    Kind(
        name="Windows-1252 and other encodings",
        said="`--encoding cp1252`",
        write=file(text(header=["Zeit", "Kraft für x", *NAMES[1:]]).encode("cp1252")),
        layout={"encoding": "cp1252", "columns": {"time": "Zeit", "f1x": "Kraft für x"}},
    ),
    Kind(
        name="compressed: `.csv.gz`, `.tsv.gz`, `.txt.gz`",
        said="",
        write=file(gzip.compress(text().encode()), "trial.csv.gz"),
    ),
    Kind(
        name="times in ISO 8601",
        said="`--time iso`",
        write=file(times(lambda each: f"2026-03-01T{clock(9, each, '.')}+01:00")),
        layout={"time": "iso"},
    ),
    Kind(
        name="times of a clock",
        said='`--time "%H:%M:%S:%f"`',
        write=file(times(lambda each: clock(9, each))),
        layout={"time": "%H:%M:%S:%f"},
    ),
    Kind(
        name="times of a clock that passes midnight",
        said='`--time "%H:%M:%S.%f"`',
        write=file(times(midnight)),
        layout={"time": "%H:%M:%S.%f"},
    ),
    Kind(
        name="dates of a country's own",
        said='`--time "%d.%m.%Y %H:%M:%S.%f"`',
        write=file(times(lambda each: f"01.03.2026 {clock(9, each, '.')}")),
        layout={"time": "%d.%m.%Y %H:%M:%S.%f"},
    ),
    Kind(
        name="nanoseconds since 1970, as `rostopic echo -p` has them",
        said="`--time ns --map time=%time f1x=field.wrench.force.x …`",
        write=file(
            text(
                recorded() | {"time": [1_700_000_000_000_000_000 + k * 10**7 for k in range(ROWS)]},
                header=["%time", "field.wrench.force.x", *NAMES[1:]],
            )
        ),
        layout={"time": "ns", "columns": {"time": "%time", "f1x": "field.wrench.force.x"}},
    ),
    Kind(
        name="PlotJuggler's CSV",
        said="`--map time=__time f1x=/left/wrench/force/x …`",
        write=file(text(header=["__time", "/left/wrench/force/x", *NAMES[1:]])),
        layout={"columns": {"time": "__time", "f1x": "/left/wrench/force/x"}},
    ),
    Kind(
        name="no column of time",
        said="`--sample-rate 100`",
        write=file(text({name: recorded()[name] for name in NAMES})),
        layout={"sample_rate": 100.0},
    ),
    Kind(
        name="units as laboratories spell them",
        said="`--force lbf --torque in-lb`",
        write=file(
            text(
                scaled(f=1 / 4.4482216152605)
                | {name: recorded()[name] / (4.4482216152605 * 0.0254) for name in ("t1z", "t2z")}
            )
        ),
        layout={"force": "lbf", "torque": "in-lb"},
    ),
    Kind(
        name="values of a slower device in some rows only",
        said="`--fill linear --longest-gap 0.05`",
        write=file(gaps()),
        layout={"fill": "linear", "longest_gap": 0.05},
    ),
    Kind(name="NPZ, an array a column", said="", write=npz(recorded)),
    Kind(
        name="NPZ, an array a quantity",
        said="",
        write=npz(
            lambda: {
                "time": recorded()["time"],
                "force": matrix().reshape(-1, 2, 3)[..., :2],
                "torque": matrix().reshape(-1, 2, 3)[..., 2],
            }
        ),
    ),
    Kind(
        name="NPZ, columns of a matrix",
        said="`--map f1x=actions:0 f1y=actions:1 …`",
        write=npz(lambda: {"time": recorded()["time"], "actions": matrix()}),
        layout={"columns": parts("actions")},
    ),
    Kind(
        name="NPZ, times as `datetime64`",
        said="`--time iso`",
        write=npz(lambda: recorded() | {"time": stamped()}),
        layout={"time": "iso"},
    ),
    Kind(name="Parquet", said="", write=parquet(lambda pa: recorded())),
    Kind(
        name="Parquet, lists",
        said="`--map f1x=actions:0 …`",
        write=parquet(
            lambda pa: {"time": recorded()["time"], "actions": pa.array(matrix().tolist())}
        ),
        layout={"columns": parts("actions")},
    ),
    Kind(
        name="Parquet, lists of one length",
        said="`--map f1x=actions:0 …`",
        write=parquet(
            lambda pa: {
                "time": recorded()["time"],
                "actions": pa.array(matrix().tolist(), pa.list_(pa.float32(), 6)),
            }
        ),
        layout={"columns": parts("actions")},
    ),
    Kind(
        name="Parquet, time stamps",
        said="`--time iso`",
        write=parquet(lambda pa: recorded() | {"time": pa.array(stamped())}),
        layout={"time": "iso"},
    ),
    Kind(name="MATLAB 5 to 7", said="", write=mat(recorded), needs="scipy"),
    Kind(
        name="MATLAB, a structure with a column a sample, compressed",
        said="`--map time=trial.t f1x=trial.F:0 …`",
        write=mat(
            lambda: {"trial": {"t": recorded()["time"], "F": matrix().T}}, do_compression=True
        ),
        layout={"columns": {"time": "trial.t", **parts("trial.F")}},
        needs="scipy",
    ),
    Kind(name="MATLAB 4", said="", write=mat(recorded, format="4"), needs="scipy"),
    Kind(
        name="MATLAB 7.3",
        said="`--map f1x=trial.F:0 …`",
        write=hdf5(lambda: {"time": recorded()["time"][None], "trial/F": matrix().T}, matlab=True),
        layout={"columns": parts("trial.F")},
        needs="h5py",
    ),
    Kind(
        name="HDF5, a data set a column",
        said="`--map time=left/t f1x=left/Fx …`",
        write=hdf5(
            lambda: {
                f"left/{name}": values
                for name, values in zip(("t", *THEIRS), recorded().values(), strict=True)
            }
        ),
        layout={
            "columns": {
                name: f"left/{theirs}"
                for name, theirs in zip(("time", *NAMES), ("t", *THEIRS), strict=True)
            }
        },
        needs="h5py",
    ),
    Kind(
        name="HDF5, columns of a matrix",
        said="`--map f1x=sensors/actions:0 …`",
        write=hdf5(lambda: {"time": recorded()["time"], "sensors/actions": matrix()}),
        layout={"columns": parts("sensors/actions")},
        needs="h5py",
    ),
    Kind(
        name="HDF5, a compound data set",
        said="`--map time=table/time f1x=table/f1x …`",
        write=hdf5(lambda: {"table": records()}),
        layout={"columns": {name: f"table/{name}" for name in recorded()}},
        needs="h5py",
    ),
    Kind(
        name="HDF5, a group a device, each with times of its own",
        said='`[files.left]` `part = "left"`, `[files.right]` …; `--clock left`',
        write=hdf5(
            lambda: {
                f"{group}/{name}": values
                for group, names, every in (
                    ("left", NAMES[:3], 0.01),
                    ("right", NAMES[3:], 0.004),
                )
                for name, values in devices.sampled(recorded(), names, every=every).items()
            }
        ),
        layout={
            "files": {"left": {"part": "left"}, "right": {"part": "right"}},
            "clock": "left",
        },
        needs="h5py",
    ),
    Kind(
        name="a file a device, at other rates",
        said="`--join left.csv right.csv`",
        write=beside({"every": 0.004}, {"every": 0.005, "begin": -0.02}),
        layout={"files": {"left": {"path": "left.csv"}, "right": {"path": "right.csv"}}},
    ),
    Kind(
        name="a file a device, one late and in milliseconds",
        said='`[files.right]` `path = "right.csv"`, `delay = 0.1`, `unit = "ms"`',
        write=beside({}, {"every": 0.004, "shift": 0.1, "unit": 1e-3}),
        layout={
            "files": {
                "left": {"path": "left.csv"},
                "right": {"path": "right.csv", "delay": 0.1, "unit": "ms"},
            }
        },
    ),
    Kind(
        name="a file a device, one without times",
        said='`[files.right]` `path = "right.csv"`, `rate = 500`',
        write=beside({}, {"every": 0.002, "timed": False}),
        layout={
            "files": {
                "left": {"path": "left.csv"},
                "right": {"path": "right.csv", "rate": 500, "method": "nearest"},
            }
        },
    ),
    Kind(
        name="a file a device, row by row",
        said="`--join left.csv right.csv --join-method rows`",
        write=beside({"timed": False}, {"timed": False}),
        layout={
            "files": {"left": {"path": "left.csv"}, "right": {"path": "right.csv"}},
            "join_method": "rows",
        },
    ),
    Kind(
        name="a file a device, at a rate of their own",
        said="`--join left.csv right.csv --join-rate 50`",
        write=beside({"every": 0.004}, {"every": 0.003}),
        layout={
            "files": {"left": {"path": "left.csv"}, "right": {"path": "right.csv"}},
            "join_rate": 50.0,
        },
        rows=(0, 2, 4, 6),
    ),
    Kind(
        name="rosbag2, MCAP",
        said="`--clock /left/wrench --map f1x=/left/wrench/wrench/force/x …`",
        write=lambda folder: devices.rosbag2(recorded(), folder, "MCAP"),
        layout=devices.OF_TOPICS,
        needs="rosbags",
    ),
    Kind(
        name="rosbag2, SQLite: `.db3`",
        said="the same",
        write=lambda folder: devices.rosbag2(recorded(), folder, "SQLITE3"),
        layout=devices.OF_TOPICS,
        needs="rosbags",
    ),
    Kind(
        name="rosbag2, the folder with its `metadata.yaml`",
        said="the same",
        write=lambda folder: devices.rosbag2_folder(recorded(), folder, "MCAP"),
        layout=devices.OF_TOPICS,
        needs="rosbags",
    ),
    Kind(
        name="ROS 1 bag",
        said="the same",
        write=lambda folder: devices.rosbag1(recorded(), folder),
        layout=devices.OF_TOPICS,
        needs="rosbags",
    ),
    Kind(
        name="C3D",
        said="`--clock analogs`",
        write=lambda folder: devices.c3d_file(recorded(), folder),
        layout={"clock": "analogs"},
        needs="c3d",
    ),
)


def table_rows() -> list[tuple[str, str]]:
    """Kind and options, for the page on recordings."""
    return [(each.name, each.said) for each in KINDS]
