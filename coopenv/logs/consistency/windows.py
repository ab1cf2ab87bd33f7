"""Windows of time over recorded rows, and means over them.

What acts on a body is compared with how it moves through their integrals: m v(t) is the impulse
∫ f dt up to a constant. Both are averaged over windows, and differences of neighbouring windows are
fitted, so that neither noise is differentiated nor a constant force (weight) needs to be known.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.logs.faults import QUATERNION_TOLERANCE
from coopenv.logs.layout import LARGEST
from coopenv.logs.recording import Recording

WINDOW = 0.2  # [s] shorter than the motions of people, longer than the delays of sensors
ENOUGH = 6  # rows in a window; of more, some are averaged beforehand
GAP = 5.0  # median steps of time that part what comes before from what comes after


class Segments:
    """Cuts recordings that come chunk by chunk into rows that follow one another.

    A segment is of one trial, without a bad row or a gap in time. What the last chunk left over is
    put before the next, so that windows do not end with a chunk.

    Parameters
    ----------
    enough
        Rows in a window.
    """

    def __init__(self, enough: int = ENOUGH):
        self._enough = enough
        self._rest: Recording | None = None
        self._every = 0  # rows that are averaged first; 0 as long as it is not known
        self._rows = 0  # of these averages in a window

    def of(self, recording: Recording) -> list[tuple[Recording, int]]:
        """Segments that have at least two windows, and how many rows make a window."""
        recording = replace(recording, carried={})
        if self._rest is not None:
            recording = Recording.joined([self._rest, recording])
        if recording.time is None:
            return []
        step = np.diff(recording.time)
        forward = step[step > 0]
        if not len(forward):
            self._rest = recording.take(slice(-1, None))
            return []
        usual = float(np.median(forward))
        if not self._every:
            rows = max(1, round(WINDOW / usual))
            self._every = max(
                1, (rows // self._enough - 1) // 2 * 2 + 1
            )  # odd: one row is the middle
            self._rows = max(1, round(rows / self._every))
        usable = _usable(recording)
        follows = usable[1:] & usable[:-1] & (np.diff(recording.trial) == 0)
        follows &= (step > 0) & (step < GAP * usual)
        cuts = [0, *(np.flatnonzero(~follows) + 1).tolist(), len(recording)]
        used = max(self._windows(*cuts[-2:]) - 1, 0) * self._rows * self._every
        self._rest = recording.take(slice(cuts[-2] + used, None))
        return [
            (_averaged(recording.take(slice(*ends)), self._every), self._rows)
            for ends in pairwise(cuts)
            if self._windows(*ends) >= 2
        ]

    def _windows(self, first: int, last: int) -> int:
        """How many windows of intervals rows have."""
        return ((last - first) // self._every - 1) // self._rows


def at_different_times(recording: Recording) -> Recording:
    """Without the rows of a trial that have the time of the row before."""
    if recording.time is None:
        return recording
    equal = (np.diff(recording.time) == 0) & (np.diff(recording.trial) == 0)
    return recording.take(np.concatenate([[True], ~equal])) if equal.any() else recording


def _averaged(recording: Recording, every: int) -> Recording:
    """Means of so many rows each; the orientation, which may jump, of the one in the middle."""
    if every == 1:
        return recording
    middle = recording.take(slice(every // 2, len(recording) // every * every, every))
    means = {
        name: window_means(values, every)
        for name in ("time", "applied", "position", "twist")
        if (values := getattr(recording, name)) is not None
    }
    return replace(middle, **means)


def _usable(recording: Recording) -> BoolArray:
    """Rows that are good and have the whole pose, if there is one."""
    usable = recording.good
    for values in (recording.position, recording.orientation):
        if values is not None:
            flat = values.reshape(len(values), -1)
            usable = usable & (np.abs(flat) <= LARGEST).all(axis=-1)  # False for NaN
    if recording.orientation is not None and recording.orientation.ndim == 2:
        with np.errstate(over="ignore"):  # of those that are no quaternions
            length = np.linalg.norm(recording.orientation, axis=-1)
        usable = usable & (np.abs(length - 1) < QUATERNION_TOLERANCE)
    return usable


def mean_of_neighbours(values: FloatArray) -> FloatArray:
    """From samples ``(T, …)`` to the intervals ``(T − 1, …)`` between them."""
    return (values[1:] + values[:-1]) / 2


def integral(rate: FloatArray, step: FloatArray) -> FloatArray:
    """∫ of a rate ``(T, …)`` from the start to the middle of each interval of length ``step``."""
    grown = rate * step.reshape(-1, *[1] * (rate.ndim - 1))
    return np.cumsum(grown, axis=0) - grown / 2


def window_means(values: FloatArray, rows: int) -> FloatArray:
    """Means of ``(T, …)`` over windows of so many rows; the last rows are left out."""
    count = len(values) // rows
    return values[: count * rows].reshape(count, rows, *values.shape[1:]).mean(axis=1)
