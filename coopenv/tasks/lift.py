"""Lift task: raise the object from the floor over an obstacle and lay it on a shelf, upright.

+-----------------------------------+
|                                   |
|            +--+                   |
|            |  |     ====goal====  |
|            |  |    +--------------+
| ===start== |  |    |    shelf     |
+------------+--+----+--------------+
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, Range, between, number_range, positive_range
from coopenv.errors import InvalidInput
from coopenv.observation import Block
from coopenv.physics.body import Body
from coopenv.physics.scene import Box, Scene
from coopenv.tasks.base import Episode
from coopenv.tasks.hurdle import laid_down, let_down, seen_down, seen_hurdle, way_over
from coopenv.tasks.pose import PoseTask
from coopenv.transition import Transition


def _read_hurdle(transition: Transition) -> FloatArray:
    conditions = transition.conditions
    return seen_hurdle(conditions.plan, transition.next_state.pose, conditions.team.frame)


def _read_down(transition: Transition) -> FloatArray:
    conditions = transition.conditions
    return seen_down(transition.next_state.pose, conditions.room.gravity, conditions.team.frame)


HURDLE = Block(
    name="hurdle",
    size=4,
    describe="ways from the object's centre to the middle of the obstacle's top and to the shelf's "
    "edge: Δx, Δy each",
    read=_read_hurdle,
    unit="m",
    frame="agent",
)
DOWN = Block(
    name="down",
    size=2,
    describe="direction of gravity: x, y",
    read=_read_down,
    low=-1.0,
    high=1.0,
    unit="1",
    frame="agent",
)


_TRIES = 10_000


@dataclass(frozen=True, slots=True, kw_only=True)
class LiftTask(PoseTask):
    """From the floor over an obstacle onto a shelf, level all the way, anew in every episode.

    Done when the object lies on the shelf at its place, at rest: touching it, not over it. Failed,
    which ends the episode, when it leans more than ``tilt_limit`` or falls faster than
    ``fall_limit``: who lets go of it higher than a hand's breadth has dropped it. The goal's angle
    is 0. The distance leads over the obstacle: beside it up, along, and down onto the shelf.

    Needs a room with gravity straight down. Everybody senses where down is (block ``down``).

    Parameters
    ----------
    start
        Range of the x of the object's centre on the floor [m].
    obstacle, obstacle_height
        Range of the x of the obstacle's middle and of its height over the floor [m].
    obstacle_width
        Along x [m].
    shelf, shelf_height
        Range of the x of the shelf's edge, from where it reaches to the wall, and of its height
        over the floor [m].
    tilt_limit
        How far it may lean [rad], below π.
    fall_limit
        How fast it may go down [m/s].

    Raises
    ------
    InvalidInput
        If a value breaks its rule; `check` says so of what depends on body and room.
    """

    height_tolerance: float = 0.01  # [m] in the shelf; over it, nothing bears the object yet
    start: Range = (-2.8, -2.2)  # [m]
    obstacle: Range = (-0.6, -0.2)  # [m]
    obstacle_height: Range = (0.6, 1.4)  # [m]
    obstacle_width: float = 0.3  # [m]
    shelf: Range = (0.6, 0.9)  # [m]
    shelf_height: Range = (0.4, 1.2)  # [m]
    tilt_limit: float = 0.5  # [rad]
    fall_limit: float = 1.5  # [m/s]

    def __post_init__(self) -> None:
        PoseTask.__post_init__(self)
        self._check_positive("height_tolerance", "obstacle_width", "tilt_limit", "fall_limit")
        if self.tilt_limit >= pi:
            raise InvalidInput(
                f"task.tilt_limit must be below π, got {self.tilt_limit!r}; nothing leans more, "
                "give it in rad"
            )
        for name in ("start", "obstacle", "shelf"):
            object.__setattr__(self, name, number_range(getattr(self, name), f"task.{name}"))
        for name in ("obstacle_height", "shelf_height"):
            object.__setattr__(self, name, positive_range(getattr(self, name), f"task.{name}"))
        gap = self.shelf[0] - self.obstacle[1] - self.obstacle_width / 2  # [m]
        if gap < 0:
            raise InvalidInput(
                f"task.shelf must begin behind the obstacle, got {self.shelf} and an obstacle of "
                f"{self.obstacle_width} m at {self.obstacle}; move it on by {-gap:.2f} m"
            )

    @property
    def max_obstacles(self) -> int:
        """The obstacle and the shelf."""
        return 2

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks ``hurdle`` and ``down``."""
        return HURDLE, DOWN

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` where body or room do not go with the layouts."""
        if scene.gravity[0] != 0.0 or not scene.gravity[1] < 0.0:
            raise InvalidInput(
                f"scene.gravity must point straight down for a lift, got {scene.gravity}; pass "
                "for example gravity=(0.0, -9.81)"
            )
        low, high = _extent(body)
        across = scene.size[0] / 2  # [m]
        spare = self.clearance  # [m]
        left, right = -across - low[0] + spare, self.obstacle[0] - self._half - high[0] - spare
        if self.start[0] < left or self.start[1] > right:
            raise InvalidInput(
                f"task.start must lie within ({left:.2f}, {right:.2f}) m, between the wall and the "
                f"obstacle, got {self.start}; move it, or enlarge the room"
            )
        if self.shelf[1] - low[0] + spare > across - high[0] - spare:
            raise InvalidInput(
                f"task.shelf must leave room for the object before the wall at {across} m, got "
                f"{self.shelf}; move it, or enlarge the room"
            )
        top = max(self.obstacle_height[1], self.shelf_height[1])  # [m] over the floor
        needed = top + 2 * spare + high[1] - low[1]
        if needed > scene.size[1]:
            raise InvalidInput(
                f"scene.size must be at least {needed:.2f} m high to lift it over {top} m, "
                f"got {scene.size}; enlarge it, or lower task.obstacle_height and "
                "task.shelf_height"
            )

    def check_strength(self, body: Body, scene: Scene, force: float) -> None:
        """Raise `InvalidInput` where the body weighs more than the team can bear."""
        most = force / -scene.gravity[1]  # [kg]
        if body.mass >= most:
            raise InvalidInput(
                f"body.mass must be below {most:.4g} kg, which is all that the team bears with its "
                f"force_limit, got {body.mass:g}; raise force_limit, or take a lighter body"
            )

    def sample(self, generator: np.random.Generator, body: Body, scene: Scene) -> Episode:
        """A layout, a start on the floor and a goal on the shelf, off the scene's own obstacles."""
        outline = np.array(body.outline)
        for _ in range(_TRIES):
            episode = self._drawn(generator.random(6).tolist(), body, scene)
            ends = (np.add(outline, pose[:2]) for pose in (episode.start, episode.goal))
            if not scene.obstacles or all(scene.is_clear(end) for end in ends):
                return episode
        raise InvalidInput(
            f"scene.obstacles must leave floor and shelf free, got {len(scene.obstacles)} of which "
            f"one is in the way in each of {_TRIES} layouts; remove some, or move task.start"
        )

    def success(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Place and height, angle, speed and spin all within tolerance."""
        place = self.position_tolerance, self.height_tolerance, self.angle_tolerance
        return laid_down(pose, twist, goal, (*place, self.speed_tolerance, self.spin_tolerance))

    def failure(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Whether the object leans or falls more than it may."""
        return let_down(pose, twist, goal, self.tilt_limit, self.fall_limit)

    def way(self, plan: FloatArray, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """Length of the way over the obstacle, and ``angle_weight`` times the turn [m].

        See `coopenv.tasks.hurdle.way_over`.
        """
        return way_over(plan, pose, goal, self.angle_weight)

    def _drawn(self, part: list[float], body: Body, scene: Scene) -> Episode:
        """The episode that six numbers in [0, 1] stand for."""
        names = ("start", "obstacle", "obstacle_height", "shelf", "shelf_height")
        start, hurdle, height, edge, shelf_height = (
            between(getattr(self, name), fraction)
            for name, fraction in zip(names, part, strict=False)
        )
        low, high = _extent(body)
        (across, up), spare = np.array(scene.size) / 2, self.clearance
        floor, top, shelf = -up, height - up, shelf_height - up  # [m]
        place = between((edge - low[0] + spare, across - high[0] - spare), part[5])
        over = max(hurdle + self._half, edge) - low[0]  # all of it is behind both
        plan = (
            hurdle - self._half - high[0] - spare, over, max(top, shelf) - low[1] + spare,
            hurdle, top, edge, shelf, max(spare, 1e-3),
        )  # fmt: skip
        boxes = (
            Box(center=(hurdle, (floor + top) / 2), size=(self.obstacle_width, height)),
            Box(
                center=((edge + across) / 2, (floor + shelf) / 2),
                size=(across - edge, shelf_height),
            ),
        )
        return Episode(
            start=(start, floor - low[1], 0.0),
            goal=(place, shelf - low[1], 0.0),
            obstacles=boxes,
            plan=tuple(map(float, plan)),
        )

    @property
    def _half(self) -> float:
        """Half the obstacle's width [m]."""
        return self.obstacle_width / 2


def _extent(body: Body) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest x and y of the level outline from its centre of mass [m]."""
    outline = np.array(body.outline)
    return outline.min(axis=0), outline.max(axis=0)
