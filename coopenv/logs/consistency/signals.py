"""Signals of the laws of motion: averages over windows of what acts, and of what moves."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from scipy.spatial.transform import Rotation

from coopenv.arrays import FloatArray
from coopenv.geometry.frames import wrapped
from coopenv.logs.consistency.windows import integral, mean_of_neighbours, window_means
from coopenv.logs.convert import rotations, to_object
from coopenv.logs.recording import Recording
from coopenv.wrench.grasp import moment

FRAMES = ("object", "world")
MOST_SWAPPED = 4  # effectors of which every pair is tried in exchanged places


class Signals:
    """Signals of consecutive rows, computed for either frame that the file may have meant.

    Parameters
    ----------
    segment
        The rows, as they were declared.
    rows
        How many make a window.
    declared
        Frame of ``wrench`` and ``twist``.
    angle
        Factor of the orientation in the plane.
    """

    def __init__(self, segment: Recording, rows: int, declared: Mapping[str, str], angle: float):
        self._segment, self._rows, self._declared = segment, rows, declared
        self._dimension = segment.grips.shape[-1]
        self._step = np.diff(segment.time) if segment.time is not None else np.zeros(0)
        self.num_swapped = min(segment.num_effectors, MOST_SWAPPED)
        self.num_swapped *= segment.num_effectors <= MOST_SWAPPED
        orientation = segment.orientation
        self._rotation: FloatArray | None = None
        self._spin: FloatArray | None = None  # (T − 1, 1 or 3) of the pose, world frame [rad/s]
        if orientation is not None:
            self._orient(orientation, angle)

    def of(self, law: str) -> dict[str, FloatArray]:
        """Those of a law, ``(windows, components)`` each; none where something is missing."""
        made = {
            "force": self._force,
            "torque": self._torque,
            "power": self._power,
            "shift": self._shift,
            "spin": self._turn,
        }
        return made[law]()

    def _orient(self, orientation: FloatArray, angle: float) -> None:
        good = np.ones(len(orientation), dtype=np.bool_)
        plane = orientation.ndim == 1
        declared = rotations(orientation, good)
        self._rotation = rotations(orientation * angle, good) if plane else declared
        if plane:
            turned = wrapped(np.diff(orientation * angle)[:, None])
        else:
            rotation = Rotation.from_matrix(declared)
            turned = (rotation[1:] * rotation[:-1].inv()).as_rotvec()
        self._spin = turned / self._step[:, None]
        self._declared_rotation = declared

    def _force(self) -> dict[str, FloatArray]:
        """Impulse of the resultant in the world frame, and momentum for a mass of 1."""
        velocities = self._velocities()
        if self._rotation is None or not velocities:
            return {}
        force = self._segment.applied[..., : self._dimension].sum(axis=1)
        made = {
            frame: self._impulse(mean_of_neighbours(each))
            for frame, each in self._both(force, "wrench", world=True).items()
        }
        for name, velocity in velocities.items():
            made[f"momentum {name}"] = self._change(velocity)
            made[f"way {name}"] = self._impulse(velocity)
        if self._segment.position is not None:
            made["place"] = self._impulse(mean_of_neighbours(self._segment.position))
        return made

    def _torque(self) -> dict[str, FloatArray]:
        """Angular impulse in the world frame, and angular momentum for inertias of 1."""
        if self._rotation is None or self._spin is None:
            return {}
        segment, d = self._segment, self._dimension
        grips = np.broadcast_to(segment.grips, (*segment.applied.shape[:2], d))
        forces = self._both(segment.applied[..., :d], "wrench", world=False)
        torques = self._both(segment.applied[..., d:].sum(axis=1), "wrench", world=False)
        made = {}
        for frame in FRAMES:
            made[f"torque {frame}"] = self._angular_impulse(torques[frame])
            for pair in [(0, 0), *combinations(range(self.num_swapped), 2)]:
                order = np.arange(segment.num_effectors)
                order[list(pair)] = order[list(pair[::-1])]
                lever = moment(grips[:, order], forces[frame]).sum(axis=1)
                made[f"lever {frame} {pair}"] = self._angular_impulse(lever)
        for name, momentum in self._spins().items():
            made[name] = self._change(momentum)
        made["turn"] = self._impulse(self._spin)
        return made

    def _power(self) -> dict[str, FloatArray]:
        """Work, and kinetic energy for a mass and inertias of 1, as declared."""
        velocity, spin = self._object_twist()
        if velocity is None or spin is None:
            return {}
        segment, d = self._segment, self._dimension
        force, torque = segment.applied[..., :d], segment.applied[..., d:]
        total = (moment(segment.grips, force) + torque).sum(axis=1)
        power = (mean_of_neighbours(force.sum(axis=1)) * velocity).sum(axis=-1, keepdims=True)
        power += (mean_of_neighbours(total) * spin).sum(axis=-1, keepdims=True)
        square = (velocity * velocity).sum(axis=-1, keepdims=True)
        made = {
            "work": self._impulse(power),
            "energy": self._change(square / 2),
            "friction": self._impulse(square),
            "angular friction": self._impulse((spin * spin).sum(axis=-1, keepdims=True)),
        }
        for j in range(spin.shape[1]):
            made[f"energy {j}"] = self._change(spin[:, [j]] ** 2 / 2)
        if d == 3 and segment.position is not None:
            position = mean_of_neighbours(segment.position)
            made |= {f"weight {j}": self._change(position[:, [j]]) for j in range(d)}
        return made

    def _shift(self) -> dict[str, FloatArray]:
        """Velocity of the pose, and that of the twist in either frame."""
        velocities = self._velocities(all_of_them=True)
        if len(velocities) < 1 + len(FRAMES):
            return {}
        return {name: window_means(each, self._rows) for name, each in velocities.items()}

    def _turn(self) -> dict[str, FloatArray]:
        """Angular velocity of the pose and of the twist, object frame in space."""
        spin, twist = self._spin, self._segment.twist
        if spin is None or twist is None or self._rotation is None:
            return {}
        told = mean_of_neighbours(twist[:, self._dimension :])
        if self._dimension == 3:
            spin = to_object(spin, self._rotation[:-1])
        return {"pose": window_means(spin, self._rows), "twist": window_means(told, self._rows)}

    def _velocities(self, *, all_of_them: bool = False) -> dict[str, FloatArray]:
        """``(T − 1, d)`` in the world frame: of the pose, else of the twist in either frame."""
        found: dict[str, FloatArray] = {}
        position, twist = self._segment.position, self._segment.twist
        if position is not None:
            found["pose"] = np.diff(position, axis=0) / self._step[:, None]
        if twist is not None and self._rotation is not None and (all_of_them or not found):
            both = self._both(twist[:, : self._dimension], "twist", world=True)
            found |= {frame: mean_of_neighbours(each) for frame, each in both.items()}
        return found

    def _spins(self) -> dict[str, FloatArray]:
        """R e_j ω_j for each axis j of the object, world frame: angular momentum for I_j = 1."""
        assert self._spin is not None
        assert self._rotation is not None
        if self._dimension == 2:
            return {"inertia": self._spin}
        rotation = self._rotation[:-1]
        own = to_object(self._spin, rotation)
        return {f"inertia {j}": rotation[:, :, j] * own[:, [j]] for j in range(3)}

    def _object_twist(self) -> tuple[FloatArray | None, FloatArray | None]:
        """Both velocities ``(T − 1, …)`` in the object frame: recorded, or of the pose."""
        twist, position = self._segment.twist, self._segment.position
        if twist is not None:
            mean = mean_of_neighbours(twist)
            return mean[:, : self._dimension], mean[:, self._dimension :]
        if position is None or self._rotation is None or self._spin is None:
            return None, None
        velocity = np.diff(position, axis=0) / self._step[:, None]
        rotation = self._rotation[:-1]
        spin = self._spin if self._dimension == 2 else to_object(self._spin, rotation)
        return to_object(velocity, rotation), spin

    def _both(self, vectors: FloatArray, kind: str, *, world: bool) -> dict[str, FloatArray]:
        """Vectors by the frame that the file's numbers may have been in, "object" or "world".

        ``vectors`` are in the object frame, to which they were turned from the declared one. Both
        results are in the world frame if ``world``, else in the object's.
        """
        rotation = self._rotation
        assert rotation is not None
        if self._dimension == 2 and vectors.shape[-1] == 1:
            return dict.fromkeys(FRAMES, vectors)
        numbers = vectors
        if self._declared[kind] == "world":
            numbers = _to_world(vectors, self._declared_rotation)
        if world:
            return {"object": _to_world(numbers, rotation), "world": numbers}
        return {"object": numbers, "world": to_object(numbers, rotation)}

    def _angular_impulse(self, torque: FloatArray) -> FloatArray:
        """Of a torque ``(T, 1 or 3)`` in the object frame."""
        if self._dimension == 3 and self._rotation is not None:
            torque = _to_world(torque, self._rotation)
        return self._impulse(mean_of_neighbours(torque))

    def _impulse(self, rate: FloatArray) -> FloatArray:
        return self._change(integral(rate, self._step))

    def _change(self, values: FloatArray) -> FloatArray:
        """From window to window, of values in the middle of each interval."""
        return np.diff(window_means(values, self._rows), axis=0)


def _to_world(vectors: FloatArray, rotation: FloatArray) -> FloatArray:
    return to_object(vectors, rotation.swapaxes(-1, -2))
