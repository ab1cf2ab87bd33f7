"""A trial of a recording as a film: which rows, their pose, their measures."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, number, whole
from coopenv.errors import InvalidInput

if TYPE_CHECKING:
    from coopenv.logs import Analysis, Layout, Recording
    from coopenv.render.film import Frames
    from coopenv.render.recorded import RecordedScene
    from coopenv.render.replay import Measures, Pace

LEVELS = ("relative_cost", "internal_force_level", "internal_torque_level")
SHARES = ("force_load_share", "torque_load_share")


class Shown(NamedTuple):
    """What a film shows, in words and for programs."""

    lines: list[str]
    document: dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Which trial, counted from 1, and from when until when since it began [s]."""

    number: int = 1
    start: float = 0.0
    end: float | None = None


def film(
    file: Path,
    layout: "Layout",
    part: Part,
    pace: "Pace",
    *,
    bad_rows: str,
    width: int,
    series: bool,
) -> tuple["Frames", Shown]:
    """The pictures, and what there is to say of them.

    Raises
    ------
    InvalidInput
        If the file cannot be read, has no times or not that trial, or none of its rows lies in the
        part.
    """
    from coopenv.logs import Recording, analyse
    from coopenv.logs.recording import Reader
    from coopenv.render.replay import film_of_recording

    reader = Reader(file, layout, bad_rows=bad_rows)
    _require_times(file, "time" in reader.plan.source)
    recording = Recording.joined(list(reader))
    trials = int(recording.trial[-1]) + 1
    chosen = _part(file, recording, part, trials)
    analysis = analyse(chosen)
    time = chosen.time
    assert time is not None
    stage, where = _stage(chosen, _internal(analysis, chosen), width)
    measures = _measures(analysis, chosen.num_effectors)
    frames = film_of_recording(time, stage, measures, pace=pace, series=series)
    seconds, rows = float(time[-1] - time[0]), len(time)
    said = f"trial {part.number} of {trials}, {seconds:.2f} s, {rows} rows{where}"
    trial = {"trial": part.number, "trials": trials, "seconds": seconds, "rows": rows}
    shown = {"recording": file, **trial, "notes": reader.notes}
    return frames, Shown([*reader.notes, said], shown)


def _require_times(file: Path, has_times: bool) -> None:
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


def _stage(recording: "Recording", internal: FloatArray, width: int) -> tuple["RecordedScene", str]:
    """Where it is drawn; what of the pose is not recorded is 0, which is said."""
    from coopenv.logs.convert import rotations
    from coopenv.render.space import SpaceStage
    from coopenv.render.stage import Stage

    rows, dimension = len(recording), recording.grips.shape[-1]
    names = ["x, y", "theta"] if dimension == 2 else ["x, y, z", "qw, qx, qy, qz"]
    position, angle = recording.position, recording.orientation
    missing = [names[0]] * (position is None) + [names[1]] * (angle is None)
    how = "are drawn as 0" if dimension == 2 else "are drawn as if it neither moved nor turned"
    said = f"; without {' and '.join(missing)}, which {how}" if missing else ""
    position = np.zeros((rows, dimension)) if position is None else position
    wrenches = recording.grips, recording.applied, internal
    if dimension == 2:
        angle = np.zeros(rows) if angle is None else angle
        return Stage(np.column_stack([position, angle]), *wrenches, width=width), said
    turned = np.zeros((rows, 3, 3)) + np.eye(3)
    if angle is not None:
        lost: BoolArray = np.asarray(~np.isfinite(angle).all(axis=1))
        turned = np.where(lost[:, None, None], np.nan, rotations(angle, ~lost))
    return SpaceStage(position, turned, *wrenches, width=width), said


def _internal(analysis: "Analysis", recording: "Recording") -> FloatArray:
    """``(T, n, 3)``, in space ``(T, n, 6)`` [N, N·m]."""
    from coopenv.logs.columns import wrench_names

    names = wrench_names(recording.num_effectors, recording.grips.shape[-1])
    columns = [np.asarray(analysis[f"internal_{name}"], dtype=np.float64) for name in names]
    return np.stack(columns, axis=-1).reshape(recording.applied.shape)


def _measures(analysis: "Analysis", num_effectors: int) -> "Measures":
    from coopenv.render.replay import Measures

    def share(name: str) -> FloatArray:
        return np.stack([analysis[f"{name}_{i + 1}"] for i in range(num_effectors)], axis=-1)

    return Measures(*(analysis[name] for name in LEVELS), *map(share, SHARES))
