"""Reader of recordings of trials: SI units, object frame, y up."""

import math
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.files import reading
from coopenv.logs.assumptions import assumptions
from coopenv.logs.columns import ORIENTATION
from coopenv.logs.convert import Measured, in_si, turned_over
from coopenv.logs.corrections import Corrections
from coopenv.logs.declared.stamps import Stamps, is_form
from coopenv.logs.faults import Faults
from coopenv.logs.formats.chunks import Chunk, Column, Roles, Wanted
from coopenv.logs.joining import open_recording
from coopenv.logs.layout import Layout
from coopenv.logs.limits import require_short_names, shown
from coopenv.logs.plan import make_plan
from coopenv.logs.recorded import Recording
from coopenv.logs.recorded.devices import Devices
from coopenv.logs.trials import Trials

__all__ = ["Reader", "Recording", "naming", "read"]

WARNING = "warning: "  # notes that begin so are warnings
EXACT = 2.0**53  # whole numbers below are floats without rounding


def read(
    path: str | os.PathLike, layout: Layout | None = None, *, bad_rows: str = "error"
) -> Recording:
    """Read a file of recorded trials, of any format on docs/recordings.md.

    Parameters
    ----------
    path
        Of the file; docs/recordings.md lists the columns.
    layout
        How they are called, their frames and units; the documented ones if ``None``.
    bad_rows
        ``"error"``: raise at the first row that cannot be used; ``"skip"``: make it NaN.

    Returns
    -------
    All rows. What a CSV file carries is text; a column of which all values are numbers is made so.

    Raises
    ------
    InvalidInput
        If the file, a column or a row is wrong; the message names file, line and column.
    MissingExtra
        If reading it needs the extra ``analysis``.
    """
    reader = Reader(path, layout, bad_rows=bad_rows)
    recording = Recording.joined(list(reader))
    recording = replace(recording, done=reader.done)  # some of it is known at the end alone
    for note in reader.notes:
        if note.startswith(WARNING):
            warnings.warn(note.removeprefix(WARNING), stacklevel=2)
    decimal = layout.decimal if layout is not None else "."
    carried = {name: _as_numbers(column, decimal) for name, column in recording.carried.items()}
    recording.carried.update(carried)
    return recording


class Reader:
    """A file as a sequence of recordings of some thousand rows each.

    Parameters
    ----------
    path, layout, bad_rows
        See `read`.
    """

    def __init__(
        self, path: str | os.PathLike, layout: Layout | None = None, *, bad_rows: str = "error"
    ):
        self.path = os.fspath(path)
        given = layout if layout is not None else Layout()
        with naming(self.path):
            source, self.layout = open_recording(path, given, strict=bad_rows != "skip")
        self._source = source
        theirs = self.layout.columns.values()
        with naming(self.path):
            source.offer([name for each in theirs for name in (each, each.removeprefix("-"))])
        columns = source.columns
        require_short_names(self.path, (*columns, *source.left_out))
        with naming(self.path):
            plan = make_plan(
                self.path,
                columns,
                self.layout,
                grips_in_file=source.grips is not None,
                units=source.units,
                repeated=source.repeated,
            )
            self.plan = plan.without(source.made)
            source.assign(self._roles())
            self._corrections = Corrections(
                self.path,
                given,
                self.plan,
                lambda path, layout: Reader(path, layout, bad_rows=bad_rows),
            )
        self.faults = Faults(self.path, columns, self.plan, bad_rows, source.num_fields)
        self.left_out = [*source.left_out, *self.plan.unused]
        self.progress = 0.0  # share of the file that has been read
        self._grips = self._constant_grips()
        self.assumed = assumptions(self.layout, self.plan, self._grips)

    @property
    def devices(self) -> Devices | None:
        """Whose pose and wrenches are, where several devices are joined."""
        return Devices.of(self.plan, self._source.owners)

    @property
    def notes(self) -> tuple[str, ...]:
        """What there is to say once all rows are read."""
        return (*self.faults.notes, *self._source.notes)

    @property
    def done(self) -> tuple[str, ...]:
        """Corrections, as sentences; known once reading has begun."""
        return self._corrections.done

    def __iter__(self) -> Iterator[Recording]:
        return self._corrections(self._recorded())

    def _recorded(self) -> Iterator[Recording]:
        """As it is in the file, but for units and frames."""
        plan = self.plan
        trials = Trials(self._trial_columns())
        time_column = plan.source.get("time")
        rows = 0
        for chunk in self._chunks():
            time = chunk.numbers[time_column] if time_column else np.full(chunk.rows, np.nan)
            trial, starts, previous = trials.of(chunk.carried, time, chunk.whole)
            good = self.faults.good_rows(chunk, starts, previous)
            self.progress, rows = chunk.progress, rows + chunk.rows
            yield self._converted(chunk, trial, good)
        if not rows:
            raise InvalidInput(f"{self.path} must have rows of data, got none; record some")

    def _chunks(self) -> Iterator[Chunk]:
        """Those of the file; what is damaged further on shows only here."""
        numbers = list(dict.fromkeys(self.plan.source.values()))
        wanted = Wanted(numbers, self.plan.carried, self._stamps())
        chunks = self._source.chunks(wanted)
        while True:
            with reading(self.path):
                chunk = next(chunks, None)
            if chunk is None:
                return
            yield chunk

    def _roles(self) -> Roles:
        """What the columns are that are not only numbers."""
        source, names = self.plan.source, ORIENTATION[self.plan.dimension]
        there = tuple(source[name] for name in names if name in source)
        return Roles(
            time=source.get("time", ""),
            factor=self.layout.factor("time"),
            quaternion=there if len(there) == 4 else (),
            angle=source.get("theta", ""),
            period=math.tau / abs(self.plan.factor.get("theta", 1.0)),
        )

    def _stamps(self) -> dict[str, Stamps]:
        """Columns that are times as text."""
        form, time = self.layout.time, self.plan.source.get("time")
        return {time: Stamps(form)} if time is not None and is_form(form) else {}

    def _trial_columns(self) -> list[str]:
        """Those there are; the default ones need not be."""
        said, known = self.layout.trial_columns, self.plan.carried
        for name in said:
            if name not in known and said != Layout().trial_columns:
                raise InvalidInput(
                    f"{self.path}: trial_columns must be columns that are carried, got {name!r}; "
                    f"has: {', '.join(map(shown, known[:30])) or 'none'}"
                )
        return [name for name in said if name in known]

    def _constant_grips(self) -> FloatArray | None:
        """Grips that were said once [m]."""
        in_file, plan = self._source.grips, self.plan
        if in_file is None:
            grips = self.layout.grips_of(plan.num_effectors)
        else:
            grips = self._checked_grips(in_file)
        return turned_over(grips) if grips is not None and self.layout.y == "down" else grips

    def _checked_grips(self, in_file: FloatArray) -> FloatArray:
        """Grips that the file holds [m]."""
        plan = self.plan
        with naming(self.path):
            layout = replace(self.layout, grips=tuple(in_file.ravel().tolist()), space="auto")
            grips = layout.grips_of(plan.num_effectors)
        assert grips is not None
        if self.layout.space == "plane":
            grips = grips[:, :2]
        if grips.shape[1] != plan.dimension:
            raise InvalidInput(
                f"{self.path}: grips must be of {plan.dimension} numbers each like the forces, got "
                f"{grips.shape[1]}; change them, or say --space plane"
            )
        return grips

    def _converted(self, chunk: Chunk, trial: IntArray, good: BoolArray) -> Recording:
        """The rows in SI units, object frame, y up."""
        plan, layout = self.plan, self.layout
        with np.errstate(over="ignore", invalid="ignore"):  # of rows that are not good
            measured = Measured.of(chunk, plan, layout.forces_only)
            if layout.y == "down":
                measured.turn_over()
            if "world" in (layout.frame, layout.twist_frame, layout.grip_frame):
                measured.turn_to_object(layout, good)
            time = in_si(chunk, plan, "time") if plan.has(["time"]) else None
        applied = np.concatenate([measured.force, measured.torque], axis=-1)
        for array in (applied, measured.twist, measured.grips, measured.out_of_plane):
            if array is not None:
                array[~good] = np.nan
        grips = measured.grips if measured.grips is not None else self._grips
        assert grips is not None
        return Recording(
            time=time,
            applied=applied,
            grips=grips,
            position=measured.position,
            orientation=measured.orientation,
            twist=measured.twist,
            carried=chunk.carried,
            trial=trial,
            good=good,
            out_of_plane=measured.out_of_plane,
        )


@contextmanager
def naming(path: str) -> Iterator[None]:
    """Name the file of a recording in what is refused, where that does not do so itself."""
    try:
        yield
    except InvalidInput as error:
        if path in str(error):
            raise
        raise InvalidInput(f"{path}: {error}") from error


def _as_numbers(column: Column, decimal: str) -> Column:
    """A column of text as numbers, if that is what all of it says."""
    if column.dtype.kind not in "OU":
        return column
    texts = column.tolist()
    foreign = "_" if decimal == "." else "_."  # 1.234 may be meant as 1,234: it stays text
    try:
        if any(sign in text for text in texts for sign in foreign):
            return column
        numbers = np.array([float(text.replace(decimal, ".")) for text in texts])
    except (AttributeError, TypeError, ValueError):
        return column
    exact = (np.abs(numbers) < EXACT).all()  # not where one is NaN
    whole = numbers.astype(np.int64) if exact else numbers
    return whole if (whole == numbers).all() else numbers
