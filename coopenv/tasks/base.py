"""Base class of tasks: four methods to write, hooks with neutral defaults, and a drawn episode."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from inspect import get_annotations
from typing import Any, ClassVar, TypeAlias

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import UnknownName
from coopenv.physics.body import Body
from coopenv.physics.scene import Box, Scene

Pose: TypeAlias = tuple[float, float, float]  # x, y [m], θ [rad]

_ALIKE = 0.8  # of 1: similarity from which a name is taken for a misspelt one


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """What a task draws for one world's next episode."""

    start: Pose
    goal: Pose  # of a moving goal: where it is when the episode begins
    obstacles: tuple[Box, ...] = ()  # beside those of the scene; at most the task's max_obstacles
    plan: tuple[float, ...] = ()  # numbers the task reads back later; as many in every episode


class Task(ABC):
    """Start, goal and success of every episode; a task of your own inherits from it.

    `check`, `sample`, `distance` and `success` have to be written, the rest is neutral unless a
    class overrides it. A task is stateless: the same object serves every world.

    Raises
    ------
    UnknownName
        When a class is made, if one of its public methods, properties or values without annotation
        is none of these but has nearly the name of one. Fields of a dataclass may have any name.

    Examples
    --------
    >>> class Slow(TransportTask):
    ...     def sucess(self, pose, twist, goal):
    ...         return np.hypot(*twist[:, :2].T) < 0.01
    Traceback (most recent call last):
    coopenv.errors.UnknownName: hook of task Slow must be one of the known names, got 'sucess'; ...
    """

    __slots__ = ()

    # Values, so that a class may override them by a value, a field or a property; hence Any.
    max_obstacles: Any = 0
    """int: the most obstacles that an `Episode` of it brings; none."""

    blocks: Any = ()
    """Sequence[Block]: what ``observe`` may name beside `coopenv.BLOCKS`; nothing."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        inherited = {name for base in cls.__mro__[1:] for name in vars(base)}
        for name in sorted(vars(cls).keys() - inherited - get_annotations(cls).keys()):
            if not name.startswith("_") and get_close_matches(name, HOOKS, cutoff=_ALIKE):
                raise UnknownName(f"hook of task {cls.__name__}", name, HOOKS)

    @abstractmethod
    def check(self, body: Body, scene: Scene) -> None:
        """Raise `coopenv.errors.InvalidInput` where the task cannot be done with these."""

    def check_strength(self, body: Body, scene: Scene, force: float) -> None:  # noqa: B027
        """Raise `coopenv.errors.InvalidInput` where a team is too weak; never.

        ``force`` [N] is more than all agents together give in any direction.
        """

    @abstractmethod
    def sample(
        self, generator: np.random.Generator, body: Body, scene: Scene
    ) -> tuple[Pose, Pose] | Episode:
        """Start and goal pose of one world's next episode, or a whole `Episode`."""

    @abstractmethod
    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """How far each world is from its goal, ``(world,)`` [m]; zero only at the goal pose."""

    @abstractmethod
    def success(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Whether each world is done, ``(world,)``."""

    def failure(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Whether each world has failed, ``(world,)``, which ends its episode; never.

        Where success and failure meet, it is a failure.
        """
        return np.zeros(len(pose), dtype=np.bool_)

    @property
    def moves(self) -> bool:
        """Whether the goal moves within an episode: where `goal_at` is overridden."""
        return overrides(self, "goal_at")

    def goal_at(self, plan: FloatArray, time: FloatArray) -> FloatArray:
        """Where moving goals are, ``(world, 3)``, for plans ``(world, number)`` and times [s].

        A goal that does not move stays where its `Episode` has it, and this is not asked.
        """
        raise NotImplementedError(f"the goal of {type(self).__name__} does not move")

    def due(self, plan: FloatArray, time: FloatArray) -> BoolArray:
        """Whether success counts yet, ``(world,)``, for plans and times [s]; always."""
        return np.ones(len(time), dtype=np.bool_)

    def accepts(self, mean_distance: FloatArray) -> BoolArray:
        """Whether success may count, ``(world,)``, given the mean distance [m] over the steps.

        Always; a task that is done only if the whole episode was good overrides it.
        """
        return np.ones(len(mean_distance), dtype=np.bool_)

    def told(self, num_agents: int) -> BoolArray:
        """``(agent, 2)``: who is told the goal's place, and its angle; everybody."""
        return np.ones((num_agents, 2), dtype=np.bool_)

    def partner_agents(self, num_agents: int) -> tuple[int, ...]:
        """Agents that a partner drives unless ``partner_agents`` says otherwise; the last one."""
        return (num_agents - 1,)

    def way(self, plan: FloatArray, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """How far each world is from its goal under its plan ``(world, number)``, ``(world,)`` [m].

        It is ``distance`` unless a layout lies in the plan that the way to the goal leads through.
        Zero only at the goal pose, and without steps, so that `coopenv.rewards.Progress` leads
        along it.
        """
        return self.distance(pose, goal)

    def markings(self, plan: FloatArray) -> Sequence[FloatArray]:
        """Lines ``(point, 2)`` [m] on the floor of pictures, for one world's plan ``(number,)``.

        World frame; none.
        """
        return ()


HOOKS = tuple(name for name in vars(Task) if not name.startswith("_"))


def overrides(task: Task, hook: str) -> bool:
    """Whether a task has a hook of its own, so that nobody needs to ask for the neutral answer."""
    return getattr(type(task), hook) is not getattr(Task, hook)


class _TaskWithHook(Task):
    """What a task with a hook was called when only some had hooks; every task has all now."""

    __slots__ = ()
    _hook: ClassVar[str]

    @classmethod
    def __subclasshook__(cls, other: type) -> bool:
        """Any task that overrides the hook counts, whether it inherits from this or not."""
        if "_hook" not in vars(cls):
            return NotImplemented
        own = getattr(other, cls._hook, None)
        return Task in other.__mro__ and own is not getattr(Task, cls._hook)


class FurnishedTask(_TaskWithHook):
    """A task whose episodes bring obstacles."""

    __slots__ = ()
    _hook = "max_obstacles"


class GuidedTask(_TaskWithHook):
    """A task that does not tell every agent all of the goal."""

    __slots__ = ()
    _hook = "told"


class JudgedTask(_TaskWithHook):
    """A task that is done only if the whole episode was good."""

    __slots__ = ()
    _hook = "accepts"


class MarkedTask(_TaskWithHook):
    """A task with lines on the floor of pictures."""

    __slots__ = ()
    _hook = "markings"


class MovingTask(_TaskWithHook):
    """A task whose goal moves."""

    __slots__ = ()
    _hook = "goal_at"


class SensedTask(_TaskWithHook):
    """A task with observation blocks of its own."""

    __slots__ = ()
    _hook = "blocks"


class WayTask(_TaskWithHook):
    """A task with a way to the goal that differs from the distance."""

    __slots__ = ()
    _hook = "way"
