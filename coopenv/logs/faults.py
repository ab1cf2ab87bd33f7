"""Validation of recorded rows: bad ones are named, or counted and passed over."""

from collections.abc import Callable

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import InvalidInput, UnknownName
from coopenv.logs.columns import ORIENTATION
from coopenv.logs.declared.stamps import written_as
from coopenv.logs.formats.chunks import Chunk
from coopenv.logs.layout import LARGEST
from coopenv.logs.limits import shown
from coopenv.logs.plan import Plan

BAD_ROWS = ("error", "skip")
MARKS = {-1: "an open quotation mark", -2: "a carriage return within"}  # instead of a number
QUATERNION_TOLERANCE = 0.01  # of its length


class Faults:
    """What to do with bad rows, and how many there were.

    Parameters
    ----------
    path
        Named in errors.
    columns
        Of the file.
    plan
        Which of them are read as what.
    bad_rows
        ``"error"`` or ``"skip"``.
    num_fields
        That a row of the file has, if some of ``columns`` are made of others.
    """

    def __init__(
        self,
        path: str,
        columns: list[str],
        plan: Plan,
        bad_rows: str,
        num_fields: int | None = None,
    ):
        if bad_rows not in BAD_ROWS:
            raise UnknownName("bad_rows", bad_rows, BAD_ROWS)
        self.count = 0
        self.first = ""  # what is wrong with the first
        self._row: int | None = None  # its number
        self._equal, self._first_equal = 0, ""  # rows with the time of the row before
        self._num_fields = len(columns) if num_fields is None else num_fields
        self._path, self._columns, self._plan, self._bad_rows = path, columns, plan, bad_rows

    def good_rows(self, chunk: Chunk, starts: BoolArray, previous_time: FloatArray) -> BoolArray:
        """Which rows can be used.

        Parameters
        ----------
        chunk
            As read.
        starts
            ``(T,)`` whether a row is the first of its trial.
        previous_time
            ``(T,)`` last time before each row, in the unit of the file.

        Raises
        ------
        InvalidInput
            At the first bad row, unless they are to be skipped.
        """
        good = np.ones(chunk.rows, dtype=np.bool_)
        for find in (
            self._ragged,
            self._not_finite,
            self._beyond_measure,
            self._time,
            self._quaternion,
        ):
            for bad, describe in find(chunk, starts, previous_time):
                if bad.any():
                    good &= ~bad
                    self._report(chunk, bad, describe)
        self.count += int((~good).sum())
        if self.first and self._bad_rows == "error":
            raise InvalidInput(self.first)
        return good

    def _report(self, chunk: Chunk, bad: BoolArray, describe: Callable[[int], str]) -> None:
        """Describe the first bad row of all; of its faults, the one found first."""
        row = int(np.flatnonzero(bad)[0])
        if self._row is not None and chunk.first_row + row >= self._row:
            return
        self._row = chunk.first_row + row
        self.first = (
            f"{self._path}, {chunk.place(row)}{describe(row)}; repair it, or pass over bad rows "
            "with --bad-rows skip"
        )

    def _ragged(self, chunk: Chunk, *_: object):
        if chunk.fields is not None:
            fields = chunk.fields

            def describe(row: int) -> str:
                seen = MARKS.get(int(fields[row]), f"{fields[row]} fields")
                return f" must have {self._num_fields} fields like the header, got {seen}"

            yield fields != 0, describe

    def _not_finite(self, chunk: Chunk, *_: object):
        for name in self._required():
            column = self._plan.source[name]
            called = chunk.called(column) + (f" ({name})" if name != column else "")
            yield (
                chunk.whole & ~np.isfinite(chunk.numbers[column]),
                lambda row, name=name, column=column, called=called: (
                    f", {called} must be {chunk.rules.get(column, chunk.rule)}, got "
                    f"{shown(chunk.text(row, column))!r}"
                    + (self._as_text(chunk, chunk.text(row, column)) if name == "time" else "")
                ),
            )

    def _as_text(self, chunk: Chunk, text: str) -> str:
        """What to say of a time that is written as text, where numbers were declared."""
        form = "" if self._plan.source["time"] in chunk.rules else written_as(text)
        return f', a time as text: say --time "{form}"' if form else ""

    def _beyond_measure(self, chunk: Chunk, *_: object):
        for name in self._required():
            column, factor = self._plan.source[name], self._plan.factor[name]
            yield (
                np.abs(chunk.numbers[column]) > LARGEST / abs(factor),
                lambda row, column=column: (
                    f", column {column!r} must be at most {LARGEST:g} in SI units, got "
                    f"{shown(chunk.text(row, column))!r}"
                ),
            )

    def _time(self, chunk: Chunk, starts: BoolArray, previous: FloatArray):
        if self._plan.has(["time"]):
            column = self._plan.source["time"]
            time = chunk.numbers[column]
            bad = ~starts & (time < previous)
            self._count_equal(chunk, ~starts & (time == previous))
            yield (
                bad,
                lambda row: (
                    f", column {column!r} must increase within a trial, got {time[row]:.12g} after "
                    f"{previous[row]:.12g}"
                ),
            )

    def _count_equal(self, chunk: Chunk, equal: BoolArray) -> None:
        """Equal time stamps are told, and cost nothing."""
        if equal.any():
            self._equal += int(equal.sum())
            self._first_equal = self._first_equal or chunk.place(int(np.flatnonzero(equal)[0]))

    @property
    def notes(self) -> tuple[str, ...]:
        """What is odd about rows that are good all the same."""
        if not self._equal:
            return ()
        return (
            f"warning: {self._equal:,} rows of {self._path} have the time of the row before, the "
            f"first in {self._first_equal}",
        )

    def _quaternion(self, chunk: Chunk, *_: object):
        names = ORIENTATION[3]
        if self._plan.dimension == 3 and self._plan.required >= set(names):
            parts = np.stack([chunk.numbers[self._plan.source[name]] for name in names])
            with np.errstate(over="ignore"):  # of those that are none
                length = np.sqrt((parts * parts).sum(axis=0))
            yield (
                np.abs(length - 1) > QUATERNION_TOLERANCE,
                lambda row: (
                    ", columns qw, qx, qy, qz must be a unit quaternion, got one of length "
                    f"{length[row]:.6g}"
                ),
            )

    def _required(self) -> list[str]:
        """In the order of the file, so that the leftmost fault of a row is named."""
        place = {column: number for number, column in enumerate(self._columns)}
        return sorted(self._plan.required, key=lambda name: place[self._plan.source[name]])
