"""What a task has to say, and what it may say besides."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.observation import Block
from coopenv.physics.body import Body
from coopenv.physics.scene import Box, Scene

Pose: TypeAlias = tuple[float, float, float]  # x, y [m], θ [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """What a task draws for one world's next episode."""

    start: Pose
    goal: Pose  # of a moving goal: where it is when the episode begins
    obstacles: tuple[Box, ...] = ()  # beside those of the scene; at most the task's max_obstacles
    plan: tuple[float, ...] = ()  # numbers the task reads back later; as many in every episode


@runtime_checkable
class Task(Protocol):
    """Start, goal and success. Stateless: the same object serves every world.

    Besides, a task may be a `FurnishedTask`, a `WayTask`, a `MovingTask`, a `JudgedTask`, a
    `GuidedTask`, a `SensedTask`, a `MarkedTask`.
    """

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `coopenv.errors.InvalidInput` where the task cannot be done with these."""
        ...

    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """Start and goal pose of one world's next episode, or a whole `Episode`."""
        ...

    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """How far each world is from its goal, ``(world,)`` [m]; zero only at the goal pose."""
        ...

    def success(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Whether each world is done, ``(world,)``."""
        ...


@runtime_checkable
class FurnishedTask(Protocol):
    """A task whose episodes bring obstacles of their own."""

    @property
    def max_obstacles(self) -> int:
        """The most that an `Episode` of it has."""
        ...


@runtime_checkable
class MovingTask(Protocol):
    """A task whose goal moves, or which cannot be done before some time."""

    def goal_at(self, plan: FloatArray, time: FloatArray) -> FloatArray:
        """Where the goals are, ``(world, 3)``, for plans ``(world, number)`` and times [s]."""
        ...

    def due(self, plan: FloatArray, time: FloatArray) -> BoolArray:
        """Whether success counts yet, ``(world,)``."""
        ...


@runtime_checkable
class GuidedTask(Protocol):
    """A task that does not tell every agent everything about the goal."""

    def told(self, num_agents: int) -> BoolArray:
        """``(agent, 2)``: who is told the goal's place, and its angle."""
        ...


@runtime_checkable
class WayTask(Protocol):
    """A task whose episodes have a layout that the way to the goal leads through."""

    def way(self, plan: FloatArray, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """How far each world is from its goal, ``(world,)`` [m], under its plan.

        Instead of ``distance`` wherever there is a plan: ``plan`` is ``(world, number)``. Zero only
        at the goal pose, and without steps, so that `coopenv.rewards.Progress` leads along it.
        """
        ...


@runtime_checkable
class JudgedTask(Protocol):
    """A task that is done only if the whole episode was good."""

    def accepts(self, mean_distance: FloatArray) -> BoolArray:
        """Whether success may count, ``(world,)``, given the mean distance [m] over the steps."""
        ...


@runtime_checkable
class SensedTask(Protocol):
    """A task that brings observation blocks of its own."""

    @property
    def blocks(self) -> Sequence[Block]:
        """Blocks that ``observe`` may name beside `coopenv.BLOCKS`."""
        ...


@runtime_checkable
class MarkedTask(Protocol):
    """A task with something for people to see: lines on the floor of the picture."""

    def markings(self, plan: FloatArray) -> Sequence[FloatArray]:
        """Lines ``(point, 2)`` [m], world frame, for one world's plan ``(number,)``."""
        ...
