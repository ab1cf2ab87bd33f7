"""``coopenv show``: the split of one wrench, as a picture and as a table."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from coopenv.arrays import FloatArray, number, whole
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import require_writable, written

if TYPE_CHECKING:
    from rich.table import Table

    from coopenv.wrench import Decomposition
try:
    import tyro
except ImportError:  # asked for where the command line is read
    POSITIONAL: Any = None
else:
    POSITIONAL = tyro.conf.Positional

SUFFIXES = (".png", ".svg", ".pdf")
DPI = 150  # of PNG
WIDEST = 400  # letters that a table may need, however narrow the terminal
COMPONENTS = {
    3: ("fx [N]", "fy [N]", "tz [N·m]"),
    6: ("fx [N]", "fy [N]", "fz [N]", "tx [N·m]", "ty [N·m]", "tz [N·m]"),
}


@dataclass(frozen=True, kw_only=True)
class Show:
    """Draw the split of one wrench, and print it: of given numbers, or of a row of a recording.

    coopenv show --grips -0.9 0 0.9 0 --applied 3 0 0 -1 0 0
    coopenv show trial.csv --row 120
    """

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

    def run(self) -> None:
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
        for line in self._said(split, internal):
            console.print(line, markup=False, highlight=False, soft_wrap=True)
        with written(out) as part:
            axes.figure.savefig(part, format=out.suffix[1:].lower(), dpi=DPI)
        console.print(f"wrote {out}", markup=False, highlight=False, soft_wrap=True)

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

    def _said(self, split: "Decomposition", internal: FloatArray) -> list[str]:
        """Costs, shares, and whether the split is plausible."""
        from coopenv.wrench import cost, is_plausible, residuals

        kept = is_plausible(split.applied, internal, split.grips)
        left = residuals(split.applied, internal, split.grips)
        weights = {"torque_weight": self.torque_weight, "include_induced": self.include_induced}
        after = float(cost(split.applied - internal, split.grips, **weights))
        share = split.load_share
        return [
            f"J(h) = {split.applied_cost:.4g} N, J(h_M) = {after:.4g} N (w = "
            f"{self.torque_weight:g}, s = {int(self.include_induced)})",
            f"load share: force {_numbers(share.force)}, torque {_numbers(share.torque)}",
            f"{'plausible and balanced' if kept else 'NOT plausible'}: off balance by "
            f"{left.balance:.1e} N or N·m, beyond eqs. 9-11 by {left.force:.1e} N, "
            f"{left.induced_torque:.1e} and {left.torque:.1e} N·m",
        ]


def split_table(applied: FloatArray, internal: FloatArray, title: str) -> "Table":
    """Applied, manipulation and internal wrench of each effector, as a rich table."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), title_justify="left", box=SIMPLE_HEAD, show_edge=False)
    table.add_column("effector", justify="right")
    table.add_column("wrench")
    for name in COMPONENTS[applied.shape[1]]:
        table.add_column(Text(name), justify="right")
    parts = (("applied", applied), ("manipulation", applied - internal), ("internal", internal))
    for i in range(len(applied)):
        for name, wrench in parts:
            cells = [f"{value + 0.0:.4g}" for value in np.round(wrench[i], 12)]
            table.add_row(str(i + 1) if name == "applied" else "", name, *cells)
    return table


def _numbers(values: FloatArray) -> str:
    return "/".join("undefined" if np.isnan(each) else f"{each + 0.0:.3g}" for each in values)


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
