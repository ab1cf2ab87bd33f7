"""Rows of a recording that are compared with a known body, as runs of even steps."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from coopenv.logs.consistency.known_body.known import Motion, Windows
from coopenv.logs.consistency.windows import Segments, at_different_times
from coopenv.logs.recorded import Recording

MOST_ROWS = 30_000  # that are kept, after averaging to some hundred a second: five minutes
ENOUGH = 20  # rows in a window of `Segments`, of more some are averaged
LEAST = 20  # windows


class Collected:
    """Rows of a recording that comes chunk by chunk, as many as fit in memory."""

    def __init__(self):
        self._segments = Segments(ENOUGH)
        self._kept: list[Recording] = []
        self.rows = 0  # after averaging

    @classmethod
    def of(cls, recordings: Iterable[Recording]) -> "Collected":
        """Of as many recordings as are needed."""
        made = cls()
        for recording in recordings:
            made.add(recording)
            if made.rows >= MOST_ROWS:
                break
        return made

    def add(self, recording: Recording) -> None:
        """Append rows, unless there are enough."""
        if recording.position is None or recording.orientation is None or self.rows >= MOST_ROWS:
            return
        for segment, _ in self._segments.of(at_different_times(recording)):
            if self.rows < MOST_ROWS:
                self._kept.append(replace(segment, carried={}))
                self.rows += len(segment)

    def windows(self) -> list[Windows]:
        """One a run; none where they are too few for evidence."""
        runs = [run for run in _joined(self._kept) if run.time is not None and len(run) > 2]
        made = [each for each in map(Windows, map(Motion.of, runs)) if len(each)]
        return made if sum(map(len, made)) >= LEAST else []


def _joined(kept: list[Recording]) -> list[Recording]:
    """Segments that overlap, as they came, as runs without the rows that come twice."""
    runs: list[Recording] = []
    for segment in kept:
        assert segment.time is not None
        last = runs[-1] if runs else None
        if last is not None and last.time is not None and last.trial[-1] == segment.trial[0]:
            step = float(np.median(np.diff(last.time))) if len(last) > 1 else 0.0
            new = segment.time > last.time[-1] + step / 2
            if new.any() and segment.time[new][0] - last.time[-1] < 3 * step:
                runs[-1] = Recording.joined([last, segment.take(new)])
                continue
        runs.append(segment)
    return runs
