"""Tasks for a body on wheels: drive and turn to a pose, and drive there past an obstacle."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import Any

import numpy as np
from numba import njit

from coopenv.arrays import FloatArray, positive, whole
from coopenv.body import Body
from coopenv.errors import InvalidInput
from coopenv.routes import next_stops
from coopenv.scene import WALL_THICKNESS, Box, Scene
from coopenv.tasks.base import Episode, Pose
from coopenv.tasks.transport import TransportTask

_TRIES = 2000
_CHECKED_EVERY = 0.1  # [m] of a way along which the body must have room

Range = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class RollingTask(TransportTask):
    """`TransportTask` for a body that cannot move sideways; its distance knows that.

    The way to the goal counts as a turn towards it, a straight drive (forwards or backwards,
    whichever is cheaper) and a turn into the goal's angle.
    """

    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """ρ + w (s(|α| + |β|) + (1 − s)|Δθ|) [m], s = ρ² / (ρ² + ρ₀²).

        ρ is the distance, α the turn from the heading to the way, β the turn from the way to the
        goal's angle, w ``angle_weight`` and ρ₀ ``position_tolerance``: within it there is no way
        left to turn to.
        """
        return _rolling_distance(pose, goal, self.angle_weight, self.position_tolerance)

    def _is_clear(self, poses: FloatArray, body: Body, scene: Scene) -> bool:
        """Whether the outline keeps ``clearance`` from walls and off obstacles at all poses."""
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        x, y = np.array(body.outline).T
        outlines = np.stack(
            [c * x - s * y + poses[:, 0, None], s * x + c * y + poses[:, 1, None]], axis=-1
        )  # (pose, vertex, 2)
        if (np.abs(outlines) > np.array(scene.size) / 2 - self.clearance).any():
            return False
        return not scene.obstacles or all(scene.is_clear(outline) for outline in outlines)


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerTurnTask(RollingTask):
    """Reach a pose that lies at the end of a random straight, an arc and another straight.

    The goal can be reached by driving forwards and turning along that way, which is free of walls
    and obstacles.

    Parameters
    ----------
    path_length
        Shortest and longest way from start to goal [m].
    turn
        Smallest and largest angle of the arc, to either side [rad].

    Raises
    ------
    InvalidInput
        If a range is not two numbers in order, or another value breaks its rule.
    """

    path_length: Range = (1.5, 3.5)  # [m]
    turn: Range = (0.4, 1.8)  # [rad]

    def __post_init__(self) -> None:
        TransportTask.__post_init__(self)
        _set = object.__setattr__
        _set(self, "path_length", _range(self.path_length, "task.path_length", unit="metres"))
        _set(self, "turn", _range(self.turn, "task.turn", unit="radians", at_most=2 * pi))

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` unless the object can turn freely and finds a way."""
        TransportTask.check(self, body, scene)
        self.sample(np.random.default_rng(0), body, scene)

    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """A free start whose way leads to a free goal."""
        half = np.array(scene.size) / 2
        for _ in range(_TRIES):
            draw = generator.random(8)
            start = np.array([*(half * (2 * draw[:2] - 1)), pi * (1 - 2 * draw[2])])
            way = _way(
                start,
                length=_between(self.path_length, draw[3]),
                turn=_between(self.turn, draw[4]) * (1 if draw[5] < 0.5 else -1),
                arc=0.3 + 0.4 * draw[6],
                before=draw[7],
            )
            if self._is_clear(way[[0, -1]], body, scene) and self._is_clear(way, body, scene):
                (x, y, angle), goal = way[0].tolist(), way[-1].tolist()
                if self.distance(way[:1], way[-1:])[0] >= self.min_distance:
                    return (x, y, angle), (goal[0], goal[1], pi - (pi - goal[2]) % (2 * pi))
        raise InvalidInput(
            f"task.path_length must leave room for a way, got {self.path_length} m in a room of "
            f"{scene.size} m with {len(scene.obstacles)} obstacles; shorten it or enlarge the room"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerAvoidTask(RollingTask):
    """Reach a pose behind an obstacle that stands in the way, drawn anew every episode.

    Round every obstacle there is a way on which the body can turn freely.

    Parameters
    ----------
    obstacles
        How many; the first stands between start and goal, others anywhere.
    obstacle_size
        Smallest and largest side of an obstacle [m].
    approach, beyond
        Range of the distance from the start to the first obstacle's centre, and from there to the
        goal [m].
    offset
        By how much, at most, that obstacle stands beside the line from start to goal [m].
    veer
        By how much, at most, the heading at start and goal differs from that line [rad].

    Raises
    ------
    InvalidInput
        If a range is not two numbers in order, or another value breaks its rule.
    """

    obstacles: int = 1
    obstacle_size: Range = (0.3, 0.7)  # [m]
    approach: Range = (1.6, 2.4)  # [m]
    beyond: Range = (1.6, 2.4)  # [m]
    offset: float = 0.3  # [m]
    veer: float = 0.4  # [rad]

    def __post_init__(self) -> None:
        TransportTask.__post_init__(self)
        _set = object.__setattr__
        _set(self, "obstacles", whole(self.obstacles, "task.obstacles", at_least=1))
        for name in ("obstacle_size", "approach", "beyond"):
            _set(self, name, _range(getattr(self, name), f"task.{name}", unit="metres"))
        for name in ("offset", "veer"):
            _set(self, name, positive(getattr(self, name), f"task.{name}", or_zero=True))

    @property
    def max_obstacles(self) -> int:
        """The most that an episode brings."""
        return self.obstacles

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` unless start and goal clear the obstacle, and a way round exists."""
        TransportTask.check(self, body, scene)
        widest = hypot(self.obstacle_size[1], self.obstacle_size[1]) / 2
        for name in ("approach", "beyond"):
            needed = body.reach + self.clearance + widest  # [m]
            if getattr(self, name)[0] < needed:
                raise InvalidInput(
                    f"task.{name} must start at {needed:.2f} m at least, got "
                    f"{getattr(self, name)}; keep obstacles off start and goal, or shrink "
                    "task.obstacle_size"
                )
        self.sample(np.random.default_rng(0), body, scene)

    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """A start, an obstacle in front of it and a goal behind that."""
        radius = body.reach + self.clearance
        free = np.array(scene.size) / 2 - radius
        for _ in range(_TRIES):
            draw = generator.random(6)
            place, direction = free * (2 * draw[:2] - 1), pi * (1 - 2 * draw[2])
            approach, beyond = _between(self.approach, draw[3]), _between(self.beyond, draw[4])
            line = np.array([cos(direction), sin(direction)])
            goal = place + (approach + beyond) * line
            if (np.abs(goal) > free).any():
                continue
            aside = self.offset * (2 * draw[5] - 1) * np.array([-line[1], line[0]])
            boxes = self._boxes(generator, place + approach * line + aside, scene)
            start_angle, goal_angle = direction + self.veer * (2 * generator.random(2) - 1)
            episode = Episode(
                start=_pose(place, start_angle), goal=_pose(goal, goal_angle), obstacles=boxes
            )
            if self._has_way(episode, radius, body, scene):
                return episode
        raise InvalidInput(
            f"scene.size must leave a way round task.obstacles, got a room of {scene.size} m for "
            f"{self.obstacles} beside {len(scene.obstacles)} of its own; enlarge it or draw fewer"
        )

    def _boxes(
        self, generator: np.random.Generator, first: FloatArray, scene: Scene
    ) -> tuple[Box, ...]:
        centers = [first]
        for _ in range(self.obstacles - 1):
            centers.append(np.array(scene.size) * (generator.random(2) - 0.5))
        boxes = []
        for center in centers:
            draw = generator.random(3)
            sides = _between(self.obstacle_size, draw[0]), _between(self.obstacle_size, draw[1])
            x, y = center.tolist()
            boxes.append(Box(center=(x, y), size=sides, angle=float(pi * draw[2])))
        return tuple(boxes)

    def _has_way(self, episode: Episode, radius: float, body: Body, scene: Scene) -> bool:
        far = np.array(scene.size) / 2 + WALL_THICKNESS
        boxes = (*scene.obstacles, *episode.obstacles)
        if any((np.abs(box.vertices) > far).any() for box in episode.obstacles):
            return False
        ends = np.array([episode.start, episode.goal])
        for box in boxes:
            away = ends[:, :2] - box.center
            c, s = cos(box.angle), sin(box.angle)
            across = np.abs(away @ np.array([[c, -s], [s, c]])) - np.array(box.size) / 2
            if (np.linalg.norm(np.maximum(across, 0.0), axis=1) < radius).any():
                return False
        rows = np.array([[(*box.center, *box.size, box.angle) for box in boxes]])
        _, length = next_stops(
            ends[:1],
            ends[1:],
            rows,
            np.array([len(boxes)]),
            np.array([scene.size]),
            np.array([radius]),
        )
        return bool(np.isfinite(length[0])) and self._is_clear(ends, body, scene)


def _way(start: FloatArray, *, length: float, turn: float, arc: float, before: float) -> FloatArray:
    """Poses ``(point, 3)`` along a straight, an arc of ``arc`` of the length, and a straight."""
    steps = max(int(np.ceil(length / _CHECKED_EVERY)), 8)
    along = (np.arange(steps) + 0.5) / steps  # [of the length] middle of each step
    begin = before * (1 - arc)
    middle = start[2] + turn * np.clip((along - begin) / arc, 0.0, 1.0)
    ends = start[2] + turn * np.clip((np.arange(1, steps + 1) / steps - begin) / arc, 0.0, 1.0)
    way = np.empty((steps + 1, 3))
    way[0] = start
    way[1:, 0] = start[0] + np.cumsum(np.cos(middle)) * length / steps
    way[1:, 1] = start[1] + np.cumsum(np.sin(middle)) * length / steps
    way[1:, 2] = ends
    return way


def _pose(place: FloatArray, angle: float) -> Pose:
    x, y = place.tolist()
    return x, y, float(pi - (pi - angle) % (2 * pi))


def _between(ends: Range, fraction: float) -> float:
    return float(ends[0] + fraction * (ends[1] - ends[0]))


def _range(value: Any, name: str, *, unit: str, at_most: float = np.inf) -> Range:
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        raise InvalidInput(
            f"{name} must be two numbers (least, most), got {value!r}; give them in {unit}"
        )
    least = positive(value[0], name, unit=unit, or_zero=True)
    most = positive(value[1], name, unit=unit)
    if not least <= most <= at_most:
        raise InvalidInput(
            f"{name} must be (least, most) in order and at most {at_most:.4g}, got {value!r}; "
            "swap or change them"
        )
    return least, most


@njit(cache=True)
def _rolling_distance(pose, goal, angle_weight, blur):  # pragma: no cover - compiled
    distance = np.empty(len(pose))
    for k in range(len(pose)):
        dx, dy = goal[k, 0] - pose[k, 0], goal[k, 1] - pose[k, 1]
        away = np.hypot(dx, dy)
        between = abs(_wrapped(goal[k, 2] - pose[k, 2]))
        turns = between
        if away > 0.0:
            way = np.arctan2(dy, dx)
            into, out_of = _wrapped(way - pose[k, 2]), _wrapped(goal[k, 2] - way)
            forwards = abs(into) + abs(out_of)
            backwards = 2 * np.pi - forwards  # both turns the other way round by half a turn
            share = away * away / (away * away + blur * blur)
            turns = share * min(forwards, backwards) + (1 - share) * between
        distance[k] = away + angle_weight * turns
    return distance


@njit(cache=True)
def _wrapped(angle):  # pragma: no cover - compiled
    return np.pi - (np.pi - angle) % (2 * np.pi)
