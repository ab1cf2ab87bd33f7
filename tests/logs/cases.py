"""Recorded trials for tests, and files of them."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from coopenv.arrays import FloatArray
from coopenv.logs import formats
from coopenv.logs.formats import named

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


def _save_text(columns: dict, path: Path) -> None:
    lines = [",".join(columns)]
    lines += [",".join(map(as_text, row)) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join(lines) + "\n")


def as_text(value: object) -> str:
    return repr(float(value)) if isinstance(value, float | np.floating) else str(value)


def _save_npz(columns: dict, path: Path) -> None:
    np.savez(path, **columns)


def _save_parquet(columns: dict, path: Path) -> None:
    import pandas as pd

    pd.DataFrame(columns).to_parquet(path)


def _load_text(path: Path) -> Any:
    import pandas as pd

    return pd.read_csv(path)


def _load_parquet(path: Path) -> Any:
    import pandas as pd

    return pd.read_parquet(path)


# how to write and to read each format without the code under test
WAYS: dict[str, tuple[Callable[[dict, Path], None], Callable[[Path], Any]]] = {
    ".csv": (_save_text, _load_text),
    ".npz": (_save_npz, np.load),
    ".parquet": (_save_parquet, _load_parquet),
}
FORMATS = tuple(WAYS)


def save(columns: dict, path: Path) -> Path:
    """Columns as a file of the format its name asks for."""
    WAYS[path.suffix][0](columns, path)
    return path


def load(path: Path) -> dict:
    """Columns of a table as `coopenv.logs` writes it."""
    table = WAYS[path.suffix][1](path)
    return {name: np.asarray(table[name]) for name in table}


def set_chunk(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have every format read that many rows at a time, of text about as many."""
    modules = {known.source.__module__ for known in (*formats.FORMATS, *formats.READ)}
    for module in map(import_module, (*modules, named.__name__)):
        for name, size in (("CHUNK_ROWS", rows), ("BLOCK", 150 * rows)):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, size)
