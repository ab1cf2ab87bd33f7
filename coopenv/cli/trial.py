"""A trial of a recording as a film: which rows, their pose, their measures."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from coopenv.arrays import FloatArray, number, whole
from coopenv.errors import InvalidInput

if TYPE_CHECKING:
    from coopenv.logs import Analysis, Layout, Recording
    from coopenv.render.film import Frames
    from coopenv.render.replay import Measures, Pace

LEVELS = ("relative_cost", "internal_force_level", "internal_torque_level")
SHARES = ("force_load_share", "torque_load_share")


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Which trial, counted from 1, and from when until when since it began [s]."""

    number: int = 1
    start: float = 0.0
    end: float | None = None


def film(
    file: Path, layout: "Layout", part: Part, pace: "Pace", *, bad_rows: str, width: int
) -> tuple["Frames", list[str]]:
    """The pictures, and what there is to say of them.

    Raises
    ------
    InvalidInput
        If the file cannot be read, is of a motion in space, has no times or not that trial, or none
        of its rows lies in the part.
    """
    from coopenv.logs import Recording, analyse
    from coopenv.logs.recording import Reader
    from coopenv.render.replay import film_of_recording
    from coopenv.render.stage import Stage

    reader = Reader(file, layout, bad_rows=bad_rows)
    _require_drawable(file, reader.plan.dimension, "time" in reader.plan.source)
    recording = Recording.joined(list(reader))
    trials = int(recording.trial[-1]) + 1
    chosen = _part(file, recording, part, trials)
    analysis = analyse(chosen)
    pose, where = _pose(chosen)
    time = chosen.time
    assert time is not None
    internal = _internal(analysis, chosen.num_effectors)
    stage = Stage(pose, chosen.grips, chosen.applied, internal, width=width)
    frames = film_of_recording(time, stage, _measures(analysis, chosen.num_effectors), pace=pace)
    said = [f"trial {part.number} of {trials}, {time[-1] - time[0]:.2f} s, {len(time)} rows{where}"]
    return frames, [*reader.notes, *said]


def _require_drawable(file: Path, dimension: int, has_times: bool) -> None:
    """Raise unless the file is of a motion in the plane, with times."""
    if dimension != 2:
        raise InvalidInput(
            f"file must be a recording in the plane, got {str(file)!r}, which is in space; say "
            "--space plane to leave out what points out of it, or draw single rows with "
            "coopenv show"
        )
    if not has_times:
        raise InvalidInput(
            f"file must have a column of time, got none in {str(file)!r}; say --sample-rate, or "
            "how it is called in a layout"
        )


def _part(file: Path, recording: "Recording", part: Part, trials: int) -> "Recording":
    """The rows of the part that have a time."""
    wanted = whole(part.number, "trial", at_least=1)
    if wanted > trials:
        raise InvalidInput(f"trial must be at most {trials}, got {wanted}; {file} has no more")
    start = number(part.start, "start")
    end = np.inf if part.end is None else number(part.end, "end")
    assert recording.time is not None
    rows = (recording.trial == wanted - 1) & np.isfinite(recording.time)
    if rows.any():
        since = recording.time - recording.time[rows][0]
        rows &= (since >= start) & (since <= end)
    rows &= np.cumsum(rows & recording.good) > 0  # before the first good row there is nothing
    if not rows.any():
        raise InvalidInput(
            f"start and end must leave rows that can be used, got {start:g} and {end:g} s of trial "
            f"{wanted}; choose others, or look at the file with coopenv decompose"
        )
    return recording.take(rows)


def _pose(recording: "Recording") -> tuple[FloatArray, str]:
    """x, y, θ ``(T, 3)``; what is not recorded is 0, which is said."""
    position, angle = recording.position, recording.orientation
    missing = [] if position is not None else ["x, y"]
    missing += [] if angle is not None else ["theta"]
    rows = len(recording)
    position = np.zeros((rows, 2)) if position is None else position
    angle = np.zeros(rows) if angle is None else angle
    said = f"; without {' and '.join(missing)}, which are drawn as 0" if missing else ""
    return np.column_stack([position, angle]), said


def _internal(analysis: "Analysis", num_effectors: int) -> FloatArray:
    """``(T, n, 3)`` [N, N·m]."""
    from coopenv.logs.columns import wrench_names

    names = wrench_names(num_effectors, 2)
    columns = [np.asarray(analysis[f"internal_{name}"], dtype=np.float64) for name in names]
    return np.stack(columns, axis=-1).reshape(-1, num_effectors, 3)


def _measures(analysis: "Analysis", num_effectors: int) -> "Measures":
    from coopenv.render.replay import Measures

    def share(name: str) -> FloatArray:
        return np.stack([analysis[f"{name}_{i + 1}"] for i in range(num_effectors)], axis=-1)

    return Measures(*(analysis[name] for name in LEVELS), *map(share, SHARES))
