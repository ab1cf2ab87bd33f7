"""How the wrenches that act on a known body would change with corrections of its sensors.

All are linear in what corrects them: axes A_i of a sensor, gains, offsets, biases, a load, the
centre of mass. So only sums of products are kept, and each correction is tried at no cost.
"""

from collections.abc import Mapping, Sequence
from copy import copy

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.calibration.body import Body
from coopenv.logs.consistency.known_body.found import sensors_named
from coopenv.logs.consistency.known_body.known import Windows
from coopenv.logs.consistency.known_body.misfit import Misfit
from coopenv.logs.recorded.devices import Devices
from coopenv.wrench.grasp import cross

UNIT = np.eye(3)
MOST_LOAD = 0.5  # of the body's mass, that sensors carry
Key = tuple  # ("force", i, a, b): component b of sensor i acts along axis a; and so on


class Corrected:
    """Sums of products of columns, each what one number of a correction adds to G h.

    Columns are ``("force", i, a, b)`` and ``("torque", i, a, b)``, where component b of a sensor's
    reading acts along axis a of the object; ``("offset", i, a)``; ``("bias force", a)`` and
    ``("bias torque", a)``; ``("mass", i)`` and ``("moment", i, a)`` of a load; ``("weight",)`` and
    ``("weight moment", a)`` of the weight alone of all loads; and ``("com", a)``.
    """

    def __init__(
        self,
        windows: Sequence[Windows],
        misfit: Misfit,
        body: Body,
        dimension: int,
        devices: Devices | None = None,
    ):
        self._devices = devices
        self.num_effectors = windows[0].motion.force.shape[1]
        self.force_axes = range(dimension)
        self.torque_axes = range(3) if dimension == 3 else range(2, 3)
        self.bodies_pull = np.zeros(3)
        self.bodies_pull[:dimension] = body.pull(dimension)
        self.mass = misfit.mass
        parts = [self._columns(each) for each in windows]
        self.keys = list(parts[0])
        self._place = {key: place for place, key in enumerate(self.keys)}
        design = np.stack([np.concatenate([p[key] for p in parts]) for key in self.keys], axis=-1)
        design = design / misfit.scale[:, None]  # (W, 6, columns)
        flat = design.reshape(-1, len(self.keys))
        target = (misfit.wanted / misfit.scale).ravel()
        count = 2 * len(misfit.wanted)
        self._square, self._toward = flat.T @ flat / count, flat.T @ target / count
        self._whole = float(target @ target) / count
        self.free: tuple[Key, ...] = ()
        self.as_declared = self.numbers({})

    def freed(self, keys: Sequence[Key]) -> "Corrected":
        """The same, where these columns are fitted beside every correction that is tried.

        What was found or taken off by the readings, as they were understood, is another thing where
        they are understood otherwise: a tare that is a mean, the weight of a load.
        """
        made = copy(self)
        made.free = tuple(keys)
        return made

    def named(self, group: tuple[int, ...]) -> str:
        """Some sensors in words."""
        return sensors_named(group, self.num_effectors, self._devices)

    def numbers(
        self,
        axes: Mapping[int, FloatArray],
        *,
        force: float = 1.0,
        torque: float = 1.0,
        torque_axes: Mapping[int, FloatArray] | None = None,
    ) -> FloatArray:
        """Factors of all columns: matrices of some sensors, and gains of all."""
        made = np.zeros(len(self.keys))
        for key, place in self._place.items():
            if key[0] in ("force", "torque"):
                kind, i, a, b = key
                own = torque_axes if kind == "torque" and torque_axes is not None else axes
                made[place] = own.get(i, UNIT)[a, b] * (force if kind == "force" else torque)
        return made

    def only(self, key: Key) -> FloatArray:
        """Factors of all columns: 1 of this one, 0 of the others."""
        made = np.zeros(len(self.keys))
        made[self._place[key]] = 1.0
        return made

    def share(self, numbers: FloatArray) -> float:
        """What `Misfit.share` would be with these factors."""
        if self.free:
            found = self.fitted(self.free, numbers)
            masses = [key[0] in ("mass", "weight") for key in self.free]
            if np.abs(found[masses]).sum() > MOST_LOAD * self.mass:  # not all of the body
                return np.inf
            numbers = numbers.copy()
            numbers[[self._place[key] for key in self.free]] += found
        left = numbers @ self._square @ numbers - 2 * self._toward @ numbers + self._whole
        return max(float(left), 0.0)

    def fitted(self, keys: Sequence[Key], base: FloatArray | None = None) -> FloatArray:
        """Factors of these columns that leave the least, beside what was declared and is free."""
        base = self.as_declared if base is None else base
        places = [self._place[key] for key in dict.fromkeys([*keys, *self.free])]
        square = self._square[np.ix_(places, places)]
        toward = self._toward[places] - self._square[places] @ base
        size = np.sqrt(np.maximum(np.diag(square), 1e-300))
        solved = np.linalg.lstsq(square / np.outer(size, size), toward / size, rcond=1e-9)[0]
        return (solved / size)[: len(keys)]

    def share_with(self, keys: Sequence[Key], factors: FloatArray) -> float:
        """`share` with these columns added to what was declared."""
        made = self.as_declared.copy()
        made[[self._place[key] for key in keys]] += factors
        return self.share(made)

    def residuals(self) -> tuple[FloatArray, FloatArray]:
        """Matrix S and vector s: ‖S numbers − s‖² is `share` up to a constant."""
        value, vector = np.linalg.eigh(self._square)
        kept = value > 1e-12 * value[-1]
        root = np.sqrt(value[kept])
        matrix, target = root[:, None] * vector[:, kept].T, vector[:, kept].T @ self._toward / root
        if not self.free:
            return matrix, target
        columns = matrix[:, [self._place[key] for key in self.free]]
        size = np.maximum(np.linalg.norm(columns, axis=0), 1e-150)
        left, singular, _ = np.linalg.svd(columns / size, full_matrices=False)
        spanned = left[:, singular > 1e-6]
        return matrix - spanned @ (spanned.T @ matrix), target - spanned @ (spanned.T @ target)

    def _columns(self, windows: Windows) -> dict[Key, FloatArray]:
        """Each ``(W, 6)``."""
        motion, made = windows.motion, {}
        position = motion.position
        nothing = np.zeros((len(windows), 3))
        pull = windows.mean(np.broadcast_to(self.bodies_pull, position.shape))
        unit = [windows.mean(windows.to_world(_everywhere(position, axis))) for axis in UNIT]
        for i in range(self.num_effectors):
            made |= self._of_sensor(windows, i, pull)
        made["weight",] = -np.hstack([pull, nothing])
        force = windows.acting()[0]
        for a in self.torque_axes:
            made["bias torque", a] = np.hstack([nothing, unit[a]])
        for a in self.force_axes:
            made["bias force", a] = np.hstack([unit[a], nothing])
            turned = cross(_everywhere(pull, UNIT[a]), pull)
            made["weight moment", a] = -np.hstack([nothing, turned])
            arm = windows.to_world(_everywhere(position, UNIT[a]))
            turned = -cross(_everywhere(force, UNIT[a]), force)
            made["com", a] = np.hstack([-self.mass * windows.second(arm), turned])
        return made

    def _of_sensor(self, windows: Windows, i: int, pull: FloatArray) -> dict[Key, FloatArray]:
        """Those of one sensor."""
        motion, made = windows.motion, {}
        position, grips = motion.position, motion.grips[:, i]
        nothing = np.zeros((len(windows), 3))
        for kind, axes in (("force", self.force_axes), ("torque", self.torque_axes)):
            read = motion.force[:, i] if kind == "force" else motion.torque[:, i]
            for a in axes:
                for b in axes:
                    vectors = read[:, [b]] * UNIT[a]
                    mean = windows.mean(windows.to_world(vectors))
                    if kind == "torque":
                        made[kind, i, a, b] = np.hstack([nothing, mean])
                        continue
                    lever = windows.mean(windows.to_world(cross(grips, vectors)))
                    made[kind, i, a, b] = np.hstack([mean, lever])
        for a in self.force_axes:
            arm = cross(_everywhere(position, UNIT[a]), motion.force[:, i])
            moved = -windows.mean(windows.to_world(arm))
            made["offset", i, a] = np.hstack([nothing, moved])
        middle = windows.middle(grips)
        moving = pull - windows.second(position + windows.to_world(grips))
        made["mass", i] = -np.hstack([moving, cross(middle, moving)])
        for a in self.force_axes:
            turned = cross(_everywhere(moving, UNIT[a]), moving)
            made["moment", i, a] = -np.hstack([nothing, turned])
        return made


def _everywhere(like: FloatArray, vector: FloatArray) -> FloatArray:
    return np.broadcast_to(vector, like.shape)
