"""Equation of motion of a known body over short windows: what acts on it, and what should.

Σ f = m (dv/dt − g) + d v  and  Σ (r × f + t) = dL/dt + d ω  hold in the world frame at every time,
so their means over a smooth window do too, and there the derivatives can be put on the window:
nothing that was measured is differentiated twice. Means are given along the object's axes in the
middle of the window. A recording in the plane is one in space whose other components are zero.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.spatial.transform import Rotation

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.body import Body
from coopenv.logs.calibration.orientation import rotation_matrix
from coopenv.logs.calibration.resampling import resampled, resampled_orientation
from coopenv.logs.recorded import Recording
from coopenv.wrench.grasp import cross

REACH = 0.15  # [s] to either side of a window's middle
FEWEST = 5  # rows to either side


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Rows in sequence at equal steps, in space."""

    step: float  # [s]
    force: FloatArray  # (T, n, 3) object frame [N]
    torque: FloatArray  # (T, n, 3) about the grips [N·m]
    grips: FloatArray  # (T, n, 3) object frame [m]
    position: FloatArray  # (T, 3) world frame [m]
    quaternion: FloatArray  # (T, 4) w, x, y, z
    angle: FloatArray | None = None  # (T,) in the plane, without jumps [rad]
    dimension: int = 3  # 2 in the plane

    @classmethod
    def of(cls, run: Recording) -> "Motion":
        """A run that has a time and a pose, at its usual step."""
        assert run.time is not None
        assert run.position is not None
        assert run.orientation is not None
        step = float(np.median(np.diff(run.time)))
        count = int((run.time[-1] - run.time[0]) / step + 1e-6) + 1
        at = np.minimum(run.time[0] + step * np.arange(count), run.time[-1])
        d = run.grips.shape[-1]
        wrench = resampled(run.time, run.applied, at)
        grips = run.grips
        if grips.ndim == 3:
            grips = resampled(run.time, grips, at)
        turned = resampled_orientation(run.time, run.orientation, at)
        quaternion = _about_z(turned) if d == 2 else turned
        torque = wrench[..., d:]
        return cls(
            step=step,
            force=_spatial(wrench[..., :d]),
            torque=_spatial(torque) if d == 3 else torque * np.array([0.0, 0.0, 1.0]),
            grips=np.broadcast_to(_spatial(grips), (count, run.num_effectors, 3)),
            position=_spatial(resampled(run.time, run.position, at)),
            quaternion=quaternion,
            angle=turned if d == 2 else None,
            dimension=d,
        )

    def turned_by(self, factor: float) -> "Motion":
        """In the plane: with angles that many times as large."""
        assert self.angle is not None
        return replace(self, quaternion=_about_z(factor * self.angle), angle=factor * self.angle)

    def shifted(self, rows: int, sensors: Sequence[int] = (), *, pose: bool = True) -> "Motion":
        """The pose, and wrenches of some sensors, with the others of so many rows before."""
        late = slice(max(rows, 0), min(rows, 0) or None)
        early = slice(max(-rows, 0), min(-rows, 0) or None)
        chosen = np.isin(np.arange(self.force.shape[1]), sensors)[:, None]
        return Motion(
            step=self.step,
            force=np.where(chosen, self.force[late], self.force[early]),
            torque=np.where(chosen, self.torque[late], self.torque[early]),
            grips=self.grips[early],
            position=self.position[late if pose else early],
            quaternion=self.quaternion[late if pose else early],
            dimension=self.dimension,
        )


class Windows:
    """Means over windows of one motion, along the object's axes in their middle."""

    def __init__(self, motion: Motion):
        self.motion = motion
        self._reach = max(FEWEST, round(REACH / motion.step))
        self.turn = rotation_matrix(motion.quaternion)  # (T, 3, 3)
        self._hop = max(1, self._reach // 2)
        self._middle = np.arange(self._reach, len(self.turn) - self._reach, self._hop)
        self._mean, self._rate, self._rate2 = _kernels(self._reach, motion.step)

    def __len__(self) -> int:
        return len(self._middle)

    def mean(self, world: FloatArray) -> FloatArray:
        """Of vectors ``(T, ..., 3)`` of the world: ``(W, ..., 3)`` of the object."""
        return self._of(world, self._mean)

    def rate(self, world: FloatArray) -> FloatArray:
        """Mean of their derivative."""
        return self._of(world, self._rate)

    def second(self, world: FloatArray) -> FloatArray:
        """Mean of their second derivative."""
        return self._of(world, self._rate2)

    def to_world(self, vectors: FloatArray) -> FloatArray:
        """Vectors ``(T, ..., 3)`` along the object's axes, in the world's."""
        turn = self.turn.reshape(len(self.turn), *[1] * (vectors.ndim - 2), 3, 3)
        return (turn @ vectors[..., None])[..., 0]

    def middle(self, values: FloatArray) -> FloatArray:
        """Values ``(T, ...)`` in the middle of each window."""
        return values[self._middle]

    def acting(self) -> tuple[FloatArray, FloatArray]:
        """Resultant force and torque ``(W, 3)`` of what was measured."""
        motion = self.motion
        torque = (cross(motion.grips, motion.force) + motion.torque).sum(axis=1)
        return (
            self.mean(self.to_world(motion.force.sum(axis=1))),
            self.mean(self.to_world(torque)),
        )

    def wanted(self, body: Body, dimension: int) -> tuple[FloatArray, FloatArray]:
        """Resultant force and torque ``(W, 3)`` that the motion of the body needs."""
        motion, (linear, angular) = self.motion, body.drag
        mass = body.mass if body.mass is not None else np.nan
        spin = _spin(motion)
        inertia = body.inertia_matrix(dimension)
        own = np.einsum("tji,tj->ti", self.turn, spin)
        momentum = np.einsum("tij,jk,tk->ti", self.turn, inertia, own)
        gravity = np.zeros(3)
        gravity[:dimension] = body.pull(dimension)
        pull = np.broadcast_to(gravity, motion.position.shape)
        force = mass * (self.second(motion.position) - self.mean(pull))
        force += linear * self.rate(motion.position)
        return force, self.rate(momentum) + angular * self.mean(spin)

    def _of(self, world: FloatArray, weights: FloatArray) -> FloatArray:
        windows = sliding_window_view(world, len(weights), axis=0)[:: self._hop]
        means = windows[: len(self._middle)] @ weights
        turn = self.turn[self._middle]
        turn = turn.reshape(len(turn), *[1] * (means.ndim - 2), 3, 3)
        return (turn.swapaxes(-1, -2) @ means[..., None])[..., 0]


def _kernels(reach: int, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights ``(2 reach + 1,)`` of a mean, and of means of the first and second derivative.

    Of the window (1 − s²)⁴ and its derivatives by s, so scaled that they are exact for parabolas.
    """
    s = np.arange(-reach, reach + 1) / (reach + 1)
    time = np.arange(-reach, reach + 1) * step
    rest = 1 - s * s
    mean = rest**4
    rate = 8 * s * rest**3
    second = 48 * s * s * rest**2 - 8 * rest**3
    second -= second.mean()
    return mean / mean.sum(), rate / (rate @ time), second * 2 / (second @ time**2)


def _spin(motion: Motion) -> FloatArray:
    """Angular velocity ``(T, 3)``, world frame [rad/s], from differences of the orientation."""
    turn = Rotation.from_quat(motion.quaternion[:, [1, 2, 3, 0]])
    inner = (turn[2:] * turn[:-2].inv()).as_rotvec() / (2 * motion.step)
    ends = [(turn[pair[1]] * turn[pair[0]].inv()).as_rotvec() / motion.step for pair in _ENDS]
    return np.concatenate([ends[0][None], inner, ends[1][None]])


def _about_z(angle: FloatArray) -> FloatArray:
    """Quaternions ``(T, 4)`` of angles ``(T,)``."""
    zero = np.zeros_like(angle)
    return np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=-1)


_ENDS = ((0, 1), (-2, -1))


def _spatial(vectors: FloatArray) -> FloatArray:
    """With a third component, which is zero in the plane."""
    if vectors.shape[-1] == 3:
        return vectors
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)
