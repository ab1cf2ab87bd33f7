"""What both walker studies write: claims, series, the way seen from above, all over time."""

import csv
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.files import written
from coopenv.geometry.frames import moved
from coopenv.physics.body import Points
from coopenv.physics.scene import Box
from coopenv.wrench import Decomposition, energy_share, load_share

from .. import claims as claim_tables
from ..claims import Claim
from ..figures import BLUE, GREY, ORANGE, Panel, Trial, new_figure, save_figure
from ..methods import decompose_by_methods
from ..sheet import draw_sheet
from .simulations import Recording

ZERO = 1e-9  # [N, N·m] what counts as zero; wrenches are about 10, rounding about 1e-15
_MEASURES = (
    ("F_I", "internal_force_level"),
    ("T_I", "internal_torque_level"),
    ("gamma", "relative_cost"),
)


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


def write(
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
    files = claim_tables.save(found, out / "claims")
    draw_sheet(walk.trial(title), columns, out / "time.png", marks=marks)
    draw_way(walk.recording, out / "way.png", title=title, outline=outline, obstacles=obstacles)
    save_series(walk, out / "series.csv")
    save_arrays(walk, out / "series.npz")
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


def save_series(walk: Walk, path: Path) -> None:
    """Everything over time as CSV, one row a control step."""
    recording = walk.recording
    levels = {
        f"{name}_{short}": getattr(split, measure)
        for name, split in walk.by_method.items()
        for short, measure in _MEASURES
    }
    table: dict[str, Any] = {"time": recording.time}
    for names, values in (
        (("x", "y", "theta"), recording.pose),
        (("x_planned", "y_planned", "theta_planned"), recording.planned),
        (("vx", "vy", "omega"), recording.twist_object),
        (("f1x", "f1y", "t1z", "f2x", "f2y", "t2z"), recording.applied.reshape(-1, 6)),
    ):
        table |= dict(zip(names, values.T, strict=True))
    table |= {
        "clearance": recording.clearance,
        "force_share_1": walk.load.force[:, 0],
        "torque_share_1": walk.load.torque[:, 0],
        "energy_share_1": walk.energy.total[:, 0],
        **levels,
    }
    with written(path) as part, part.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        for row in zip(*table.values(), strict=True):
            writer.writerow([f"{number:.10g}" for number in row])


def save_arrays(walk: Walk, path: Path) -> None:
    """The recorded arrays and each method's internal wrench as NPZ."""
    names = ("time", "pose", "planned", "twist", "applied", "grips", "clearance")
    arrays = {name: getattr(walk.recording, name) for name in names}
    arrays |= {f"internal_{name}": split.internal for name, split in walk.by_method.items()}
    with written(path) as part, part.open("wb") as file:
        np.savez_compressed(file, **arrays)  # pyright: ignore[reportArgumentType]


def _fill(axes: Any, corners: np.ndarray, **look: Any) -> None:
    axes.fill(*corners.T, **look)
