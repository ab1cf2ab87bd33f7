"""Sensor of an effector, as it is mounted and as it errs: what a layout's ``[sensors.1]`` says."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, number, positive, stated_array
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.load import Load
from coopenv.logs.calibration.orientation import (
    are_rotations,
    checked_order,
    quaternions,
    rotation_matrix,
)
from coopenv.logs.calibration.stated import LARGEST, square, stated, vector, vector_or_nothing

TURNS = ("quaternion", "euler")  # ways to write a rotation in space beside a matrix
MOST_TILT = 0.01  # [degrees] by which a sensor is turned out of the plane: less is rounding
RESTS = "a rest is two times [start, end] in seconds"


@dataclass(frozen=True, slots=True, kw_only=True)
class Tare:
    """When nothing was held: the mean then, once all else is corrected, is taken off."""

    first: float | None = None  # [s] the file begins with that long a rest
    rests: tuple[tuple[float, float], ...] | None = None  # [s] with two the bias drifts
    file: str | None = None  # a recording of nothing but rest, with the same columns

    def checked(self, key: str) -> "Tare":
        """With every field checked; ``key`` names it in errors."""
        given = [name for name in ("first", "rests", "file") if getattr(self, name) is not None]
        if len(given) != 1:
            raise InvalidInput(
                f"{key} must have one of first, rests and file, got {' and '.join(given) or 'none'}"
                "; leave the others out"
            )
        if self.first is not None:
            return Tare(first=positive(self.first, f"{key}.first", unit="s"))
        if self.rests is None:
            if not isinstance(self.file, str):
                raise InvalidInput(f"{key}.file must be a name, got {self.file!r}; quote it")
            return self
        ends = stated_array(self.rests, f"{key}.rests")
        if ends.shape not in ((1, 2), (2, 2)) or (np.diff(ends.ravel()) <= 0).any():
            raise InvalidInput(
                f"{key}.rests must be one or two rests, one after the other, got {self.rests!r}; "
                f"{RESTS}"
            )
        return Tare(rests=tuple((float(start), float(end)) for start, end in ends))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """How a sensor's reading becomes the wrench that its effector applies to the object.

    In this order: a constant ``tare`` is taken off, ``cross_talk`` multiplied, the ``sign`` and the
    axes are turned, what the ``load`` adds taken off, the wrench moved to the grip, and the rest of
    a ``tare`` taken off that says when nothing was held.
    """

    sign: float = 1.0  # -1 where it measures the reaction on itself
    rotation: Any = None  # its axes seen from the object; see `matrix`
    offset: tuple[
        float, ...
    ] = ()  # from its origin to the grip, its axes [unit of lengths]; () is 0
    tare: Any = None  # a wrench, its axes [units of force and torque], or a table; see `Tare`
    cross_talk: tuple[tuple[float, ...], ...] | None = None  # (3, 3) or (6, 6), SI units
    load: Load | None = None  # what hangs between it and the hand

    def checked(self, key: str) -> "Sensor":
        """With every field checked; ``key`` names it in errors."""
        if self.sign not in (1, -1) or isinstance(self.sign, bool):
            raise InvalidInput(f"{key}.sign must be 1 or -1, got {self.sign!r}; write one of them")
        cross_talk, load, tare = self.cross_talk, self.load, self.tare
        if cross_talk is not None:
            cross_talk = square(cross_talk, f"{key}.cross_talk", (3, 6))
        if load is not None:
            load = stated(Load, load, f"{key}.load").checked(f"{key}.load")
        if isinstance(tare, Tare | Mapping):
            tare = stated(Tare, tare, f"{key}.tare").checked(f"{key}.tare")
        elif tare is not None:
            tare = vector(tare, f"{key}.tare", (3, 6))
        rotation = self.rotation
        if rotation is not None:
            rotation = _checked_rotation(rotation, f"{key}.rotation")
        return Sensor(
            sign=float(self.sign),
            rotation=rotation,
            offset=vector_or_nothing(self.offset, f"{key}.offset"),
            tare=tare,
            cross_talk=cross_talk,
            load=load,
        )

    def matrix(self, dimension: int, angle: float, key: str) -> FloatArray | None:
        """Its axes seen from the object as columns ``(d, d)``; ``None`` where they are the same.

        ``rotation`` is a number in the plane, in both a matrix, ``{quaternion = [...], order =
        "wxyz"}`` or ``{euler = [...], order = "ZYX"}``; ``angle`` is the unit of angles [rad]. In
        the plane it is mirrored of a sensor that is upside down.

        Raises
        ------
        InvalidInput
            If it is one in the plane and the recording is in space.
        """
        said = self.rotation
        in_plane = isinstance(said, float) or (isinstance(said, tuple) and len(said) == 2)
        if dimension != 2 and in_plane:
            raise InvalidInput(
                f"{key}.rotation must be one in space, got one in the plane; write a matrix, "
                "quaternion or Euler angles"
            )
        return None if said is None else self.axes(angle)[:dimension, :dimension]

    def axes(self, angle: float) -> FloatArray:
        """Its axes seen from the object as columns ``(3, 3)``, z out of the plane; see `matrix`."""
        said, made = self.rotation, np.eye(3)
        if isinstance(said, float):
            c, s = np.cos(said * angle), np.sin(said * angle)
            said = ((c, -s), (s, c))
        if isinstance(said, Mapping):
            kind = next(name for name in TURNS if name in said)
            values = np.array(said[kind]) * (angle if kind == "euler" else 1.0)
            return rotation_matrix(quaternions(values, kind, said.get("order")))
        if said is not None:
            made[: len(said), : len(said)] = said
        return made

    def is_tilted(self, angle: float) -> bool:
        """Whether it is turned out of the plane of a recording in the plane."""
        beyond = np.linalg.norm(self.axes(angle)[:2, 2])
        return bool(np.degrees(np.arcsin(min(1.0, float(beyond)))) > MOST_TILT)

    def require_forces_alone(self, key: str) -> None:
        """Raise where it corrects by torques, of which the file has none; ``key`` names it."""
        tare, cross_talk = self.tare, self.cross_talk
        if isinstance(tare, tuple) and any(tare[_num_forces(tare) :]):
            raise InvalidInput(
                f"{key}.tare must be of forces alone with forces_only, got {list(tare)}; write 0 "
                "for its torques, or leave out forces_only where the file has them"
            )
        if cross_talk is None:
            return
        matrix, d = np.array(cross_talk), _num_forces(cross_talk)
        if matrix[:d, d:].any() or matrix[d:, :d].any():
            raise InvalidInput(
                f"{key}.cross_talk must not mix forces with torques with forces_only, got "
                f"{matrix.tolist()!r:.200}; write 0 there, or leave out forces_only where the "
                "file has torques"
            )

    def asks_for_six_axes(self, angle: float) -> str:
        """The key for which all six axes are read in the plane too; empty where none asks."""
        for key in ("cross_talk", "tare"):
            said = getattr(self, key)
            if isinstance(said, tuple) and len(said) == 6:
                return key
        return "rotation" if self.is_tilted(angle) else ""


def _num_forces(said: tuple) -> int:
    """How many of three numbers, in the plane, or of six are forces."""
    return 2 if len(said) == 3 else 3


def _checked_rotation(value: Any, key: str) -> Any:
    """A float, rows of a matrix, or a table as `Sensor.matrix` takes it."""
    if isinstance(value, Mapping):
        kinds = [name for name in TURNS if name in value]
        if len(kinds) != 1 or not set(value) <= {*TURNS, "order"}:
            raise InvalidInput(
                f"{key} must have quaternion or euler, and order, got {', '.join(value) or 'none'};"
                ' write { euler = [0, 0, 30], order = "ZYX" }'
            )
        kind = kinds[0]
        order = checked_order(kind, value.get("order"), f"{key}.order")
        numbers = vector(value[kind], f"{key}.{kind}", (4 if kind == "quaternion" else 3,))
        if kind == "quaternion" and abs(np.linalg.norm(numbers) - 1) > 0.01:
            raise InvalidInput(
                f"{key}.quaternion must be of unit length, got {value[kind]!r}; divide it by its "
                "length"
            )
        return {kind: numbers, "order": order}
    if not isinstance(value, list | tuple | np.ndarray):
        angle = number(value, key)
        if abs(angle) > LARGEST:
            raise InvalidInput(f"{key} must be at most {LARGEST:g}, got {value!r}; correct it")
        return angle
    rows = square(value, key, (2, 3))
    if not are_rotations(np.array(rows)):
        if len(rows) == 2 and are_rotations(np.array(rows) * [1.0, -1.0]):
            raise InvalidInput(
                f"{key} must be right-handed, got {value!r}; of a sensor that is upside down say a "
                'rotation in space, { euler = [180, 0, 0], order = "xyz" }'
            )
        raise InvalidInput(
            f"{key} must be a rotation, whose rows are of unit length, at right angles and "
            f"right-handed, got {value!r}; correct it"
        )
    return rows
