"""Doorway task: from one platform through a gap in a wall to another, as in the human study.

    +-----------------------------------+
    | start       |  |             goal |
    | platform    |  |         platform |
    |                gap                |
    |             |  |                  |
    |             |  |                  |
    +-----------------------------------+

Source: Donner, Endo & Buss 2018, section VI; room and layouts are ours, the paper prints none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import (
    BoolArray,
    FloatArray,
    Range,
    between,
    number_range,
    positive_range,
    stated_array,
    whole,
)
from coopenv.errors import InvalidInput
from coopenv.observation import Block
from coopenv.physics.body import Body
from coopenv.physics.scene import Box, Scene
from coopenv.tasks.base import Episode, Pose
from coopenv.tasks.passage import narrowest, seen_gap, way_through
from coopenv.tasks.pose import PoseTask, free_pose
from coopenv.transition import Transition

Rectangle = tuple[tuple[float, float], tuple[float, float]]  # lower left and upper right corner [m]

GUIDES = ("both", "one", "none")
_TRIES = 10_000


def _read_gap(transition: Transition) -> FloatArray:
    pose, conditions = transition.next_state.pose, transition.conditions
    return seen_gap(conditions.plan, pose, conditions.team.frame)


GAP = Block(
    name="gap",
    size=5,
    describe="way from the object to the gap's centre: Δx, Δy, direction of the passage: cos, sin, "
    "and the gap's width",
    read=_read_gap,
    unit="m, m, 1, 1, m",
    frame="agent",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DoorwayTask(PoseTask):
    """From a start platform through a gap to a final platform, with a layout for every episode.

    The distance leads through the gap: to a place from which the object can enter it lengthwise,
    through it, and on to the goal, with the turns that this takes. The goal's place is told to
    all, its angle to those that ``guide`` names; the others can learn it from their partner only.
    With ``guide="none"`` nobody can know the angle: success is then a matter of luck unless
    ``angle_tolerance`` is raised to π, at which any angle will do.

    Parameters
    ----------
    gap
        Range of the gap's width. By default narrower than the beam is long and wider than it is
        thick, so that it has to be turned to pass.
    gap_position
        Range of the y of the gap's centre.
    wall
        Range of the x of the wall's middle.
    wall_thickness
        How deep the gap is.
    start_platform, goal_platform
        Corners of the platforms, left and right of the wall; the whole object starts on one and is
        to rest on the other.
    guide
        Who is told the goal's angle: ``"both"`` (all agents), ``"one"`` (agent 0), ``"none"``, an
        agent's number, or a sequence of numbers.

    Raises
    ------
    InvalidInput
        If a value breaks its rule; `check` says so of what depends on body and room.
    """

    clearance: float = 0.05  # [m] kept from platform edges at start and goal, and spared by a gap
    gap: Range = (0.6, 0.9)  # [m]
    gap_position: Range = (-1.0, 1.0)  # [m]
    wall: Range = (-0.2, 0.2)  # [m]
    wall_thickness: float = 0.2  # [m]
    start_platform: Rectangle = ((-3.5, -2.0), (-1.3, 2.0))  # [m]
    goal_platform: Rectangle = ((1.3, -2.0), (3.5, 2.0))  # [m]
    guide: str | int | Sequence[int] = "both"

    def __post_init__(self) -> None:
        PoseTask.__post_init__(self)
        self._check_positive("wall_thickness")
        _set = object.__setattr__
        _set(self, "gap", positive_range(self.gap, "task.gap"))
        for name in ("gap_position", "wall"):
            _set(self, name, number_range(getattr(self, name), f"task.{name}"))
        for name in ("start_platform", "goal_platform"):
            _set(self, name, _rectangle(getattr(self, name), f"task.{name}"))
        left = self.wall[0] - self.wall_thickness / 2 - self.start_platform[1][0]  # [m]
        right = self.goal_platform[0][0] - self.wall[1] - self.wall_thickness / 2
        if min(left, right) < 0:
            name = "start_platform" if left < 0 else "goal_platform"
            raise InvalidInput(
                f"task.{name} must keep clear of the wall, got {getattr(self, name)} and a wall "
                f"of {self.wall_thickness} m at {self.wall}; move it away from the middle"
            )
        _set(self, "guide", _guide(self.guide))

    @property
    def max_obstacles(self) -> int:
        """The wall's part below the gap and the one above it."""
        return 2

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The ``gap`` block."""
        return (GAP,)

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `InvalidInput` where body or room do not go with the layouts."""
        across, up = np.array(scene.size) / 2
        for name in ("start_platform", "goal_platform"):
            corners = np.abs(getattr(self, name)).max(axis=0)  # [m]
            if (corners > (across, up)).any():
                raise InvalidInput(
                    f"task.{name} must lie in the room, got {getattr(self, name)} in a room of "
                    f"{scene.size} m around the origin; move or shrink it, or enlarge scene.size"
                )
        needed = narrowest(body.outline).width + 2 * self.clearance  # [m]
        if self.gap[0] < needed:
            raise InvalidInput(
                f"task.gap must be at least {needed:.2f} m, the body's width with clearance, got "
                f"{self.gap}; widen it, or narrow body.outline or task.clearance"
            )
        farthest = np.abs(self.gap_position).max() + self.gap[1] / 2  # [m]
        if farthest >= up:
            raise InvalidInput(
                f"task.gap_position must leave wall on both sides of a gap of {self.gap[1]} m in a "
                f"room {scene.size[1]} m high, got {self.gap_position}; narrow it"
            )
        self.told(body.num_agents)
        self.sample(np.random.default_rng(0), body, scene)  # raises where no layout is possible

    def sample(self, generator: np.random.Generator, body: Body, scene: Scene) -> Episode:
        """A layout, and a start and a goal with the whole object on the platforms."""
        plan = self._layout(generator, body, scene)
        return Episode(
            start=self._pose_on("start_platform", generator, body, scene),
            goal=self._pose_on("goal_platform", generator, body, scene),
            obstacles=self._boxes(plan, scene),
            plan=plan,
        )

    def way(self, plan: FloatArray, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """Length of the way through the gap, and ``angle_weight`` times the turns on it [m].

        See `coopenv.tasks.passage.way_through`.
        """
        return way_through(plan, pose, goal, self.angle_weight)

    def told(self, num_agents: int) -> BoolArray:
        """All are told the goal's place; ``guide`` says who its angle."""
        told = np.ones((num_agents, 2), dtype=np.bool_)
        if self.guide == "both":
            return told
        guided = {"one": (0,), "none": ()}.get(self.guide, self.guide)  # pyright: ignore[reportArgumentType, reportCallIssue]
        agents = (guided,) if isinstance(guided, int) else tuple(guided)
        if max(agents, default=0) >= num_agents:
            raise InvalidInput(
                f"task.guide must name agents 0 to {num_agents - 1}, got {self.guide!r}; "
                "name one that is there"
            )
        told[:, 1] = False
        told[list(agents), 1] = True
        return told

    def markings(self, plan: FloatArray) -> list[FloatArray]:
        """The platforms' edges."""
        lines = []
        for (x0, y0), (x1, y1) in (self.start_platform, self.goal_platform):
            lines.append(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]))
        return lines

    def _layout(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[float, ...]:
        """Numbers of `coopenv.tasks.passage` for one episode, no obstacle before the gap."""
        shape, half = narrowest(body.outline), self.wall_thickness / 2
        for _ in range(_TRIES):
            x, y, gap = (
                between(ends, part)
                for part, ends in zip(
                    generator.random(3).tolist(),
                    (self.wall, self.gap_position, self.gap),
                    strict=True,
                )
            )
            any_angle = gap >= 2 * (body.reach + self.clearance)
            standoff = half + (0.0 if any_angle else shape.ahead + self.clearance)  # [m]
            corridor = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (standoff, gap / 2)
            if not scene.obstacles or scene.is_clear(np.add(corridor, (x, y))):
                passing = -shape.along, float(any_angle), shape.width, shape.ahead
                return x, y, gap, half, standoff, *passing
        raise InvalidInput(
            f"scene.obstacles must leave the gap free, got {len(scene.obstacles)} obstacles of "
            "which one is always before it; remove some, or move task.gap_position"
        )

    def _boxes(self, plan: tuple[float, ...], scene: Scene) -> tuple[Box, ...]:
        x, y, gap = plan[:3]
        low, high = y - gap / 2, y + gap / 2  # [m]
        half = scene.size[1] / 2
        return tuple(
            Box(center=(x, (start + end) / 2), size=(self.wall_thickness, end - start))
            for start, end in ((-half, low), (high, half))
        )

    def _pose_on(self, name: str, generator: np.random.Generator, body: Body, scene: Scene) -> Pose:
        (x0, y0), (x1, y1) = getattr(self, name)
        inset = self.clearance
        low, high = (x0 + inset, y0 + inset), (x1 - inset, y1 - inset)
        pose = free_pose(generator, body, scene, low, high)
        if pose is None:
            raise InvalidInput(
                f"task.{name} must have room for the body with clearance, got "
                f"{getattr(self, name)} and {len(scene.obstacles)} obstacles in the scene, where "
                "ten thousand random poses do not fit; enlarge it, or take away scene.obstacles"
            )
        return pose


def _rectangle(value: object, name: str) -> Rectangle:
    given = stated_array(value, name)
    if given.shape != (2, 2) or (given[0] >= given[1]).any():
        raise InvalidInput(
            f"{name} must be two corners ((x, y), (x, y)), the lower left one first, got "
            f"{value!r}; give them in metres"
        )
    (x0, y0), (x1, y1) = given.tolist()
    return (x0, y0), (x1, y1)


def _guide(value: object) -> str | int | tuple[int, ...]:
    if isinstance(value, str):
        if value in GUIDES:
            return value
    elif isinstance(value, Sequence):
        return tuple(whole(agent, "task.guide", at_least=0) for agent in value)
    elif isinstance(value, int | np.integer) and not isinstance(value, bool):
        return whole(value, "task.guide", at_least=0)
    raise InvalidInput(
        f"task.guide must be one of {GUIDES}, an agent's number or several, got {value!r}; "
        'pass for example guide="one"'
    )
