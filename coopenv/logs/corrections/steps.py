"""Corrections that need rows before and after: delay, twist, acceleration, low pass, resampling."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.logs.calibration.differentiation import (
    acceleration,
    twist_from_pose,
    unwound,
    window_rows,
)
from coopenv.logs.calibration.filters import low_pass, settling_rows
from coopenv.logs.calibration.processing import Filters
from coopenv.logs.calibration.resampling import resampled, resampled_orientation
from coopenv.logs.recorded import Recording, by_runs
from coopenv.logs.recorded.runs import evenly, run_ends, usual_rate


def earlier(recordings: Iterable[Recording], delay: float) -> Iterator[Recording]:
    """Pose and twist as they were when each row was recorded: they came ``delay`` [s] late.

    Rows for whose time none came, at one end of each run, are not good any more.
    """

    def work(run: Recording, rate: float) -> Recording:
        assert run.time is not None
        if len(run) < 2:
            return without(run, np.zeros(len(run), dtype=np.bool_))
        at = run.time + delay
        moved = {
            name: made(run.time, values, at)
            for name, made in (
                ("position", resampled),
                ("orientation", resampled_orientation),
                ("twist", resampled),
            )
            if (values := getattr(run, name)) is not None
        }
        there = (at >= run.time[0]) & (at <= run.time[-1])
        return without(replace(run, **moved), there)

    return by_runs(recordings, work, lambda rate: math.ceil(abs(delay) * rate) + 2)


def without(recording: Recording, kept: BoolArray) -> Recording:
    """The same, but only rows that are ``kept`` are good; results of the others are NaN."""
    applied = np.where(kept[:, None, None], recording.applied, np.nan)
    twist = recording.twist
    if twist is not None:
        twist = np.where(kept[:, None], twist, np.nan)
    return replace(recording, applied=applied, twist=twist, good=recording.good & kept)


def with_twist(recordings: Iterable[Recording], window: float) -> Iterator[Recording]:
    """With the twist that the pose tells."""

    def work(run: Recording, rate: float) -> Recording:
        return replace(run, twist=_twist(run, rate, window))

    def skip(rows: Recording) -> Recording:
        size = 3 if rows.applied.shape[-1] == 3 else 6
        return replace(rows, twist=np.full((len(rows), size), np.nan))

    return by_runs(recordings, work, lambda rate: window_rows(rate, window) + 2, skip)


def motion_of(run: Recording, rate: float, window: float) -> FloatArray:
    """Acceleration of the centre of mass, spin and its rate side by side, object frame.

    ``(T, 2 + 1 + 1)`` in the plane, ``(T, 3 + 3 + 3)`` in space; from the twist, or from the pose
    where there is none.
    """
    d = run.grips.shape[-1]
    twist = run.twist if run.twist is not None else _twist(run, rate, window)
    assert run.time is not None
    if len(run) < 2:
        made = np.zeros_like(twist)
    else:
        made = evenly(run.time, twist, rate, lambda even: acceleration(even, rate, window))
    return np.concatenate([made[:, :d], twist[:, d:], made[:, d:]], axis=-1)


def _twist(run: Recording, rate: float, window: float) -> FloatArray:
    assert run.time is not None
    assert run.position is not None
    assert run.orientation is not None
    d = run.position.shape[-1]
    if len(run) < 2:
        return np.zeros((len(run), 3 if d == 2 else 6))
    orientation = unwound(run.orientation).reshape(len(run), -1)
    pose = np.concatenate([run.position, orientation], axis=-1)

    def work(even: FloatArray) -> FloatArray:
        turned = even[:, d] if d == 2 else even[:, d:]
        return twist_from_pose(even[:, :d], turned, rate, window)

    return evenly(run.time, pose, rate, work)


@dataclass(frozen=True, slots=True)
class Smoothing:
    """Zero-phase low pass of some quantities of a run."""

    filters: Filters

    def __call__(self, recordings: Iterable[Recording]) -> Iterator[Recording]:
        """Filtered recordings."""
        return by_runs(recordings, self._work, self._margin)

    def _margin(self, rate: float) -> int:
        cutoffs = (self.filters.wrench, self.filters.pose, self.filters.twist)
        order = self.filters.order
        return max(settling_rows(rate, each, order) for each in cutoffs if each is not None)

    def _work(self, run: Recording, rate: float) -> Recording:
        said, made = self.filters, {}
        if said.wrench is not None:
            made["applied"] = self._passed(run, run.applied, rate, said.wrench)
        if said.twist is not None and run.twist is not None:
            made["twist"] = self._passed(run, run.twist, rate, said.twist)
        if said.pose is not None and run.position is not None and run.orientation is not None:
            made["position"] = self._passed(run, run.position, rate, said.pose)
            turned = self._passed(run, unwound(run.orientation), rate, said.pose)
            if turned.ndim == 2:
                turned /= np.linalg.norm(turned, axis=-1, keepdims=True)
            made["orientation"] = turned
        return replace(run, **made)

    def _passed(self, run: Recording, values: FloatArray, rate: float, cutoff: float) -> FloatArray:
        if len(run) < 2 or run.time is None:
            return values
        order = self.filters.order
        return evenly(run.time, values, rate, lambda even: low_pass(even, rate, cutoff, order))


def at_rate(recordings: Iterable[Recording], rate: float) -> Iterator[Recording]:
    """Rows at equal steps from the beginning of each run on; rows that are not good are left out.

    Numbers are taken from the straight lines between rows, orientations turn evenly, and what is
    carried is that of the row before.
    """
    held: Recording | None = None
    recorded, count = np.nan, 0  # rate of the file; rows made of the run that goes on
    begin = np.nan
    for recording in recordings:
        now = recording if held is None else Recording.joined([held, recording])
        recorded = recorded if recorded > 0 else usual_rate(now)
        parts = []
        for first, end in pairwise(run_ends(now, recorded)):
            goes_on = held is not None and first == 0
            if not goes_on:
                begin, count = np.nan, 0
            run = now.take(slice(first, end))
            if not run.good[0] or run.time is None:
                continue
            begin = begin if np.isfinite(begin) else float(run.time[0])
            last = math.floor((run.time[-1] - begin) * rate + 1e-9)
            at = begin + np.arange(count, last + 1) / rate
            count = max(count, last + 1)
            if len(at):
                parts.append(_rows_at(run, np.minimum(at, run.time[-1])))
        held = now.take(slice(-1, None))
        if parts:
            yield Recording.joined(parts)


def _rows_at(run: Recording, at: FloatArray) -> Recording:
    """Rows of a run at other times, all of them within it."""
    assert run.time is not None
    before = np.searchsorted(run.time, at, side="right") - 1
    rows = run.take(before)
    if len(run) < 2:
        return replace(rows, time=at)
    made = {
        name: resampled(run.time, values, at)
        for name in ("applied", "position", "twist", "grips")
        if (values := getattr(run, name)) is not None and len(values) == len(run)
    }
    if run.grips.ndim == 2:
        made.pop("grips", None)
    if run.orientation is not None:
        made["orientation"] = resampled_orientation(run.time, run.orientation, at)
    return replace(rows, time=at, **made)
