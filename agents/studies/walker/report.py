"""Files of both walker studies: claims, series, the way seen from above, all over time."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.geometry.frames import moved
from coopenv.physics.body import Points
from coopenv.physics.scene import Box
from coopenv.wrench import Decomposition, energy_share, load_share

from .. import series
from ..claims import Claim, save_claims
from ..figures import BLUE, GREY, ORANGE, Panel, Trial, new_figure, save_figure
from ..methods import decompose_by_methods
from ..sheet import draw_sheet
from .simulations import Recording

ZERO = 1e-9  # [N, N·m] what counts as zero; wrenches are about 10, rounding about 1e-15
_ARRAYS = ("time", "pose", "planned", "twist", "applied", "grips", "clearance")


class Walk:
    """A recording with everything that is computed from it.

    Parameters
    ----------
    recording
        As the simulation returned it.
    """

    def __init__(self, recording: Recording):
        self.recording = recording
        self.by_method = decompose_by_methods(recording.applied, recording.grips)
        self.load = load_share(recording.applied, recording.grips)
        self.energy = energy_share(recording.applied, recording.grips, recording.twist_object)

    @property
    def ours(self) -> Decomposition:
        """The optimal decomposition."""
        return self.by_method["optimal"]

    def trial(self, title: str) -> Trial:
        """For the figures."""
        recording = self.recording
        return Trial(
            title=title,
            time=recording.time,
            pose=recording.pose,
            planned=recording.planned,
            twist=recording.twist_object,
            applied=recording.applied,
            grips=recording.grips,
            by_method=self.by_method,
        )


def write_walk(
    walk: Walk,
    found: Sequence[Claim],
    out: Path,
    *,
    title: str,
    columns: Sequence[Sequence[Panel]],
    outline: Points,
    marks: Sequence[float] = (),
    obstacles: Sequence[Box] = (),
) -> list[str]:
    """Write claims, figures and series into ``out``; names of the files."""
    files = save_claims(found, out / "claims")
    draw_sheet(walk.trial(title), columns, out / "time.png", marks=marks)
    draw_way(walk.recording, out / "way.png", title=title, outline=outline, obstacles=obstacles)
    save_series(walk, out)
    return [*files, "time.png", "way.png", "series.csv", "series.npz"]


def draw_way(
    recording: Recording,
    path: str | os.PathLike,
    *,
    title: str,
    outline: Points,
    obstacles: Sequence[Box] = (),
    every: float = 1.0,
) -> None:
    """The way from above, with the walker every so many seconds (Fig. 9)."""
    figure, grid = new_figure(1, 1, size=(7.0, 4.6))
    axes = grid[0, 0]
    for box in obstacles:
        _fill(axes, box.vertices, color="#BBBBBB", label="obstacle")
    axes.plot(*recording.planned[:, :2].T, color="#999999", linewidth=4, label="plan")
    axes.plot(*recording.pose[:, :2].T, color=BLUE, linewidth=1.6, label="centre of mass")
    stride = max(1, round(every / (recording.time[1] - recording.time[0])))
    shown = [*range(0, len(recording.time), stride), len(recording.time) - 1]
    corners = np.array(outline)
    for k in shown:
        label = f"walker, every {every:g} s" if k == 0 else None
        closed = moved(np.concatenate([corners, corners[:1]]), recording.pose[k])
        axes.plot(*closed.T, color=GREY, linewidth=0.8, label=label)
        hands = moved(recording.grips[:1], recording.pose[k])
        label = "human's grip" if k == 0 else None
        axes.plot(*hands.T, "o", color=ORANGE, markersize=4, label=label)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(alpha=0.3)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
    figure.suptitle(title)
    save_figure(figure, path)


def save_series(walk: Walk, out: Path) -> None:
    """Everything over time, one row a control step, as CSV; the recorded arrays as NPZ."""
    recording = walk.recording
    columns = {
        "time": recording.time,
        **series.columns_of(series.POSE, recording.pose),
        **series.columns_of([f"{name}_planned" for name in series.POSE], recording.planned),
        **series.columns_of(series.TWIST, recording.twist_object),
        **series.columns_of(series.WRENCHES, recording.applied),
        "clearance": recording.clearance,
        "force_share_1": walk.load.force[:, 0],
        "torque_share_1": walk.load.torque[:, 0],
        "energy_share_1": walk.energy.total[:, 0],
        **series.measure_columns(walk.by_method),
    }
    series.save_columns(columns, out / "series.csv")
    arrays = {name: getattr(recording, name) for name in _ARRAYS}
    series.save_arrays(arrays, walk.by_method, out / "series.npz")


def _fill(axes: Any, corners: np.ndarray, **look: Any) -> None:
    axes.fill(*corners.T, **look)
