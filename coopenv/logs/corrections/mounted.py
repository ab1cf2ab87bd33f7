"""A mounted sensor: the declared corrections of one effector in SI units, and their application."""

from dataclasses import dataclass

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.body import spatial_inertia
from coopenv.logs.calibration.load import load_wrench
from coopenv.logs.calibration.mounting import moved, turned, uncoupled
from coopenv.logs.calibration.sensor import Sensor, Tare
from coopenv.logs.convert import to_object
from coopenv.logs.corrections.out_of_plane import in_plane, whole_wrench
from coopenv.logs.layout import Layout
from coopenv.logs.recorded import Recording


@dataclass(frozen=True, slots=True, kw_only=True)
class Hanging:
    """A load in the object's axes."""

    mass: float  # [kg]
    center: FloatArray  # (d,) from the sensor's origin [m]
    inertia: FloatArray | None  # (3, 3) [kg m²]
    sign: float  # -1 where it is on the hand's side
    window: float | None  # [s]


@dataclass(frozen=True, slots=True, kw_only=True)
class Mounted:
    """What is done to the wrench of one effector; planar vectors are y up."""

    place: int  # of the effector, from 0
    tare: FloatArray | None  # (3 or 6,)
    cross_talk: FloatArray | None
    sign: float
    rotation: FloatArray | None  # (d, d)
    offset: FloatArray  # (d,) from the sensor to the grip, object axes [m]
    load: Hanging | None
    six_axes: bool = False  # all are read in the plane: d is 3 there, and a wrench has 6 numbers

    @classmethod
    def of(cls, number: int, sensor: Sensor, layout: Layout, dimension: int) -> "Mounted":
        """As the layout declares it, for a recording in the plane or in space."""
        key, angle = f"sensors.{number}", layout.factor("angle")
        six_axes = dimension == 2 and sensor.asks_for_six_axes(angle) != ""
        d = 3 if six_axes else dimension
        size = 3 if d == 2 else 6
        flips = np.array([1.0, -1.0, -1.0] * (size // 3)) if layout.y == "down" else np.ones(size)
        flip = flips[:d]  # the same turn about x by half a turn
        rotation = sensor.axes(angle) if six_axes else sensor.matrix(d, angle, key)
        if rotation is not None:
            rotation = rotation * np.outer(flip, flip)
        tare, cross_talk = _of_readings(sensor, layout, flips, d, key)
        flat = six_axes and not sensor.is_tilted(angle)  # whose z is that of the plane
        offset = placed(_of_six(sensor.offset, flat), d, f"{key}.offset")
        offset = offset * layout.factor("length") * flip
        return cls(
            place=number - 1,
            tare=tare,
            cross_talk=cross_talk,
            sign=sensor.sign,
            rotation=rotation,
            offset=offset if rotation is None else rotation @ offset,
            load=_hanging(sensor, rotation, flip * layout.factor("length"), d, key, flat=flat),
            six_axes=six_axes,
        )

    def needs_motion(self) -> bool:
        """Whether accelerations are to be known."""
        return self.load is not None and self.load.window is not None

    def correct(self, recording: Recording, gravity: FloatArray, motion: FloatArray | None) -> None:
        """Put the corrected wrenches in the place of those of ``recording``.

        ``gravity`` is ``(T, d)`` in the object's axes [m/s²]; ``motion`` is ``(T, 2, d or 1)``
        spin and rates, see `coopenv.logs.corrections.steps.motion_of`.
        """
        wrench = recording.applied[:, self.place]
        beyond = recording.out_of_plane
        if self.six_axes and beyond is not None:
            wrench = whole_wrench(wrench, beyond[:, self.place])
        if self.tare is not None:
            wrench = wrench - self.tare
        if self.cross_talk is not None:
            wrench = uncoupled(wrench, self.cross_talk)
        wrench = self.sign * wrench
        if self.rotation is not None:
            wrench = turned(wrench, self.rotation)
        if self.load is not None:
            wrench = wrench + self.load.sign * self._load(recording, gravity, motion)
        if self.offset.any():
            wrench = moved(wrench, self.offset)
        if self.six_axes and beyond is not None:
            wrench, beyond[:, self.place] = in_plane(wrench)
        recording.applied[:, self.place] = wrench

    def _load(
        self, recording: Recording, gravity: FloatArray, motion: FloatArray | None
    ) -> FloatArray:
        """What the load adds, about the sensor's origin."""
        load = self.load
        assert load is not None
        grip = recording.grips[..., self.place, :]
        if self.six_axes:
            grip, gravity, motion = _with_z(grip), _with_z(gravity), _whole_motion(motion)
        if motion is None:
            return load_wrench(load.mass, load.center, gravity)
        d = gravity.shape[-1]
        place = np.broadcast_to(grip - self.offset + load.center, gravity.shape)
        linear, spin, spin_rate = motion[:, :d], motion[:, d : -(2 * d - 3)], motion[:, 3 - 2 * d :]
        if d == 2:
            across = np.stack([-place[:, 1], place[:, 0]], axis=-1)
            carried = linear + spin_rate * across - spin**2 * place
        else:
            whirl = np.cross(spin, np.cross(spin, place))
            carried = linear + np.cross(spin_rate, place) + whirl
        inertia = load.inertia
        if inertia is not None and d == 2:
            inertia = inertia[2, 2]
        return load_wrench(
            load.mass,
            load.center,
            gravity - carried,
            inertia=inertia,
            spin=spin,
            spin_rate=spin_rate,
        )


def gravity_in_object(
    recording: Recording, pull: FloatArray, rotation: FloatArray | None
) -> FloatArray:
    """Gravity ``(T, d)`` along the object's axes; ``rotation`` is ``(T, d, d)``."""
    everywhere = np.broadcast_to(pull, (len(recording), len(pull)))
    return everywhere if rotation is None else to_object(everywhere, rotation)


def placed(said: tuple[float, ...], dimension: int, key: str) -> FloatArray:
    """A position of the layout ``(d,)``; zero where nothing is said."""
    if said and len(said) != dimension:
        raise InvalidInput(
            f"{key} must be {dimension} numbers here, got {len(said)}; the recording is "
            + (
                "in the plane"
                if dimension == 2
                else "in space, or all six axes of a sensor are read"
            )
        )
    return np.array(said) if said else np.zeros(dimension)


def _of_readings(
    sensor: Sensor, layout: Layout, flips: FloatArray, d: int, key: str
) -> tuple[FloatArray | None, FloatArray | None]:
    """Constant tare and cross-talk matrix, if there are any."""
    size, tare, cross_talk = len(flips), None, None
    if sensor.cross_talk is not None:
        cross_talk = _sized(np.array(sensor.cross_talk), size, f"{key}.cross_talk", d)
        cross_talk = cross_talk * np.outer(flips, flips)
    if sensor.tare is not None and not isinstance(sensor.tare, Tare):
        units = [layout.factor("force")] * d + [layout.factor("torque")] * (size - d)
        tare = _sized(np.array(sensor.tare), size, f"{key}.tare", d) * units * flips
    return tare, cross_talk


def _of_six(said: tuple[float, ...], flat: bool) -> tuple[float, ...]:
    """A position along six axes: those of a sensor that is not tilted may be said in the plane."""
    return (*said, 0.0) if flat and len(said) == 2 else said


def _with_z(vectors: FloatArray) -> FloatArray:
    """Planar vectors in space."""
    return np.concatenate([vectors, np.zeros_like(vectors[..., :1])], axis=-1)


def _whole_motion(motion: FloatArray | None) -> FloatArray | None:
    """``(T, 3 + 3 + 3)`` of ``(T, 2 + 1 + 1)``."""
    if motion is None:
        return None
    made = np.zeros((len(motion), 9))
    made[:, [0, 1, 5, 8]] = motion
    return made


def _hanging(
    sensor: Sensor, rotation: FloatArray | None, unit: FloatArray, d: int, key: str, *, flat: bool
) -> Hanging | None:
    load = sensor.load
    if load is None:
        return None
    center = placed(_of_six(load.center, flat), d, f"{key}.load.center") * unit
    inertia = None
    if load.inertia is not None:
        plain = flat and isinstance(load.inertia, float)  # about z, as in the plane
        inertia = spatial_inertia(load.inertia, 2 if plain else d, f"{key}.load.inertia")
        if rotation is not None and d == 3:
            inertia = rotation @ inertia @ rotation.T
    return Hanging(
        mass=load.mass,
        center=center if rotation is None else rotation @ center,
        inertia=inertia,
        sign=-1.0 if load.side == "hand" else 1.0,
        window=load.window,
    )


def _sized(array: FloatArray, size: int, key: str, dimension: int) -> FloatArray:
    if len(array) != size:
        raise InvalidInput(
            f"{key} must be of {size} components "
            + ("in the plane" if dimension == 2 else "in space, or where all six axes are read")
            + f", got {len(array)}; those of a wrench are forces, then torques"
        )
    return array
