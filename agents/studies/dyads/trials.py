"""Trials of pairs as one long table, simulated or recorded: columns, checks, who is first.

One row a sample. Columns:

    pair, condition, trial     whose trial it is; condition is the guide: "one", "both", "none"
    time                       [s], increasing within a trial
    x, y, theta                pose of the object, world frame [m, rad]
    f1x, f1y, t1z, f2x, ...    applied wrench of each agent, object frame [N, N·m]
    r1x, r1y, r2x, r2y         grips, object frame [m]
    first                      optional: the agent (1 or 2) that enters the final platform first,
                               0 where neither does or both at once; the same all through a trial

Files may call them otherwise and have other units: see `coopenv.agents.studies.dyads.reading`.
Further columns are left alone.
"""

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from coopenv.arrays import FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import rotated, seen_from
from coopenv.physics.scene import Box

from ..series import POSE, WRENCHES
from ..tables import Table

KEYS = ("pair", "condition", "trial")
GRIPS = ("r1x", "r1y", "r2x", "r2y")
COLUMNS = (*KEYS, "time", *POSE, *WRENCHES, *GRIPS)
SAME_INSTANT = 1e-9  # [samples] entries nearer than this are simultaneous


def table_of(
    *,
    pair: npt.ArrayLike,
    condition: npt.ArrayLike,
    trial: npt.ArrayLike,
    time: npt.ArrayLike,
    pose: npt.ArrayLike,
    applied: npt.ArrayLike,
    grips: npt.ArrayLike,
    first: npt.ArrayLike | None = None,
) -> Table:
    """A checked table of what a simulation or a reader of recordings holds as arrays.

    Parameters
    ----------
    pair, condition, trial, first
        ``(rows,)``, or one for all rows.
    time
        ``(rows,)`` [s].
    pose
        ``(rows, 3)`` x, y [m] and θ [rad], world frame.
    applied
        ``(rows, 2, 3)`` object frame [N, N·m].
    grips
        ``(2, 2)`` or ``(rows, 2, 2)`` object frame [m].

    Raises
    ------
    InvalidInput
        If a shape is wrong, or as in `checked_trials`.
    """
    rows = len(np.atleast_1d(np.asarray(time)))
    columns: dict[str, npt.NDArray[Any]] = {}
    keys = {"pair": pair, "condition": condition, "trial": trial, "time": time}
    for name, value in (keys if first is None else {**keys, "first": first}).items():
        columns[name] = _shaped(value, name, (rows,))
    for names, value, name, shape in (
        (POSE, pose, "pose", (3,)),
        (WRENCHES, applied, "applied", (2, 3)),
        (GRIPS, grips, "grips", (2, 2)),
    ):
        flat = _shaped(value, name, (rows, *shape)).reshape(rows, -1)
        columns |= dict(zip(names, flat.T, strict=True))
    return checked_trials(pd.DataFrame(columns))


def checked_trials(trials: Table) -> Table:
    """The trials, one after the other in order of time, with a fresh index.

    Raises
    ------
    InvalidInput
        If a column is missing, a number is not finite, two samples of a trial have the same time,
        or ``first`` is not 0, 1 or 2 all through a trial.
    """
    missing = [name for name in COLUMNS if name not in trials.columns]
    if missing:
        raise InvalidInput(
            f"trials must have the columns {', '.join(COLUMNS)}, got none named "
            f"{', '.join(missing)}; rename or add them"
        )
    if trials.empty:
        raise InvalidInput("trials must hold samples, got none; check the files")
    for name in KEYS:
        unknown = (trials[name].isna() | (trials[name].astype(str).str.strip() == "")).to_numpy()
        if unknown.any():
            row = trials.index[int(unknown.argmax())]
            raise InvalidInput(f"{name} must be known in every row, got none in row {row}; fill it")
    for name in COLUMNS[len(KEYS) :]:
        values = np.asarray(pd.to_numeric(trials[name], errors="coerce"), dtype=np.float64)
        if not np.isfinite(values).all():
            row = int((~np.isfinite(values)).argmax())
            raise InvalidInput(
                f"{name} must be a finite number, got {trials[name].iloc[row]!r} in row "
                f"{trials.index[row]}; remove or interpolate missing samples first"
            )
    ordered = trials.sort_values([*KEYS, "time"], kind="stable", ignore_index=True)
    number = trial_numbers(ordered)
    same = (np.diff(number) == 0) & (np.diff(ordered["time"].to_numpy(np.float64)) <= 0)
    if same.any():
        key = tuple(str(ordered[name].iloc[int(same.argmax())]) for name in KEYS)
        raise InvalidInput(
            f"time must increase within a trial, got {ordered['time'][int(same.argmax())]} s twice "
            f"in (pair, condition, trial) {key}; number repeated trials"
        )
    return _with_first(ordered) if "first" in ordered.columns else ordered


def first_to_enter(trials: Table, platform: Box) -> IntArray:
    """Which agent's grip enters ``platform`` first, ``(rows,)``, the same all through a trial.

    1 or 2; 0 where neither enters, or both at the same instant: see `entered_first`.

    Parameters
    ----------
    trials
        As `checked_trials` returns them.
    platform
        The final platform, world frame; only its outline matters.
    """
    pose = trials[list(POSE)].to_numpy(dtype=np.float64)
    grips = trials[list(GRIPS)].to_numpy(dtype=np.float64).reshape(-1, 2, 2)
    path = grips_in_world(pose, grips)
    first = np.zeros(len(trials), dtype=np.int64)
    for rows in _rows(trials):
        first[rows] = entered_first(path[rows], platform)
    return first


def entered_first(path: FloatArray, platform: Box) -> IntArray:
    """Which of two grips enters a platform first, ``(...)``: 1 or 2, or 0 for neither of them.

    A grip enters where the straight line between two samples crosses the platform's outline; one
    that is inside at no sample never does. Whole samples would not do: at 20 Hz and 0.7 m/s the
    beam moves 35 mm between two of them, in which both grips often enter, so who is first would
    depend on the rate of the recording. Of two that enter at the same instant neither is first:
    to prefer one by its number would count trials that nobody led as led by agent 1.

    Parameters
    ----------
    path
        Of the grips, ``(sample, ..., 2, 2)`` [m], world frame; see `grips_in_world`.
    platform
        World frame; only its outline matters.
    """
    margin = _margins(path, platform)
    inside = (margin >= 0).all(axis=-1)
    sample = inside.argmax(axis=0)  # the first inside, where there is one
    now = np.take_along_axis(margin, sample[None, ..., None], axis=0)[0]
    before = np.take_along_axis(margin, np.maximum(sample - 1, 0)[None, ..., None], axis=0)[0]
    crossed = (before < 0) & (now >= 0)  # edges; a grip is inside once the last is behind it
    since = np.where(crossed, now / np.where(crossed, now - before, 1.0), 1.0).min(axis=-1)
    entry = np.where(inside.any(axis=0), sample - np.where(sample > 0, since, 0.0), np.inf)
    one, two = np.moveaxis(entry, -1, 0)  # [samples]
    return np.where(one < two - SAME_INSTANT, 1, np.where(two < one - SAME_INSTANT, 2, 0))


def grips_in_world(pose: FloatArray, grips: FloatArray) -> FloatArray:
    """Grips ``(..., agent, 2)`` [m] of the object frame in the world frame, for poses ``(..., 3)``.

    The leading dimensions of both are broadcast against each other.
    """
    c, s = np.cos(pose[..., None, 2]), np.sin(pose[..., None, 2])
    return np.stack(rotated(c, s, grips[..., 0], grips[..., 1]), axis=-1) + pose[..., None, :2]


def applied_wrenches(trials: Table) -> FloatArray:
    """``(rows, 2, 3)`` object frame [N, N·m]."""
    return trials[list(WRENCHES)].to_numpy(dtype=np.float64).reshape(-1, 2, 3)


def grip_positions(trials: Table) -> FloatArray:
    """``(rows, 2, 2)``, or ``(2, 2)`` where they never change; object frame [m]."""
    grips = trials[list(GRIPS)].to_numpy(dtype=np.float64).reshape(-1, 2, 2)
    return grips[0] if (grips == grips[0]).all() else grips


def trial_numbers(trials: Table) -> IntArray:
    """``(rows,)``: 0, 1, ... for the trials as they occur."""
    return trials.groupby(list(KEYS), sort=False, observed=True).ngroup().to_numpy(np.int64)


def rows_by_trial(number: IntArray) -> list[slice]:
    """The rows of each trial; they follow each other."""
    edges = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(number)]
    return [slice(start, stop) for start, stop in pairwise(edges)]


def elapsed(trials: Table) -> FloatArray:
    """Time since the first sample of the trial ``(rows,)`` [s]."""
    time = trials["time"].to_numpy(dtype=np.float64)
    return np.concatenate([time[rows] - time[rows][0] for rows in _rows(trials)])


def durations(trials: Table) -> FloatArray:
    """Time that each sample stands for, up to the next one ``(rows,)`` [s]; the last as before."""
    time = trials["time"].to_numpy(dtype=np.float64)
    parts = []
    for rows in _rows(trials):
        steps = np.diff(time[rows])
        parts.append(np.append(steps, steps[-1]) if len(steps) else np.ones(1))
    return np.concatenate(parts)


def turned(trials: Table) -> FloatArray:
    """Largest angle turned so far in the trial, either way ``(rows,)`` [rad]."""
    angle = trials["theta"].to_numpy(dtype=np.float64)
    parts = []
    for rows in _rows(trials):
        unwrapped = np.unwrap(angle[rows])
        parts.append(np.maximum.accumulate(np.abs(unwrapped - unwrapped[0])))
    return np.concatenate(parts)


def _rows(trials: Table) -> list[slice]:
    return rows_by_trial(trial_numbers(trials))


def _shaped(value: npt.ArrayLike, name: str, shape: tuple[int, ...]) -> npt.NDArray[Any]:
    array = np.asarray(value)
    try:
        return np.broadcast_to(array, shape)
    except ValueError as error:
        raise InvalidInput(
            f"{name} must be of shape {shape}, or one for all rows, got {array.shape}; "
            "put the samples first"
        ) from error


def _with_first(trials: Table) -> Table:
    """The trials with ``first`` as whole numbers; a column that lacks one somewhere is text."""
    first: Any = pd.to_numeric(trials["first"], errors="coerce")
    known = first.isin([0, 1, 2])
    numbered = trials.assign(first=first)
    varying = numbered.groupby(list(KEYS), observed=True)["first"].nunique() > 1
    if not known.all() or varying.any():
        got = trials["first"][~known].iloc[0] if not known.all() else varying.index[varying][0]
        raise InvalidInput(
            f"first must be 0, 1 or 2 and the same all through a trial, got {got!r}; "
            "it is the agent that enters the final platform first"
        )
    return numbered.astype({"first": np.int64})


def _margins(points: FloatArray, box: Box) -> FloatArray:
    """How far points are inside each of a box's four edges, ``(..., 4)`` [m]; outside negative."""
    c, s = np.cos(box.angle), np.sin(box.angle)
    x, y = seen_from(*box.center, c, s, points[..., 0], points[..., 1])
    half_x, half_y = np.array(box.size) / 2
    return np.stack([half_x + x, half_x - x, half_y + y, half_y - y], axis=-1)
