"""Conversion of recorded quantities to SI units and the object frame, y up."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from coopenv.arrays import BoolArray, FloatArray
from coopenv.logs.columns import (
    ORIENTATION,
    POSITION,
    TORQUES,
    TWIST,
    out_of_plane_names,
)
from coopenv.logs.formats.chunks import Chunk
from coopenv.logs.layout import Layout
from coopenv.logs.plan import Plan


@dataclass(slots=True, kw_only=True)
class Measured:
    """Quantities in SI units; the methods turn them from the frames of the file to the object's."""

    force: FloatArray  # (T, n, d)
    torque: FloatArray  # (T, n, 1 or 3)
    grips: FloatArray | None  # (T, n, d)
    position: FloatArray | None  # (T, d)
    orientation: FloatArray | None  # (T,), in space (T, 4) quaternion w, x, y, z
    twist: FloatArray | None  # (T, 3 or 6)
    out_of_plane: FloatArray | None = None  # (T, n, 3) fz, tx, ty of some, zero of others

    @classmethod
    def of(cls, chunk: Chunk, plan: Plan, forces_only: bool) -> "Measured":
        """The rows of a chunk, still in the frames of the file."""
        dimension = plan.dimension
        without_torque = (chunk.rows, plan.num_effectors, len(TORQUES[dimension]))
        orientation = _stacked(chunk, plan, ORIENTATION[dimension])
        if orientation is not None and dimension == 2:
            orientation = orientation[:, 0]
        return cls(
            force=_of_effectors(chunk, plan, "f"),
            torque=np.zeros(without_torque) if forces_only else _of_effectors(chunk, plan, "t"),
            grips=_of_effectors(chunk, plan, "r") if plan.grips_vary else None,
            position=_stacked(chunk, plan, POSITION[dimension]),
            orientation=orientation,
            twist=_stacked(chunk, plan, TWIST[dimension]),
            out_of_plane=_out_of_plane(chunk, plan),
        )

    def turn_over(self) -> None:
        """From y down and angles clockwise to y up and angles counter-clockwise; planar."""
        self.force, self.torque = turned_over(self.force), -self.torque
        if self.grips is not None:
            self.grips = turned_over(self.grips)
        if self.position is not None:
            self.position = turned_over(self.position)
        if self.orientation is not None:
            self.orientation = -self.orientation
        if self.twist is not None:
            self.twist = self.twist * np.array([1.0, -1.0, -1.0])
        if self.out_of_plane is not None:  # turned about x by half a turn
            self.out_of_plane = self.out_of_plane * np.array([-1.0, 1.0, -1.0])

    def turn_to_object(self, layout: Layout, good: BoolArray) -> None:
        """From the world frame to the object's whatever the layout says is in the world frame."""
        if self.orientation is None:
            return  # nothing is in the world frame, or it would have been asked for
        rotation = rotations(self.orientation, good)
        dimension = self.force.shape[-1]
        if layout.frame == "world":
            self.force = to_object(self.force, rotation)
            if dimension == 3:
                self.torque = to_object(self.torque, rotation)
            if self.out_of_plane is not None:
                force, torque = self.out_of_plane[..., :1], self.out_of_plane[..., 1:]
                parts = [force, to_object(torque, rotation)]
                self.out_of_plane = np.concatenate(parts, axis=-1)
        if layout.twist_frame == "world" and self.twist is not None:
            parts = [to_object(self.twist[:, :dimension], rotation), self.twist[:, dimension:]]
            if dimension == 3:
                parts[1] = to_object(parts[1], rotation)
            self.twist = np.concatenate(parts, axis=-1)
        if layout.grip_frame == "world" and self.grips is not None and self.position is not None:
            self.grips = to_object(self.grips - self.position[:, None], rotation)


def in_si(chunk: Chunk, plan: Plan, name: str) -> FloatArray:
    """A documented column ``(T,)`` in SI units, with the sign that the layout gives it."""
    return chunk.numbers[plan.source[name]] * plan.factor[name]


def turned_over(vectors: FloatArray) -> FloatArray:
    """Planar vectors ``(…, 2)`` with y the other way up."""
    return vectors * np.array([1.0, -1.0])


def rotations(orientation: FloatArray, good: BoolArray) -> FloatArray:
    """Matrices ``(T, d, d)`` that turn object vectors to the world; rows not good may be anything.

    ``orientation`` is ``(T,)`` angles [rad], or ``(T, 4)`` quaternions w, x, y, z.
    """
    if orientation.ndim == 2:
        identity = np.array([1.0, 0.0, 0.0, 0.0])
        usable = good & np.isfinite(orientation).all(axis=-1) & orientation.any(axis=-1)
        quaternion = np.where(usable[:, None], orientation, identity)
        return Rotation.from_quat(quaternion[:, [1, 2, 3, 0]]).as_matrix()
    angle = np.where(np.isfinite(orientation), orientation, 0.0)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def to_object(vectors: FloatArray, rotation: FloatArray) -> FloatArray:
    """World vectors ``(T, d)`` or ``(T, n, d)`` in the object frame: Rᵀ v."""
    if vectors.ndim == 2:
        return np.einsum("tji,tj->ti", rotation, vectors)
    return np.einsum("tji,tnj->tni", rotation, vectors)


def _stacked(chunk: Chunk, plan: Plan, names: Sequence[str]) -> FloatArray | None:
    """``(T, names)``, if the file has these columns."""
    if not plan.has(names):
        return None
    return np.stack([in_si(chunk, plan, name) for name in names], axis=-1)


def _of_effectors(chunk: Chunk, plan: Plan, kind: str) -> FloatArray:
    """``(T, n, axes)`` of the columns of ``kind`` f, t or r."""
    groups = plan.effector_names(kind)
    return np.stack(
        [np.stack([in_si(chunk, plan, name) for name in group], -1) for group in groups], 1
    )


def _out_of_plane(chunk: Chunk, plan: Plan) -> FloatArray | None:
    """``(T, n, 3)`` of the effectors of which all six axes are read; zero of the others."""
    if not plan.six_axes:
        return None
    made = np.zeros((chunk.rows, plan.num_effectors, 3))
    for number in plan.six_axes:
        for j, name in enumerate(out_of_plane_names(number)):
            if name in plan.source:
                made[:, number - 1, j] = in_si(chunk, plan, name)
    return made
