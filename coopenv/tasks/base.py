"""What a task has to say."""

from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.body import Body
from coopenv.scene import Scene

Pose: TypeAlias = tuple[float, float, float]  # x, y [m], θ [rad]


@runtime_checkable
class Task(Protocol):
    """Start, goal and success. Stateless: the same object serves every world."""

    def check(self, body: Body, scene: Scene) -> None:
        """Raise `coopenv.errors.InvalidInput` where the task cannot be done with these."""
        ...

    def sample(self, generator: np.random.Generator, body: Body, scene: Scene) -> tuple[Pose, Pose]:
        """Start and goal pose of one world's next episode."""
        ...

    def distance(self, pose: FloatArray, goal: FloatArray) -> FloatArray:
        """How far each world is from its goal, ``(world,)`` [m]; zero only at the goal pose."""
        ...

    def success(self, pose: FloatArray, twist: FloatArray, goal: FloatArray) -> BoolArray:
        """Whether each world is done, ``(world,)``."""
        ...
