"""Motion that is to be followed: tables of poses over time, and minimum-jerk segments."""

import csv
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from coopenv.arrays import FloatArray, finite_array
from coopenv.compiled import anywhere, compiled
from coopenv.errors import InvalidInput

COLUMNS = ("time", "x", "y", "theta")  # [s, m, m, rad]
MOTION = 9  # numbers: pose, twist, acceleration
PEAK = 1.875  # of a minimum-jerk segment's speed, per mean speed


@dataclass(frozen=True, kw_only=True)
class Reference:
    """A motion as a table; between its rows a cubic in time, with velocities of finite differences.

    Before the first row and after the last the reference rests.

    Parameters
    ----------
    times
        Seconds, increasing; they count from the first.
    poses
        One row a time: x, y [m], θ [rad], world frame. Angles may go on beyond ±π; a step of more
        than π between two rows is taken for a wrap.

    Raises
    ------
    InvalidInput
        If there are fewer than two rows, times do not increase or numbers are not finite.
    """

    times: Sequence[float]
    poses: Sequence[Sequence[float]]

    def __post_init__(self) -> None:
        times = finite_array(self.times, "reference.times")
        poses = finite_array(self.poses, "reference.poses")
        if times.ndim != 1 or len(times) < 2 or poses.shape != (len(times), 3):
            raise InvalidInput(
                f"reference must have two or more rows of time, x, y, theta, got times of shape "
                f"{times.shape} and poses of shape {poses.shape}; give as many of both"
            )
        steps = np.diff(times)
        if (steps <= 0).any():
            row = int(np.argmax(steps <= 0)) + 1
            raise InvalidInput(
                f"reference.times must increase, got {times[row]} after {times[row - 1]} (row "
                f"{row}); sort the rows and drop doubled ones"
            )
        object.__setattr__(self, "times", tuple((times - times[0]).tolist()))
        object.__setattr__(self, "poses", tuple(tuple(row) for row in poses.tolist()))

    @classmethod
    def load(cls, path: str | os.PathLike) -> "Reference":
        """Read a ``.csv`` file with a header, or an ``.npz`` file, of `COLUMNS`.

        Raises
        ------
        InvalidInput
            If the file is not there, a column is missing or an entry is not a number.
        """
        kind = Path(path).suffix
        if kind not in (".csv", ".npz") or not Path(path).is_file():
            raise InvalidInput(
                f"reference must be a .csv or .npz file that exists, got {os.fspath(path)!r}; "
                f"its columns are {', '.join(COLUMNS)}"
            )
        table = _read_csv(Path(path)) if kind == ".csv" else _read_npz(Path(path))
        return cls(times=table[:, 0].tolist(), poses=table[:, 1:].tolist())

    @property
    def duration(self) -> float:
        """From the first row to the last [s]."""
        return self.times[-1]

    def motion(self, time: FloatArray) -> FloatArray:
        """Pose, twist and acceleration ``(time, 9)`` at the given times [s]."""
        times, poses, rates = self._table
        return _table_motion(times, poses, rates, np.asarray(time, dtype=np.float64))

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        times, poses = np.array(self.times), np.array(self.poses)
        poses[:, 2] = np.unwrap(poses[:, 2])
        rates = np.gradient(poses, times, axis=0)
        rates[[0, -1]] = 0.0  # it rests before and after
        return times, poses, rates


def _read_csv(path: Path) -> FloatArray:
    with path.open(newline="") as file:
        reader = csv.DictReader(file, skipinitialspace=True)
        _check_columns(reader.fieldnames or (), path)
        rows = []
        for row in reader:
            try:
                rows.append([float(row[name]) for name in COLUMNS])
            except (TypeError, ValueError):
                raise InvalidInput(
                    f"reference must have a number in every column, got "
                    f"{[row[name] for name in COLUMNS]} in line {reader.line_num} of {path}; "
                    "fill it in or drop the line"
                ) from None
    return np.array(rows).reshape(-1, len(COLUMNS))


def _read_npz(path: Path) -> FloatArray:
    with np.load(path, allow_pickle=False) as arrays:
        _check_columns(arrays.files, path)
        columns = [finite_array(arrays[name], f"reference.{name}") for name in COLUMNS]
    if any(column.shape != columns[0].shape or column.ndim != 1 for column in columns):
        raise InvalidInput(
            f"reference must have columns of one length, got shapes "
            f"{[column.shape for column in columns]} in {path}; save one entry a time"
        )
    return np.stack(columns, axis=-1)


def _check_columns(found: Sequence[str], path: Path) -> None:
    missing = [name for name in COLUMNS if name not in found]
    if missing:
        raise InvalidInput(
            f"reference must have the columns {', '.join(COLUMNS)}, got {', '.join(found)} in "
            f"{path}; add {', '.join(missing)}"
        )


@compiled
def _table_motion(times, poses, rates, at):
    """Cubic Hermite interpolation of a table, and its first two derivatives."""
    out = np.zeros((len(at), MOTION))
    last = len(times) - 1
    for k in range(len(at)):
        if at[k] <= times[0] or at[k] >= times[last]:
            out[k, :3] = poses[0] if at[k] <= times[0] else poses[last]
            continue
        j = np.searchsorted(times, at[k], side="right") - 1
        length = times[j + 1] - times[j]
        s = (at[k] - times[j]) / length
        for i in range(3):
            p, q = poses[j, i], poses[j + 1, i]
            u, v = length * rates[j, i], length * rates[j + 1, i]
            square, cube = 3 * (q - p) - 2 * u - v, 2 * (p - q) + u + v
            out[k, i] = p + s * (u + s * (square + s * cube))
            out[k, 3 + i] = (u + s * (2 * square + 3 * s * cube)) / length
            out[k, 6 + i] = (2 * square + 6 * s * cube) / length**2
    return out


@anywhere
def minimum_jerk(s):
    """Share of the way, its rate and second rate, at a fraction ``s`` in [0, 1] of the time.

    10 s³ − 15 s⁴ + 6 s⁵, at rest at both ends (Flash & Hogan 1985). Rates are per duration and
    duration². ``s`` is a number or an array.
    """
    return (
        s * s * s * (10 + s * (-15 + 6 * s)),
        30 * s * s * (1 + s * (-2 + s)),
        60 * s * (1 + s * (-3 + 2 * s)),
    )


@compiled
def minimum_jerk_motion(plan, at, duration):
    """Pose, twist and acceleration ``(world, 9)`` on segments of equal time through way points.

    Each segment is of minimum jerk, at rest at both ends; see `minimum_jerk`.

    Parameters
    ----------
    plan
        ``(world, 3 · points)``: the poses to pass, angles not wrapped.
    at
        ``(world,)`` [s].
    duration
        Of all segments together [s].
    """
    out = np.zeros((len(plan), MOTION))
    count = plan.shape[1] // 3 - 1
    length = duration / count
    for k in range(len(plan)):
        within = min(max(at[k], 0.0), duration) / length
        j = min(int(within), count - 1)
        s = within - j
        share, rate, change = minimum_jerk(s)
        rate, change = rate / length, change / length**2
        for i in range(3):
            p = plan[k, 3 * j + i]
            way = plan[k, 3 * j + 3 + i] - p
            out[k, i], out[k, 3 + i], out[k, 6 + i] = p + share * way, rate * way, change * way
    return out
