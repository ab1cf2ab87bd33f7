"""Goal poses: the distance to one, success at one, and random free ones; tasks share these."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from math import cos, pi, sin

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray, positive
from coopenv.compiled import compiled, inlined
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.geometry.frames import rotated, turn_between, wrapped
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks.base import Pose, Task, overrides
from coopenv.transition import State

_TRIES = 10_000  # so many that what one reset finds, others find
# Hooks that have a say in a step beside distance and success
_COUNTS_TOO = ("way", "due", "accepts", "failure")
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
    tries: Iterator[int] | None = None,
) -> Pose | None:
    """A random pose in which the body lies between two corners (x, y) [m] and off all obstacles.

    Uniform in the angle, then in the place; ``None`` where ten thousand tries found none, or when
    ``tries``, which several calls may share, come to their end.
    """
    for _ in range(_TRIES) if tries is None else tries:
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


class PoseClock:
    """Time, distance, success and end of all episodes of a task that asks for a pose, in one pass.

    To the bits of asking the task for one after the other.

    Parameters
    ----------
    task
        One that this `applies` to.
    dt
        Control step [s].
    horizon
        Control steps after which an episode is truncated.
    """

    def __init__(self, task: PoseTask, *, dt: float, horizon: int):
        self._limits = dt, horizon
        self._tolerances = (
            task.angle_weight, task.position_tolerance, task.angle_tolerance,
            task.speed_tolerance, task.spin_tolerance,
        )  # fmt: skip

    @staticmethod
    def applies(task: Task) -> bool:
        """Whether a task's distance and success are those of `PoseTask`, and all that counts."""
        kind = type(task)
        own = isinstance(task, PoseTask) and (kind.distance, kind.success) == (
            PoseTask.distance,
            PoseTask.success,
        )
        return own and not task.moves and not any(overrides(task, name) for name in _COUNTS_TOO)

    def arrive(
        self, pose: FloatArray, twist: FloatArray, goal: FloatArray, steps: IntArray,
        ended: BoolArray,
    ) -> tuple[State, BoolArray, BoolArray, bool]:  # fmt: skip
        """What a step led to; ``steps`` and ``ended`` ``(world,)`` go on.

        Parameters
        ----------
        pose, twist, goal
            ``(world, 3)`` each; the pose's angle is wrapped in the state.

        Returns
        -------
        The state; which worlds ``(world,)`` are done, and which ran out of time; whether any ended.
        """
        count = len(pose)
        reached, distance, time = np.empty((count, 3)), np.empty(count), np.empty(count)
        success, truncated = np.empty(count, dtype=np.bool_), np.empty(count, dtype=np.bool_)
        some = _arrive(
            *sharing_rows(count), self._limits, self._tolerances, pose, twist, goal, steps, ended,
            reached, distance, time, success, truncated,
        )  # fmt: skip
        state = State(pose=reached, twist=twist, goal=goal, distance=distance, time=time)
        return state, success, truncated, some


@inlined
def _apart(pose, goal, k):
    """How far world ``k`` is from its goal, in place [m] and angle [rad]."""
    away = np.hypot(goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1])
    return away, turn_between(pose[k, 2], goal[k, 2])


@inlined
def _rests(away, turn, twist, k, position, angle, speed, spin):
    """Whether a body so far from its goal is there, and at rest."""
    there = away <= position and turn <= angle
    return there and np.hypot(twist[k, 0], twist[k, 1]) <= speed and abs(twist[k, 2]) <= spin


@compiled
def _write_distance(pose, goal, angle_weight, distance):
    for k in range(len(pose)):
        away, turn = _apart(pose, goal, k)
        distance[k] = away + angle_weight * turn


@compiled
def _write_success(pose, twist, goal, position, angle, speed, spin, success):
    for k in range(len(pose)):
        away, turn = _apart(pose, goal, k)
        success[k] = _rests(away, turn, twist, k, position, angle, speed, spin)


@compiled
def _arrive_part(
    start, stop, limits, tolerances, pose, twist, goal, steps, ended,
    reached, distance, time, success, truncated,
):  # fmt: skip
    dt, horizon = limits
    angle_weight, position, angle, speed, spin = tolerances
    for k in range(start, stop):
        steps[k] += 1
        time[k] = steps[k] * dt
        reached[k, 0], reached[k, 1], reached[k, 2] = pose[k, 0], pose[k, 1], wrapped(pose[k, 2])
        away, turn = _apart(reached, goal, k)
        distance[k] = away + angle_weight * turn
        success[k] = _rests(away, turn, twist, k, position, angle, speed, spin)
        truncated[k] = steps[k] >= horizon and not success[k]
        ended[k] = truncated[k] or success[k]


@compiled
def _arrive(
    board, parts, limits, tolerances, pose, twist, goal, steps, ended,
    reached, distance, time, success, truncated,
):  # fmt: skip
    """See `PoseClock.arrive`; whether any ended."""
    arguments = (
        limits, tolerances, pose, twist, goal, steps, ended,
        reached, distance, time, success, truncated,
    )  # fmt: skip
    spread(board, parts, len(pose), _arrive_part, arguments)
    some = False
    for k in range(len(ended)):
        some |= ended[k]
    return some
