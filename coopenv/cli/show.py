"""``coopenv show``: the split of one wrench, as a picture and as a table."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from coopenv.arrays import FloatArray, number, whole
from coopenv.cli.split import judge, split_table
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import require_writable, written
from coopenv.options import POSITIONAL, Common

SUFFIXES = (".png", ".svg", ".pdf")
DPI = 150  # of PNG
WIDEST = 400  # letters that a table may need, however narrow the terminal


@dataclass(frozen=True, kw_only=True)
class Show:
    """Draw the split of one wrench, and print it: of given numbers, or of a row of a recording."""

    file: Annotated[Path | None, POSITIONAL] = None
    """Recording, read as coopenv decompose reads it."""
    row: int | None = None
    """Of the recording; the first is 1."""
    at: float | None = None
    """Time of the recording instead [s], within it: the nearest good row."""
    applied: tuple[float, ...] | None = None
    """fx fy tz of the first effector, then of the second; in space fx fy fz tx ty tz [N, N·m]."""
    grips: tuple[float, ...] | None = None
    """x y of the first, then of the second; in space x y z; object frame [m]."""
    internal: tuple[float, ...] | None = None
    """Internal wrench of a split of your own, in the order of applied."""
    layout: Path | None = None
    """.toml or .json file that says how the recording is to be read; see docs/recordings.md."""
    method: str = "optimal"
    """Definition of internal wrench; see docs/decomposition.md."""
    solver: str = "auto"
    """Of the method optimal."""
    torque_weight: float = 0.5
    """w of the cost."""
    include_induced: bool = False
    """Count induced torques in the cost."""
    regions: bool = True
    """Show where plausible answers lie."""
    out: Path | None = None
    """Picture, .png, .svg or .pdf; split.png, or trial.row120.png beside trial.csv by default."""

    common: Common = field(default_factory=Common)
    examples: ClassVar[tuple[str, ...]] = (
        "coopenv show --grips -0.9 0 0.9 0 --applied 3 0 0 -1 0 0",
        "coopenv show trial.csv --row 120 --out split.pdf",
        "coopenv show trial.csv --at 2.5 --method moore_penrose --json",
    )

    def run(self) -> dict[str, Any]:
        """Split, print, draw."""
        try:
            import matplotlib  # noqa: F401  - before anything is computed
            from rich.console import Console
        except ImportError as error:
            raise MissingExtra("coopenv show", "analysis") from error

        from coopenv.wrench import decompose, plot

        applied, grips, where = self._given()
        out = self.out if self.out is not None else self._picture(where)
        if out.suffix.lower() not in SUFFIXES:
            raise InvalidInput(
                f"out must end in one of {', '.join(SUFFIXES)}, got {out.name!r}; rename it"
            )
        require_writable(out)
        split = decompose(
            applied,
            grips,
            method=self.method,
            solver=self.solver,
            torque_weight=self.torque_weight,
            include_induced=self.include_induced,
        )
        if self.internal is not None and (self.method, self.solver) != ("optimal", "auto"):
            raise InvalidInput(
                "only one of internal and method must be given, got both; leave out method and "
                "solver for a split of your own"
            )
        own = None if self.internal is None else _shaped(self.internal, "internal", applied.shape)
        weights = {"torque_weight": self.torque_weight, "include_induced": self.include_induced}
        chosen: dict[str, Any] = {"decomposition": split}
        if own is not None:
            chosen = {"internal": own, **weights}
        axes = plot(applied, grips, regions=self.regions, **chosen)
        if where:
            axes.set_title(f"{where}, {axes.get_title()}", fontsize=10, parse_math=False)
        console = Console()
        internal = split.internal if own is None else own
        table = split_table(applied, internal, axes.get_title())
        needed = console.measure(table, options=console.options.update(max_width=WIDEST)).maximum
        console.width = max(console.width, needed)  # all of each number
        console.print(table)
        judged = judge(split, internal, **weights)
        for line in judged.lines():
            console.print(line, markup=False, highlight=False, soft_wrap=True)
        with written(out) as part:
            axes.figure.savefig(part, format=out.suffix[1:].lower(), dpi=DPI)
        console.print(f"wrote {out}", markup=False, highlight=False, soft_wrap=True)
        return {**judged.document(), "where": where or None, "picture": out}

    def _given(self) -> tuple[FloatArray, FloatArray, str]:
        """Applied wrench, grips, and which row they are of."""
        if self.file is not None:
            if self.applied is not None:
                raise InvalidInput("applied must be left out beside a file, got both; give one")
            return self._recorded(self.file)
        for name in ("row", "at", "layout"):
            if getattr(self, name) is not None:
                raise InvalidInput(f"{name} must come with a file, got none; name it before it")
        if self.applied is None or self.grips is None:
            raise InvalidInput(
                "applied and grips must both be given, or a file with a row, for example: "
                "coopenv show --grips -0.9 0 0.9 0 --applied 3 0 0 -1 0 0"
            )
        for dimension, size in ((2, 3), (3, 6)):
            count, rest = divmod(len(self.grips), dimension)
            if count and not rest and len(self.applied) == count * size:
                grips = np.array(self.grips, dtype=np.float64).reshape(count, dimension)
                return _shaped(self.applied, "applied", (count, size)), grips, ""
        raise InvalidInput(
            "grips and applied must have 2 and 3 numbers for each effector, in space 3 and 6, got "
            f"{len(self.grips)} and {len(self.applied)}; for example: --grips -0.9 0 0.9 0 "
            "--applied 3 0 0 -1 0 0"
        )

    def _recorded(self, file: Path) -> tuple[FloatArray, FloatArray, str]:
        """A row of the file, which must be good."""
        from coopenv.logs import Layout

        if (self.row is None) == (self.at is None):
            got = "none" if self.row is None else "both"
            raise InvalidInput(
                f"one of row and at must be given with a file, got {got}; for example --row 1"
            )
        layout = Layout.load(self.layout, **({} if self.grips is None else {"grips": self.grips}))
        if self.row is not None:
            row = whole(self.row, "row", at_least=1)
        else:
            row = _nearest(file, layout, number(self.at, "at"))
        applied, grips = _row(file, layout, row)
        return applied, grips, f"row {row}"

    def _picture(self, where: str) -> Path:
        if self.file is None:
            return Path("split.png")
        return self.file.with_name(f"{self.file.stem}.{where.replace(' ', '')}.png")


def _shaped(values: tuple[float, ...], name: str, shape: tuple[int, ...]) -> FloatArray:
    """Numbers of the command line as rows, one an effector."""
    if len(values) != shape[0] * shape[1]:
        raise InvalidInput(
            f"{name} must be {shape[0] * shape[1]} numbers, got {len(values)}; give {shape[1]} for "
            "each effector"
        )
    return np.array(values, dtype=np.float64).reshape(shape)


def _row(file: Path, layout: Any, row: int) -> tuple[FloatArray, FloatArray]:
    """Applied wrench and grips of a row, counted from 1."""
    from coopenv.logs.recording import Reader

    before = 0
    for recording in Reader(file, layout, bad_rows="skip"):
        place = row - 1 - before
        if place < len(recording):
            if not recording.good[place]:
                raise InvalidInput(
                    f"row must be one that can be used, got {row} of {file}; coopenv decompose "
                    "says what is wrong with it"
                )
            grips = recording.grips
            return recording.applied[place], grips if grips.ndim == 2 else grips[place]
        before += len(recording)
    raise InvalidInput(f"row must be at most {before}, got {row}; {file} has no more rows")


def _nearest(file: Path, layout: Any, time: float) -> int:
    """The good row nearest to a time, counted from 1."""
    from coopenv.logs.recording import Reader

    best, found, before = np.inf, 0, 0
    first, last = np.inf, -np.inf
    for recording in Reader(file, layout, bad_rows="skip"):
        if recording.time is None:
            raise InvalidInput(
                f"at must be left out for a file without times, got {time:g}; give --row instead"
            )
        apart = np.where(recording.good, np.abs(recording.time - time), np.inf)
        good = recording.time[recording.good]
        first, last = good.min(initial=first), good.max(initial=last)
        place = int(apart.argmin())
        if apart[place] < best:
            best, found = float(apart[place]), before + place + 1
        before += len(recording)
    if not found:
        raise InvalidInput(
            f"file must have rows that can be used, got none in {file}; coopenv decompose says why"
        )
    if not first <= time <= last:
        raise InvalidInput(
            f"at must be from {first:.10g} to {last:.10g} s, the first and the last good row of "
            f"{file}, got {time:.10g}; times are in seconds, as the recording counts them"
        )
    return found
