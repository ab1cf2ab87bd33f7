"""Time series of a study as files: columns of a CSV, arrays of an NPZ."""

import csv
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.files import written
from coopenv.wrench import Decomposition

POSE = ("x", "y", "theta")  # world frame [m, m, rad]
TWIST = ("vx", "vy", "omega")  # object frame [m/s, m/s, rad/s]
WRENCHES = ("f1x", "f1y", "t1z", "f2x", "f2y", "t2z")  # of both agents, object frame [N, N·m]
MEASURES = {
    "F_I": "internal_force_level",
    "T_I": "internal_torque_level",
    "gamma": "relative_cost",
}
"""What the columns of a decomposition are called, and the attribute that fills them."""


def columns_of(names: Iterable[str], values: npt.NDArray) -> dict[str, npt.NDArray]:
    """One named column for each entry of the last axis, or last two, of values; samples flat."""
    listed = tuple(names)
    return dict(zip(listed, values.reshape(-1, len(listed)).T, strict=True))


def measure_columns(by_method: Mapping[str, Decomposition]) -> dict[str, FloatArray]:
    """F_I [N], T_I [N·m] and γ by every method, samples flattened."""
    return {
        f"{name}_{short}": getattr(split, measure).ravel()
        for name, split in by_method.items()
        for short, measure in MEASURES.items()
    }


def save_columns(columns: Mapping[str, npt.ArrayLike], path: Path) -> None:
    """Write columns of one length as CSV, numbers to ten digits."""
    with written(path) as part, part.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        for row in zip(*map(np.asarray, columns.values()), strict=True):
            writer.writerow([f"{cell:.10g}" if cell.dtype.kind == "f" else cell for cell in row])


def save_arrays(
    arrays: Mapping[str, npt.ArrayLike], by_method: Mapping[str, Decomposition], path: Path
) -> None:
    """Write arrays and each method's internal wrench as NPZ."""
    internal = {f"internal_{name}": split.internal for name, split in by_method.items()}
    with written(path) as part, part.open("wb") as file:
        np.savez_compressed(file, **{**arrays, **internal})  # pyright: ignore[reportArgumentType]
