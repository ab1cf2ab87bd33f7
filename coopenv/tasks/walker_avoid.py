"""Walker task: drive a body on wheels past an obstacle to a pose behind it."""

from dataclasses import dataclass
from math import hypot, pi

import numpy as np

from coopenv.arrays import FloatArray, Range, between, positive, positive_range, whole
from coopenv.errors import InvalidInput
from coopenv.geometry.clearance import ways_to_boxes, ways_to_walls
from coopenv.geometry.frames import wrapped
from coopenv.geometry.routes import next_stops
from coopenv.observation import Block
from coopenv.physics.body import Body
from coopenv.physics.scene import WALL_THICKNESS, Box, Scene
from coopenv.tasks.base import Episode, Pose
from coopenv.tasks.course import COURSE
from coopenv.tasks.nearest import NEAREST
from coopenv.tasks.rolling import RollingTask, rolling_distance
from coopenv.tasks.transport import TransportTask

_TRIES, _BLOCK = 20_000, 100


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerAvoidTask(RollingTask):
    """Reach a pose behind an obstacle that stands in the way, drawn anew every episode.

    Round all obstacles there is a way on which the body can turn freely.

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

    position_tolerance: float = 0.2  # [m]
    angle_tolerance: float = 0.2  # [rad]
    obstacles: int = 1
    obstacle_size: Range = (0.3, 0.7)  # [m]
    approach: Range = (1.6, 2.4)  # [m]
    beyond: Range = (1.6, 2.4)  # [m]
    offset: float = 0.3  # [m]
    veer: float = 0.4  # [rad]

    def __post_init__(self) -> None:
        TransportTask.__post_init__(self)
        _set = object.__setattr__
        _set(self, "obstacles", whole(self.obstacles, "task.obstacles", at_least=1, at_most=1000))
        _set(self, "obstacle_size", positive_range(self.obstacle_size, "task.obstacle_size"))
        for name in ("approach", "beyond"):
            _set(self, name, positive_range(getattr(self, name), f"task.{name}", or_zero=True))
        for name in ("offset", "veer"):
            _set(self, name, positive(getattr(self, name), f"task.{name}", or_zero=True))

    def way(self, plan: FloatArray, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """`RollingTask.distance` along the shortest way round the episode's obstacles.

        The way is that of a disc about the body (`coopenv.geometry.routes`), the turns at its
        corners count too. Obstacles that the scene has of its own are not in the plan, and not in
        the way.
        """
        stop, way = self.stops(plan, pose, goal)
        return rolling_distance(pose, goal, stop, way, self.angle_weight, self.position_tolerance)

    def stops(
        self, plan: FloatArray, pose: FloatArray, goal: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Where to go first, and the whole way: `coopenv.geometry.routes.next_stops`."""
        boxes = plan[:, 3:].reshape(len(plan), self.obstacles, 5)
        count = np.full(len(plan), self.obstacles)
        return next_stops(pose, goal, boxes, count, plan[:, 1:3], plan[:, 0])

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The ``nearest`` block, and ``course``."""
        return (NEAREST, COURSE)

    @property
    def max_obstacles(self) -> int:
        """The most that an episode brings."""
        return self.obstacles

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` unless start and goal clear the obstacle, and a way round exists."""
        TransportTask.check(self, body, scene)
        needed = body.reach + self.clearance + hypot(*[self.obstacle_size[1]] * 2) / 2  # [m]
        for name in ("approach", "beyond"):
            given = getattr(self, name)
            if given[0] < needed:
                raise InvalidInput(
                    f"task.{name} must be at least {needed:.2f} m, got {given}; keep the obstacle "
                    "off start and goal, or shrink task.obstacle_size"
                )
        self.sample(np.random.default_rng(0), body, scene)

    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """A start, an obstacle in front of it and a goal behind that."""
        radius = body.reach + self.clearance
        free = np.array(scene.size) / 2 - radius
        for _ in range(_TRIES // _BLOCK):
            draws = generator.random((_BLOCK, 8))
            place, angle = free * (2 * draws[:, :2] - 1), pi * (1 - 2 * draws[:, 2])
            line = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            approach = _from(self.approach, draws[:, 3])
            goal = place + (approach + _from(self.beyond, draws[:, 4]))[:, None] * line
            for k in np.flatnonzero((np.abs(goal) <= free).all(axis=1)).tolist():
                across = self.offset * (2 * draws[k, 5] - 1)
                first = place[k] + approach[k] * line[k]
                first += across * np.array([-line[k, 1], line[k, 0]])
                turned = angle[k] + self.veer * (2 * draws[k, 6:] - 1)
                boxes = self._boxes(generator, first, scene)
                rows = [number for box in boxes for number in box.row]
                episode = Episode(
                    start=_pose(place[k], turned[0]),
                    goal=_pose(goal[k], turned[1]),
                    obstacles=boxes,
                    plan=(radius, *scene.size, *rows),  # for `way`
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
        others = np.array(scene.size) * (generator.random((self.obstacles - 1, 2)) - 0.5)
        draws = generator.random((self.obstacles, 3)).tolist()
        return tuple(
            Box(
                center=(x, y),
                size=(between(self.obstacle_size, a), between(self.obstacle_size, b)),
                angle=pi * turn,
            )
            for (x, y), (a, b, turn) in zip([first.tolist(), *others.tolist()], draws, strict=True)
        )

    def _has_way(self, episode: Episode, radius: float, body: Body, scene: Scene) -> bool:
        """Whether both ends have room, and a way for a disc leads from one to the other."""
        far = [side / 2 + WALL_THICKNESS for side in scene.size]
        if not all(box.lies_within(far) for box in episode.obstacles):
            return False
        # Of two worlds, of which one has the start and one the goal
        rows = [box.row for box in (*scene.obstacles, *episode.obstacles)]
        boxes, count = np.array([rows] * 2), np.array([len(rows)] * 2)
        size, outline = np.array([scene.size] * 2), np.array([body.outline] * 2)
        ends = np.array([episode.start, episode.goal])
        if ways_to_walls(outline, ends, size).min() < self.clearance:
            return False
        if ways_to_boxes(outline, ends, boxes, count)[..., 0].min() < self.clearance:
            return False
        _, way = next_stops(ends[:1], ends[1:], boxes, count, size, np.array([radius, radius]))
        return bool(np.isfinite(way[0, 0]))


def _from(ends: Range, fractions: FloatArray) -> FloatArray:
    """Numbers so far on the way from the low end to the high one."""
    return ends[0] + (ends[1] - ends[0]) * fractions


def _pose(place: FloatArray, angle: float) -> Pose:
    x, y = place.tolist()
    return x, y, float(wrapped(angle))
