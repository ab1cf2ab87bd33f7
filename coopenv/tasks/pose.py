"""Goal poses: the distance to one, success at one, and random free ones; tasks share these."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from math import cos, pi, sin

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, positive
from coopenv.compiled import compiled
from coopenv.geometry.frames import rotated, turn_between
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks.base import Pose, Task

_TRIES = 10_000  # so many that what one reset finds, others find
_OR_ZERO = ("clearance", "min_distance")


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseTask(Task):
    """Done when the object rests at the goal pose within tolerance.

    Raises
    ------
    InvalidInput
        If a value is not positive.
    """

    position_tolerance: float = 0.1  # [m]
    angle_tolerance: float = 0.1  # [rad]; from π on any angle will do
    speed_tolerance: float = 0.1  # [m/s]
    spin_tolerance: float = 0.1  # [rad/s]
    angle_weight: float = 0.5  # [m/rad] what turning counts for in the distance
    clearance: float = 0.1  # [m] kept from walls by start and goal; may be zero

    def __post_init__(self) -> None:
        self._check_positive(*(entry.name for entry in fields(PoseTask)))

    def _check_positive(self, *names: str) -> None:
        for name in names:
            value = positive(getattr(self, name), f"task.{name}", or_zero=name in _OR_ZERO)
            object.__setattr__(self, name, value)

    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """‖Δposition‖ + ``angle_weight`` · |Δθ| [m]."""
        distance = np.empty(len(pose))
        _write_distance(pose, goal, self.angle_weight, distance)
        return distance

    def success(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Position, angle, speed and spin all within tolerance."""
        place = self.position_tolerance, self.angle_tolerance
        rest = self.speed_tolerance, self.spin_tolerance
        success = np.empty(len(pose), dtype=np.bool_)
        _write_success(pose, twist, goal, *place, *rest, success)
        return success


def free_pose(
    generator: np.random.Generator,
    body: Body,
    scene: Scene,
    low: Sequence[float],
    high: Sequence[float],
) -> Pose | None:
    """A random pose in which the body lies between two corners (x, y) [m] and off all obstacles.

    Uniform in the angle, then in the place; ``None`` where ten thousand tries found none.
    """
    for _ in range(_TRIES):
        across, up, turn = generator.random(3).tolist()
        angle = pi * (1 - 2 * turn)
        c, s = cos(angle), sin(angle)
        outline = [rotated(c, s, x, y) for x, y in body.outline]
        x = _between(across, low[0], high[0], [point[0] for point in outline])
        y = _between(up, low[1], high[1], [point[1] for point in outline])
        if x is None or y is None:
            continue
        if not scene.obstacles or scene.is_clear(np.add(outline, (x, y))):
            return x, y, angle
    return None


def _between(fraction: float, low: float, high: float, extent: list[float]) -> float | None:
    """Where the origin is if ``extent`` about it stays between bounds that leave room for it."""
    first, last = low - min(extent), high - max(extent)
    return first + fraction * (last - first) if first <= last else None


@compiled
def _write_distance(pose, goal, angle_weight, distance):
    for k in range(len(pose)):
        away = np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1])
        distance[k] = away + angle_weight * turn_between(pose[k, 2], goal[k, 2])


@compiled
def _write_success(pose, twist, goal, position, angle, speed, spin, success):
    for k in range(len(pose)):
        success[k] = (
            np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1]) <= position
            and turn_between(pose[k, 2], goal[k, 2]) <= angle
            and np.hypot(twist[k, 0], twist[k, 1]) <= speed
            and abs(twist[k, 2]) <= spin
        )
