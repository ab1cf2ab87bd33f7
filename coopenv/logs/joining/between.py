"""What a device says between its samples: linear, nearest, previous; orientations by slerp."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray

ROUNDING = 1e-9  # of a gap, and of a time relative to it
SMALL = 1e-6  # sine of an angle below which slerp is linear


class Neighbours(NamedTuple):
    """Samples before and after some times."""

    before: IntArray  # (T,) number of the last one that is not later
    after: IntArray  # (T,) of the first one that is not earlier
    share: FloatArray  # (T,) of the way from one to the other
    near: BoolArray  # (T,) whether they are so near that the method may be used


def neighbours(time: FloatArray, at: FloatArray, method: str, gap: float) -> Neighbours:
    """Samples at increasing ``time`` ``(n,)`` on both sides of the times ``at`` ``(T,)`` [s].

    For ``"nearest"`` and ``"previous"`` both are the one that is taken. ``gap`` is the longest time
    between two samples, or from the one that is taken [s].
    """
    if not len(time):
        none = np.zeros(len(at), np.int64)
        return Neighbours(none, none, np.zeros(len(at)), np.zeros(len(at), np.bool_))
    most = gap * (1 + ROUNDING)
    later = np.searchsorted(time, at, side="right")
    before = np.maximum(later - 1, 0)
    after = np.minimum(later, len(time) - 1)
    exact = time[before] == at
    after = np.where(exact, before, after)
    step = time[after] - time[before]
    with np.errstate(invalid="ignore"):
        share = np.where(step > 0, (at - time[before]) / np.where(step > 0, step, 1.0), 0.0)
        if method == "linear":
            near = (step <= most) & (time[before] <= at) & (at <= time[after])
        elif method == "previous":
            after, share = before, np.zeros(len(at))
            near = (time[before] <= at) & (at - time[before] <= most)
        else:
            taken = np.where(np.abs(time[after] - at) < np.abs(at - time[before]), after, before)
            before, after, share = taken, taken, np.zeros(len(at))
            near = np.abs(at - time[taken]) <= most
    return Neighbours(before, after, share, near)


def interpolated(
    time: FloatArray, values: FloatArray, at: FloatArray, method: str, gap: float,
    period: float = 0.0,
) -> FloatArray:  # fmt: skip
    """Values ``(T,)`` at some times; NaN where no sample is near enough.

    Parameters
    ----------
    time, values
        Samples ``(n,)``, of which some may be NaN: these are none.
    at
        ``(T,)`` [s].
    method, gap
        See `neighbours`.
    period
        Of an angle, which goes the shorter way; 0 for what is none.
    """
    there = np.isfinite(values)
    if not there.all():
        time, values = time[there], values[there]
    found = neighbours(time, at, method, gap)
    if not len(time):
        return np.full(len(at), np.nan)
    first = values[found.before]
    way = values[found.after] - first
    if period:
        way = (way + period / 2) % period - period / 2
    made = first + found.share * way
    return np.where(found.near, made, np.nan)


def slerped(
    time: FloatArray, values: FloatArray, at: FloatArray, method: str, gap: float
) -> FloatArray:
    """Unit quaternions ``(T, 4)`` between samples ``(n, 4)``: turned evenly, the shorter way."""
    there = np.isfinite(values).all(axis=1)
    time, values = time[there], values[there]
    found = neighbours(time, at, method, gap)
    if not len(time):
        return np.full((len(at), 4), np.nan)
    first, second = values[found.before], values[found.after]
    cosine = (first * second).sum(axis=1)
    second = np.where(cosine[:, None] < 0, -second, second)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    sine = np.sin(angle)
    even = sine > SMALL
    divisor = np.where(even, sine, 1.0)
    weights = (
        np.where(even, np.sin((1 - found.share) * angle) / divisor, 1 - found.share),
        np.where(even, np.sin(found.share * angle) / divisor, found.share),
    )
    made = weights[0][:, None] * first + weights[1][:, None] * second
    return np.where(found.near[:, None], made, np.nan)
