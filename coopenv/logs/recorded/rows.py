"""Rows of a recording in memory: SI units, object frame, y up."""

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.logs.formats.chunks import Column


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """What was recorded, row by row; rows that could not be used are NaN and not ``good``.

    Raises
    ------
    InvalidInput
        If an array has masked values.
    """

    time: FloatArray | None  # (T,) [s]
    applied: FloatArray  # (T, n, 3) or (T, n, 6), object frame [N, N·m]
    grips: FloatArray  # (n, 2 or 3), or (T, n, 2 or 3) where they vary, object frame [m]
    position: FloatArray | None  # (T, 2 or 3) of the centre of mass, world frame [m]
    orientation: FloatArray | None  # (T,) [rad], in space (T, 4) quaternion w, x, y, z
    twist: FloatArray | None  # (T, 3 or 6), object frame [m/s, rad/s]
    carried: dict[str, Column]  # the file's other columns, (T,) each
    trial: IntArray  # (T,) number of the trial, from 0
    good: BoolArray  # (T,)
    done: tuple[str, ...] = ()  # corrections, as sentences
    # (T, n, 3) fz, tx, ty in the plane, before corrections, of sensors that need them [N, N·m]
    out_of_plane: FloatArray | None = None

    def __post_init__(self):
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name not in ("carried", "done"):
                object.__setattr__(self, entry.name, _unmasked(value, entry.name))
        for name in [name for name, column in self.carried.items() if np.ma.isMA(column)]:
            self.carried[name] = _unmasked(self.carried[name], f"carried column {name!r}")

    def __len__(self) -> int:
        return len(self.applied)

    @property
    def num_effectors(self) -> int:
        """How many hold the object."""
        return self.applied.shape[1]

    def take(self, rows: BoolArray | IntArray | slice) -> "Recording":
        """Only these rows."""
        values: dict[str, Any] = {}
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name == "carried":
                value = {name: column[rows] for name, column in value.items()}
            elif not (value is None or entry.name == "done" or _is_constant(entry.name, value)):
                value = value[rows]
            values[entry.name] = value
        return Recording(**values)

    def trials(self) -> Iterator["Recording"]:
        """One recording a trial, in the order of the file."""
        starts = np.flatnonzero(np.diff(self.trial, prepend=-1))
        for first, last in zip(starts, [*starts[1:], len(self)], strict=True):
            yield self.take(slice(int(first), int(last)))

    @classmethod
    def joined(cls, parts: list["Recording"]) -> "Recording":
        """Several recordings with the same columns, one after the other."""

        def join(name: str) -> Any:
            values = [getattr(part, name) for part in parts]
            if values[0] is None or name == "done" or _is_constant(name, values[0]):
                return values[0]
            return np.concatenate(values)

        made = {entry.name: join(entry.name) for entry in fields(cls) if entry.name != "carried"}
        carried = {
            name: np.concatenate([part.carried[name] for part in parts])
            for name in parts[0].carried
        }
        return cls(**made, carried=carried)


def _is_constant(name: str, value: Any) -> bool:
    """Whether the grips are those of all rows."""
    return name == "grips" and value.ndim == 2


def _unmasked(value: Any, name: str) -> Any:
    """The plain array of a masked one of which nothing is masked."""
    if not np.ma.isMA(value):
        return value
    if np.ma.is_masked(value):
        raise InvalidInput(
            f"{name} must have no masked values, got {np.ma.count_masked(value)}; fill them with "
            "NaN, and say of their rows that they are not good"
        )
    return np.asarray(value)
