"""Runs of rows that follow one another, worked on as a whole though they come chunk by chunk.

What needs rows before and after each (filters, derivatives, delays) gets the run with so many rows
on either side of those that are wanted, so that memory does not grow with the file. What comes out
is what the whole run at once would give, up to what the work makes of rows further away.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.recorded.rows import Recording

GAP = 5.0  # usual steps of time that part a run from the next
JITTER = 0.01  # of a step, up to which times count as even
MOST_MARGIN = 200_000  # rows on either side that are held

Work = Callable[[Recording, float], Recording]


def by_runs(
    recordings: Iterable[Recording],
    work: Work,
    margin: Callable[[float], int],
    skip: Callable[[Recording], Recording] = lambda rows: rows,
) -> Iterator[Recording]:
    """Recordings after some work on every run: good rows of a trial without a gap in time.

    Parameters
    ----------
    recordings
        With a time, in the order of the file.
    work
        Called with consecutive rows of a run and their rate [Hz], which is NaN where a file has one
        row; returns as many rows.
    margin
        Of the rate: how many rows on either side matter to a row.
    skip
        What is made of rows that are not good.

    Raises
    ------
    InvalidInput
        If a margin is longer than what may be held.
    """
    state = _State(work, margin, skip)
    for recording in recordings:
        yield from state.advance(recording)
    yield from state.finish()


class _State:
    """Rows that wait for those after them."""

    def __init__(self, work: Work, margin: Callable[[float], int], skip: Callable):
        self._work, self._margin, self._skip = work, margin, skip
        self._held: Recording | None = None
        self._out = 0  # rows at the front of those held that went out before
        self._rate = np.nan
        self._reach = 0

    def advance(self, recording: Recording) -> Iterator[Recording]:
        """What is ready once these rows are there."""
        held = self._held
        self._held = recording if held is None else Recording.joined([held, recording])
        if not self._rate > 0:
            self._rate = usual_rate(self._held)
            if not self._rate > 0:
                return
            self._reach = self._margin(self._rate)
            if self._reach > MOST_MARGIN:
                raise InvalidInput(
                    f"filters must reach over at most {MOST_MARGIN:,} rows, got {self._reach:,} at "
                    f"{self._rate:.6g} rows a second; raise the cutoff or shorten the window"
                )
        yield from self._ready(self._held, last=False)

    def finish(self) -> Iterator[Recording]:
        """The rows that waited."""
        if self._held is not None and self._out < len(self._held):
            yield from self._ready(self._held, last=True)

    def _ready(self, held: Recording, *, last: bool) -> Iterator[Recording]:
        parts, first = [], 0
        for first, end in pairwise(run_ends(held, self._rate)):
            start = max(first, self._out)
            if start >= end:
                continue
            if not held.good[first]:
                parts.append(self._skip(held.take(slice(start, end))))
                self._out = end
                continue
            until = end if last or end < len(held) else end - self._reach
            if until > start:
                low = max(first, start - self._reach)
                made = self._work(held.take(slice(low, end)), self._rate)
                parts.append(made.take(slice(start - low, until - low)))
                self._out = until
        keep = max(min(first, self._out), self._out - self._reach, 0)
        self._held, self._out = held.take(slice(keep, None)), self._out - keep
        if parts:
            yield parts[0] if len(parts) == 1 else Recording.joined(parts)


def run_ends(recording: Recording, rate: float) -> list[int]:
    """Where runs begin, and the end of the last; rows that are not good make runs of their own."""
    broken = np.diff(recording.good) | (np.diff(recording.trial) != 0)
    if recording.time is not None and rate > 0:
        broken |= np.diff(recording.time) > GAP / rate  # False where there is no number
    return [0, *(np.flatnonzero(broken) + 1).tolist(), len(recording)]


def usual_rate(recording: Recording) -> float:
    """Rows a second, from the median of the steps; NaN where there is none."""
    if recording.time is None:
        return np.nan
    step = np.diff(recording.time[recording.good])
    forward = step[step > 0]
    return 1 / float(np.median(forward)) if len(forward) else np.nan


def evenly(
    time: FloatArray, values: FloatArray, rate: float, work: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """What some work, which needs equal steps, makes of values ``(T, ...)`` at uneven times.

    They are taken from the straight lines between the rows at equal steps, worked on there, and
    what comes out is taken back to the rows' times alike. Equal steps are left alone.
    """
    if len(time) < 2 or (np.abs(np.diff(time) * rate - 1) <= JITTER).all():
        return work(values)
    grid = np.arange(np.floor(time[0] * rate), np.ceil(time[-1] * rate) + 1) / rate
    even = work(_between(time, values, grid))
    return _between(grid, even, time)


def _between(time: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    flat = values.reshape(len(values), -1)
    made = np.stack([np.interp(at, time, column) for column in flat.T], axis=-1)
    return made.reshape(len(at), *values.shape[1:])
