"""Clock of a recorded file: which column is time, in which unit, its rate and gaps."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.declared.stamps import ISO, written_as
from coopenv.logs.declared.units import UNITS, is_unit, known_unit
from coopenv.logs.formats.chunks import Column
from coopenv.logs.inspected.words import unit_in, words_of

GAP = 5.0  # usual steps, from which one is a gap
TIMES = ("time", "timestamp", "stamp", "t", "sec", "secs", "seconds", "date", "datetime")
SINCE_1970 = (("ns", 1e17), ("us", 1e14), ("ms", 1e11))  # what such times are at least


@dataclass(frozen=True, slots=True, kw_only=True)
class Clock:
    """Times of a file."""

    column: str
    unit: str  # of `UNITS`, or how times are written
    said: bool  # whether the file says so, its name or its text; else it is a guess
    rate: float  # [Hz] of the median step; NaN for fewer than two rows
    begin: float  # [s]
    end: float
    gaps: int  # steps of more than `GAP` usual ones
    longest: float  # [s] of them
    equal: int  # rows with the time of the row before
    falls: int  # rows with an earlier one


class Ticks:
    """Times that come chunk by chunk."""

    def __init__(self):
        self._usual = self._last = self._begin = math.nan
        self._gaps = self._equal = self._falls = 0
        self._longest = 0.0
        self._end = -math.inf

    def add(self, time: FloatArray) -> None:
        """Append rows."""
        time = time[np.isfinite(time)]
        if not len(time):
            return
        if math.isnan(self._begin):
            self._begin = float(time[0])
        step = np.diff(time, prepend=[] if math.isnan(self._last) else [self._last])
        self._last, self._end = float(time[-1]), max(self._end, float(time.max()))
        forward = step[step > 0]
        if math.isnan(self._usual) and len(forward):
            self._usual = float(np.median(forward))
        self._equal += int((step == 0).sum())
        self._falls += int((step < 0).sum())
        gaps = step[step > GAP * self._usual]
        self._gaps += len(gaps)
        self._longest = max(self._longest, float(gaps.max(initial=0.0)))

    def clock(self, column: str, form: str, unit: str) -> Clock:
        """What they tell; ``form`` is that of times as text, ``unit`` what the file says."""
        known, said = (form, True) if form else self._unit(column, unit)
        factor = UNITS["time"].get(known, 1.0)
        return Clock(
            column=column,
            unit=known,
            said=said,
            rate=1 / (self._usual * factor),
            begin=self._begin * factor,
            end=self._end * factor,
            gaps=self._gaps,
            longest=self._longest * factor,
            equal=self._equal,
            falls=self._falls,
        )

    def _unit(self, column: str, unit: str) -> tuple[str, bool]:
        """Of numbers: as the file or the name says, else by their size and steps."""
        if unit and is_unit(unit):
            return known_unit("time", unit), True
        named = unit_in(column, "time")
        if named:
            return named, True
        for known, least in SINCE_1970:
            if abs(self._begin) >= least:
                return known, False
        # slower than one a second nobody records a trial: steps of 1, 2, 10 are milliseconds
        return ("ms" if self._usual >= 1 and self._begin < 1e9 else "s"), False


def time_column(
    columns: Sequence[str], numbers: Sequence[str], first: Mapping[str, Column]
) -> str | None:
    """The column that looks like time by its name, the plainest name first."""
    usable = [name for name in columns if name in numbers or form_of(first[name])]
    for wanted in TIMES:
        for name in usable:
            own = re.split(r"[./]", name)[-1]  # of a field of a structure, or in a group
            if own.lower() == wanted or words_of(name)[:1] == [wanted]:
                return name
    for name in usable:
        if {"time", "timestamp", "stamp"} & set(words_of(name)):
            return name
    return None


def form_of(values: Column) -> str:
    """How times as text are written, if this is what the first of them look like; else empty."""
    if values.dtype.kind == "M":
        return ISO
    if values.dtype.kind not in "OU" or not len(values):
        return ""
    return written_as(str(values[0]))
