"""Carry the object from a random pose to a random pose and put it to rest there."""

from dataclasses import dataclass, fields
from math import cos, hypot, pi, sin

import numpy as np
from numba import njit

from coopenv.arrays import BoolArray, FloatArray, positive
from coopenv.body import Body
from coopenv.errors import InvalidInput
from coopenv.scene import Scene
from coopenv.tasks.base import Episode, Pose

_TRIES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class TransportTask:
    """Random start, random goal; done when the object rests at the goal pose within tolerance.

    Raises
    ------
    InvalidInput
        If a value is not positive (``clearance`` and ``min_distance`` may be zero).
    """

    position_tolerance: float = 0.1  # [m]
    angle_tolerance: float = 0.1  # [rad]
    speed_tolerance: float = 0.1  # [m/s]
    spin_tolerance: float = 0.1  # [rad/s]
    angle_weight: float = 0.5  # [m/rad] what turning counts for in the distance
    clearance: float = 0.1  # [m] kept from walls by start and goal
    min_distance: float = 0.5  # [m] between start and goal, in the task's distance

    def __post_init__(self) -> None:
        for entry in fields(TransportTask):
            value = getattr(self, entry.name)
            or_zero = entry.name in ("clearance", "min_distance")
            value = positive(value, f"task.{entry.name}", or_zero=or_zero)
            object.__setattr__(self, entry.name, value)

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` unless the object can turn freely in the room."""
        needed = 2 * (body.reach + self.clearance)  # [m]
        if min(scene.size) < needed:
            raise InvalidInput(
                f"scene.size must be at least {needed:.2f} m each way, got {scene.size}; "
                "enlarge the room or shorten body.outline"
            )

    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """Start and goal, each uniform over what the walls and obstacles leave free."""
        start = self._free_pose(generator, body, scene)
        for _ in range(_TRIES):
            goal = self._free_pose(generator, body, scene)
            turn = abs(pi - (goal[2] - start[2]) % (2 * pi))
            away = hypot(goal[0] - start[0], goal[1] - start[1]) + self.angle_weight * (pi - turn)
            if away >= self.min_distance:
                return start, goal
        raise InvalidInput(
            f"task.min_distance must leave room for a goal, got {self.min_distance} in a room of "
            f"{scene.size} m; lower it or enlarge the room"
        )

    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """‖Δposition‖ + ``angle_weight`` · |Δθ| [m]."""
        return _distance(pose, goal, self.angle_weight)

    def success(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Position, angle, speed and spin all within tolerance."""
        place = self.position_tolerance, self.angle_tolerance
        rest = self.speed_tolerance, self.spin_tolerance
        return _success(pose, twist, goal, *place, *rest)

    def _free_pose(self, generator: np.random.Generator, body: Body, scene: Scene) -> Pose:
        for _ in range(_TRIES):
            across, up, turn = generator.random(3).tolist()
            angle = pi * (1 - 2 * turn)
            c, s = cos(angle), sin(angle)
            outline = [(c * x - s * y, s * x + c * y) for x, y in body.outline]
            x = _between(across, scene.size[0] / 2 - self.clearance, [p[0] for p in outline])
            y = _between(up, scene.size[1] / 2 - self.clearance, [p[1] for p in outline])
            if not scene.obstacles or scene.is_clear(np.add(outline, (x, y))):
                return x, y, angle
        raise InvalidInput(
            f"scene.obstacles must leave room for the body, got {len(scene.obstacles)} obstacles "
            f"in which {_TRIES} random poses all collide; remove some or enlarge the room"
        )


def _between(fraction: float, half: float, extent: list[float]) -> float:
    """Where the origin may be so that ``extent`` about it stays within ±``half``."""
    low, high = -half - min(extent), half - max(extent)
    return low + fraction * (high - low)


@njit(cache=True)
def _turn(pose, goal):  # pragma: no cover - compiled
    return abs(np.pi - (np.pi + goal - pose) % (2 * np.pi))


@njit(cache=True)
def _distance(pose, goal, angle_weight):  # pragma: no cover - compiled
    distance = np.empty(len(pose))
    for k in range(len(pose)):
        away = np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1])
        distance[k] = away + angle_weight * _turn(pose[k, 2], goal[k, 2])
    return distance


@njit(cache=True)
def _success(pose, twist, goal, position, angle, speed, spin):  # pragma: no cover - compiled
    success = np.empty(len(pose), dtype=np.bool_)
    for k in range(len(pose)):
        success[k] = (
            np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1]) <= position
            and _turn(pose[k, 2], goal[k, 2]) <= angle
            and np.hypot(twist[k, 0], twist[k, 1]) <= speed
            and abs(twist[k, 2]) <= spin
        )
    return success
