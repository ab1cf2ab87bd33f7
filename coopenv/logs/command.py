"""Command line of ``coopenv decompose``: options, progress bar, summary."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from coopenv.errors import MissingExtra
from coopenv.options import ALONE, POSITIONAL, Common

if TYPE_CHECKING:
    from rich.console import Console

BODY = ("mass", "inertia", "drag", "gravity")  # options that are keys of [body]


@dataclass(frozen=True, kw_only=True)
class Decompose:
    """Decompose a recorded trial: table, picture and summary beside the file, the summary here too.

    Reads .csv, .npz or .parquet with columns such as time, f1x, f1y, t1z, r1x, r1y, f2x and so on,
    also .csv.gz, .mat, .h5, .mcap, .db3, .bag, .c3d and rosbag2 folders; docs/recordings.md lists
    them all.
    """

    file: Annotated[Path, POSITIONAL]
    """Of the recording; of a rosbag2, the folder."""
    out: Path | None = None
    """Of the table, .csv, .npz or .parquet; trial.decomposed.csv beside trial.csv by default."""
    picture: bool = True
    """Draw the time series as PNG beside the table."""
    check: bool = False
    """Only compare the recording with its motion, and say what would explain a difference; nothing
    is written. With mass and inertia it has numbers."""
    bad_rows: str = "error"
    """What to do with rows that cannot be used: error, or skip (their results are NaN)."""
    method: str = "optimal"
    """Definition of internal wrench; see docs/decomposition.md."""
    solver: str = "auto"
    """Of the method optimal."""
    torque_weight: float = 0.5
    """w of the cost."""
    include_induced: bool = False
    """Count induced torques in the cost."""
    virtual_masses: tuple[float, ...] | None = None
    """Of the method parametrized, one an effector [kg]."""
    virtual_inertias: tuple[float, ...] | None = None
    """Of the method parametrized, one an effector [kg m²]."""
    layout: Path | None = None
    """.toml or .json file with the options below; those that are given win."""
    map: tuple[str, ...] = ()
    """Columns that are called otherwise, such as f1x=Fx_left, or f1x=-Fx_left to turn the sign;
    time= leaves one out."""
    grips: tuple[float, ...] | None = None
    """Where the effectors hold, x y of the first, x y of the second and so on, object frame."""
    frame: str | None = None
    """Of forces and torques: object (default) or world, which needs the orientation."""
    twist_frame: str | None = None
    """Of the twist, if it is not that of the forces."""
    grip_frame: str | None = None
    """Of the columns of grips: object (default) or world, which needs the pose."""
    y: str | None = None
    """Up (default) or down: then y, planar torques and angles change sign."""
    space: str | None = None
    """Plane leaves out what points out of it; auto (default) goes by the columns."""
    forces_only: Annotated[bool, ALONE] = False
    """The effectors apply no torque, and the file has no such columns."""
    decimal: str | None = None
    """What separates decimals in a text file: . (default) or a comma."""
    encoding: str | None = None
    """Of a text file; UTF-8 by default, and UTF-16 where it begins so. Others: cp1252, latin-1."""
    separator: str | None = None
    """In a text file: comma, semicolon, tab, bar (|) or blanks; what the header has most of by
    default."""
    comment: str | None = None
    """Lines of a text file that begin with this mark are passed over, such as #."""
    skip_lines: int | None = None
    """Lines of a text file before its header; 0 by default."""
    no_header: Annotated[bool, ALONE] = False
    """A text file has no header: its columns are called 0, 1, 2 and so on."""
    units_row: Annotated[bool, ALONE] = False
    """The line below the header says the unit of each column."""
    sample_rate: float | None = None
    """Rows a second [Hz], where the recording has no column of time."""
    join: tuple[str, ...] | None = None
    """Files of other devices that recorded the same trial, NAME=PATH or PATH."""
    clock: str | None = None
    """The device whose rows are kept; the recording itself by default."""
    join_rate: float | None = None
    """Rows are made at this rate [Hz], instead of those of a device."""
    join_method: str | None = None
    """What a device says between its samples: linear (default), nearest, previous; or rows, one
    beside the other."""
    fill: str | None = None
    """Fill missing values: linear, nearest or previous; none by default."""
    longest_gap: float | None = None
    """Between samples that is bridged, in joining and filling [s]; 0.1 by default."""
    mass: float | None = None
    """Of the object [kg], with its inertia: G h is compared with its motion."""
    inertia: tuple[float, ...] | None = None
    """Of the object about its centre of mass [kg m²]: a number in the plane; in space 3, along its
    axes, or 9, row by row."""
    drag: tuple[float, ...] | None = None
    """On the object, of translation [N s/m] and of rotation [N m s]; none by default."""
    gravity: tuple[float, ...] | None = None
    """In the world frame [m/s²]; in the plane none, in space along -z by default."""
    trial_columns: tuple[str, ...] | None = None
    """A new value in one of them begins a new trial; pair, condition and trial by default."""
    time: str | None = None
    """Unit: s (default), ms, us, ns, min, h. Or how times are written: iso, or %H:%M:%S.%f."""
    length: str | None = None
    """Unit: m (default), cm, mm, um, in, ft."""
    angle: str | None = None
    """Unit: rad (default), deg, mrad."""
    velocity: str | None = None
    """Unit: m/s (default), cm/s, mm/s, in/s, ft/s."""
    angular_velocity: str | None = None
    """Unit: rad/s (default), deg/s, rpm."""
    force: str | None = None
    """Unit: N (default), mN, kN, lbf, ozf, kgf, gf."""
    torque: str | None = None
    """Unit: N*m (default), N*cm, N*mm, mN*m, kN*m, lbf*in, lbf*ft, ozf*in, kgf*m, kgf*cm, gf*cm."""
    max_row_bytes: int | None = None
    """The most that a row may have, of text a line; 1,048,576 by default."""
    max_columns: int | None = None
    """The most columns; 10,000 by default."""
    max_effectors: int | None = None
    """The most effectors; 100 by default."""
    max_rows: int | None = None
    """The most rows of NPZ and Parquet, which say how many they have; 100,000,000 by default."""
    max_block_bytes: int | None = None
    """The most that can only be read at once, an array in Fortran order or a row group; 1 GiB by
    default."""
    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv decompose trial.csv",
        "coopenv decompose trial.csv --grips -0.9 0 0.9 0 --frame world --torque N*mm",
        "coopenv decompose trial.h5 --layout trial.toml --out trial.parquet --json",
        "coopenv decompose trial.csv --check",
    )

    def run(self) -> Any:
        """Decompose, write, print."""
        try:
            from rich.console import Console
        except ImportError as error:
            raise MissingExtra("the command line", "analysis") from error

        from coopenv.logs.layout import TABLES, Layout, parse_mapping
        from coopenv.logs.limits import legible
        from coopenv.logs.run import check_file, decompose_file
        from coopenv.wrench import Settings

        options = [entry.name for entry in fields(Layout) if entry.name not in TABLES]
        said: dict[str, Any] = {
            name: getattr(self, name)
            for name in options
            if getattr(self, name) is not None and getattr(self, name) is not False
        }
        if body := self._body():
            said["body"] = body
        layout = Layout.load(self.layout, columns=parse_mapping(self.map), **said)
        console = Console()
        if self.check:
            with _progress(console, "checking") as report:
                checked = check_file(
                    self.file, layout=layout, bad_rows=self.bad_rows, report=report
                )
            for line in checked.lines():
                console.print(line, markup=False, highlight=False)
            return checked
        settings = Settings(
            method=self.method,
            solver=self.solver,
            torque_weight=self.torque_weight,
            include_induced=self.include_induced,
            virtual_masses=self.virtual_masses,
            virtual_inertias=self.virtual_inertias,
        )
        with _progress(console, "decomposing") as report:
            summary = decompose_file(
                self.file,
                self.out,
                layout=layout,
                settings=settings,
                bad_rows=self.bad_rows,
                picture=self.picture,
                report=report,
            )
        summary.print(console)
        files = (summary.table, summary.picture, summary.written)
        names = ", ".join(legible(each) for each in files if each is not None)
        console.print(f"wrote {names}", markup=False, highlight=False, soft_wrap=True)
        return summary

    def _body(self) -> dict[str, Any]:
        """What the options say of the object, as ``[body]`` of a layout has it."""
        said: dict[str, Any] = {
            name: value for name in BODY if (value := getattr(self, name)) is not None
        }
        inertia = said.get("inertia", ())
        if len(inertia) == 1:
            said["inertia"] = inertia[0]
        elif len(inertia) == 9:
            said["inertia"] = [list(inertia[k : k + 3]) for k in (0, 3, 6)]
        return said


@contextmanager
def _progress(console: "Console", what: str) -> Iterator[Callable[[float], None]]:
    """A progress bar over the file."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn(what), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        yield lambda done: bar.update(task, completed=done)
