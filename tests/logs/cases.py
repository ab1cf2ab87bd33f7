"""Recorded trials for tests, and files of them."""

from pathlib import Path
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray

BEAM = (-0.9, 0.0, 0.9, 0.0)


def planar(rows: int = 40, num_effectors: int = 2, seed: int = 0) -> dict[str, Any]:
    """Columns of random wrenches, object frame, with a pose and a twist."""
    rng = np.random.default_rng(seed)
    columns = {"time": np.arange(rows) * 0.01}
    for i in range(num_effectors):
        for name in (f"f{i + 1}x", f"f{i + 1}y", f"t{i + 1}z"):
            columns[name] = rng.normal(size=rows)
    for name in ("x", "y", "theta", "vx", "vy", "omega"):
        columns[name] = rng.normal(size=rows)
    return columns


def spatial(rows: int = 6, num_effectors: int = 2, seed: int = 0) -> dict[str, Any]:
    """The same in space, with grips in columns."""
    rng = np.random.default_rng(seed)
    columns = {"time": np.arange(rows) * 0.01}
    for i in range(num_effectors):
        grip = rng.normal(size=3)
        for j, axis in enumerate("xyz"):
            columns[f"f{i + 1}{axis}"] = rng.normal(size=rows)
            columns[f"t{i + 1}{axis}"] = rng.normal(size=rows)
            columns[f"r{i + 1}{axis}"] = np.full(rows, grip[j])
    for name in ("vx", "vy", "vz", "omega_x", "omega_y", "omega_z", "x", "y", "z"):
        columns[name] = rng.normal(size=rows)
    quaternion = rng.normal(size=(4, rows))
    quaternion /= np.linalg.norm(quaternion, axis=0)
    columns.update(zip(("qw", "qx", "qy", "qz"), quaternion, strict=True))
    return columns


def wrench(columns: dict[str, FloatArray], prefix: str = "") -> FloatArray:
    """``(T, n, 3 or 6)`` of columns."""
    spatial = f"{prefix}f1z" in columns
    names = ("fx", "fy", "fz", "tx", "ty", "tz") if spatial else ("fx", "fy", "tz")
    found = []
    while f"{prefix}f{len(found) + 1}x" in columns:
        i = len(found) + 1
        found.append(np.stack([columns[f"{prefix}{a}{i}{b}"] for a, b in names], axis=-1))
    return np.stack(found, axis=1)


def save(columns: dict, path: Path) -> Path:
    """Columns as a file of the format its name asks for."""
    if path.suffix == ".npz":
        np.savez(path, **columns)
    elif path.suffix == ".parquet":
        import pandas as pd

        pd.DataFrame(columns).to_parquet(path)
    else:
        lines = [",".join(columns)]
        lines += [",".join(map(_text, row)) for row in zip(*columns.values(), strict=True)]
        path.write_text("\n".join(lines) + "\n")
    return path


def _text(value: object) -> str:
    return repr(float(value)) if isinstance(value, float | np.floating) else str(value)


def load(path: Path) -> dict:
    """Columns of a table as `coopenv.logs` writes it."""
    if path.suffix == ".npz":
        return dict(np.load(path))
    import pandas as pd

    frame = pd.read_parquet(path) if path.suffix == ".parquet" else pd.read_csv(path)
    return {name: frame[name].to_numpy() for name in frame}
