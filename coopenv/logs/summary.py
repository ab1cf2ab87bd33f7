"""Summary of a decomposed recording: what was assumed, means, percentiles, residuals, bad rows."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import MissingExtra
from coopenv.files import plain
from coopenv.logs.analysis import Analysis, Worst
from coopenv.logs.consistency import Consistency
from coopenv.logs.consistency.told import motion_lines
from coopenv.logs.limits import legible
from coopenv.logs.recording import Recording

if TYPE_CHECKING:
    from rich.console import Console

SAMPLE = 1 << 18  # values from which percentiles are taken; more rows are thinned evenly
MEASURES = (  # columns, all those that begin with the name; unit
    ("relative_cost", ""),
    ("wasted_cost", "N"),
    ("internal_force_level", "N"),
    ("internal_torque_level", "N·m"),
    ("force_load_share", ""),
    ("torque_load_share", ""),
    ("energy_share", ""),
    ("internal_power", "W"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Measure:
    """One column over all rows in which it is defined; NaN where there are none."""

    name: str
    unit: str
    mean: float
    median: float  # percentiles are exact up to `SAMPLE` rows, of an even sample beyond
    low: float  # 5th percentile
    high: float  # 95th percentile
    largest: float
    undefined: float  # share of the good rows, in [0, 1]


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Result of `coopenv.logs.decompose_file`."""

    table: Path
    picture: Path | None
    written: Path  # this, as JSON
    rows: int
    bad_rows: int
    first_bad: str  # what is wrong with the first of them
    trials: int
    duration: float | None  # of all trials together [s]
    method: str
    solver: str
    fallbacks: int  # rows for which the solver had to ask another one
    gap: float  # largest bound on how far a cost is from the optimum [N]
    worst: Worst
    measures: tuple[Measure, ...]
    left_out: tuple[str, ...]  # what the file holds beside columns, and columns not used
    assumed: tuple[str, ...]  # frames, signs, units and grips, as declared or by default
    consistency: Consistency  # whether that goes with how the object moved
    notes: tuple[str, ...] = ()  # what reading the file met: equal times, rows joined, gaps filled
    done: tuple[str, ...] = ()  # corrections
    old_picture: Path | None = None  # of an earlier table of that name, if none was drawn now

    def print(self, console: "Console") -> None:
        """Print it as lines and a table of the measures."""
        try:
            from rich.box import SIMPLE_HEAD
            from rich.table import Table
        except ImportError as error:
            raise MissingExtra("the summary", "analysis") from error
        for line in self._lines():
            console.print(line, markup=False, highlight=False)
        table = Table(box=SIMPLE_HEAD, padding=0, pad_edge=False)
        longest = max(len(seen.name) for seen in self.measures)
        table.add_column("", min_width=longest)  # units go to the next line where there is no room
        for title in ("mean", "median", "5 %", "95 %", "largest", "undefined"):
            table.add_column(title, justify="right", no_wrap=True)
        for seen in self.measures:
            name = seen.name + (f" [{seen.unit}]" if seen.unit else "")
            numbers = (seen.mean, seen.median, seen.low, seen.high, seen.largest)
            cells = ["-" if np.isnan(value) else f"{value:.3g}" for value in numbers]
            table.add_row(name.replace("[", "\\["), *cells, f"{100 * seen.undefined:.1f} %")
        room = console.options.update(width=10 * console.width)
        least = console.measure(table, options=room).minimum
        console.print(table, width=max(console.width, least), crop=False)  # never cut a column

    def _lines(self) -> list[str]:
        rows = f"{self.rows:,} rows"
        if self.trials > 1:
            rows += f", {self.trials:,} trials"
        if self.duration is not None:
            rows += f", {self.duration:,.3f} s"
        lines = [f"{rows}; {self.method} by {self.solver}"]
        if self.bad_rows:
            lines.append(f"{self.bad_rows:,} bad rows are NaN; the first: {self.first_bad}")
        if self.left_out:
            lines.append(f"left out, as no columns or not used: {', '.join(self.left_out)}")
        if self.old_picture is not None:
            lines.append(f"{legible(self.old_picture)} was there before and shows another table")
        lines += [*self.notes, *(f"assumed {line}" for line in self.assumed)]
        lines += [f"corrected {line}" for line in self.done]
        lines += motion_lines(self.consistency)
        worst = self.worst
        lines.append(
            f"worst residuals: balance {worst.balance:.1e} N or N·m, force {worst.force:.1e} N, "
            f"induced torque {worst.induced_torque:.1e} N·m, torque {worst.torque:.1e} N·m; "
            f"largest gap {self.gap:.1e} N; {self.fallbacks:,} fallbacks"
        )
        return lines

    def save(self, path: Path) -> None:
        """Write it as JSON; what is undefined is null."""
        content = plain(self, path=legible)
        path.write_text(json.dumps(content, indent=2, ensure_ascii=False), "utf-8")


class Collector:
    """Running sums over an analysis that comes chunk by chunk."""

    def __init__(self):
        self._columns: dict[str, _Column] = {}
        self._rows = self._fallbacks = 0
        self._gap = 0.0
        self._worst = Worst()
        self._solvers: dict[str, None] = {}
        self._trial, self._time, self._duration = -1, np.nan, 0.0
        self._timed = False

    def add(self, recording: Recording, analysis: Analysis) -> None:
        """Append rows."""
        for name, unit in MEASURES:
            for column in analysis.results:
                if column == name or column.removeprefix(f"{name}_").isdigit():
                    kept = self._columns.setdefault(column, _Column(unit))
                    kept.add(analysis[column][recording.good])
        self._rows += len(recording)
        self._fallbacks += analysis.fallbacks
        self._gap = max(self._gap, analysis.gap)
        self._worst = Worst(*map(max, self._worst, analysis.worst))
        self._solvers[analysis.solver] = None
        self._add_time(recording)

    def summary(
        self,
        *,
        table: Path,
        picture: Path | None,
        written: Path,
        method: str,
        bad_rows: int,
        first_bad: str,
        left_out: tuple[str, ...],
        assumed: tuple[str, ...],
        consistency: Consistency,
        notes: tuple[str, ...] = (),
        done: tuple[str, ...] = (),
        old_picture: Path | None = None,
    ) -> Summary:
        """Summary of all rows so far, with what only the caller knows."""
        return Summary(
            table=table,
            picture=picture,
            written=written,
            rows=self._rows,
            bad_rows=bad_rows,
            first_bad=legible(first_bad),
            trials=self._trial + 1,
            duration=self._duration if self._timed else None,
            method=method,
            solver=", ".join(self._solvers),
            fallbacks=self._fallbacks,
            gap=self._gap,
            worst=self._worst,
            measures=tuple(kept.measure(name) for name, kept in self._columns.items()),
            left_out=left_out,
            assumed=assumed,
            done=done,
            consistency=consistency,
            notes=tuple(map(legible, notes)),
            old_picture=old_picture,
        )

    def _add_time(self, recording: Recording) -> None:
        trial = np.concatenate([[self._trial], recording.trial[recording.good]])
        if recording.time is not None:
            self._timed = True
            time = np.concatenate([[self._time], recording.time[recording.good]])
            same = trial[1:] == trial[:-1]
            self._duration += float(np.diff(time)[same].sum())
            self._time = float(time[-1])
        self._trial = int(recording.trial[-1]) if len(trial) == 1 else int(trial[-1])


class _Column:
    """Sums and an even sample of a column."""

    def __init__(self, unit: str):
        self._unit = unit
        self._rows = self._defined = 0
        self._sum, self._largest = 0.0, -np.inf
        self._every = 1  # one row in so many is kept
        self._kept: list[FloatArray] = []
        self._count = 0

    def add(self, values: FloatArray) -> None:
        """Append rows."""
        defined = values[~np.isnan(values)]
        self._kept.append(values[-self._rows % self._every :: self._every].copy())
        self._count += len(self._kept[-1])
        self._rows, self._defined = self._rows + len(values), self._defined + len(defined)
        if len(defined):
            self._sum += float(defined.sum())
            self._largest = max(self._largest, float(defined.max()))
        if self._count > SAMPLE:
            self._every *= 2
            self._kept = [np.concatenate(self._kept)[::2]]
            self._count = len(self._kept[0])

    def measure(self, name: str) -> Measure:
        """Statistics of all rows so far."""
        values = np.concatenate(self._kept)
        values = values[~np.isnan(values)]
        low, median, high = np.percentile(values, (5, 50, 95)) if len(values) else [np.nan] * 3
        return Measure(
            name=name,
            unit=self._unit,
            mean=self._sum / self._defined if self._defined else np.nan,
            median=float(median),
            low=float(low),
            high=float(high),
            largest=self._largest if self._defined else np.nan,
            undefined=1 - self._defined / self._rows if self._rows else 1.0,
        )
