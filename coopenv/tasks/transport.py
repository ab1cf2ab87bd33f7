"""Transport task: carry the object from a random pose to a random pose and put it to rest there."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from coopenv.errors import InvalidInput
from coopenv.geometry.frames import turn_between
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks.base import Episode, Pose
from coopenv.tasks.pose import PoseTask, free_pose

_TRIES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class TransportTask(PoseTask):
    """Random start, random goal; done when the object rests at the goal pose within tolerance.

    Raises
    ------
    InvalidInput
        If a value is not positive (``clearance`` and ``min_distance`` may be zero).
    """

    min_distance: float = 0.5  # [m] between start and goal, in the task's distance

    def __post_init__(self) -> None:
        PoseTask.__post_init__(self)
        self._check_positive("min_distance")

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
            turn = turn_between(start[2], goal[2])
            away = hypot(goal[0] - start[0], goal[1] - start[1]) + self.angle_weight * turn
            if away >= self.min_distance:
                return start, goal
        raise InvalidInput(
            f"task.min_distance must leave room for a goal, got {self.min_distance} in a room of "
            f"{scene.size} m; lower it or enlarge the room"
        )

    def _free_pose(self, generator: np.random.Generator, body: Body, scene: Scene) -> Pose:
        x, y = (side / 2 - self.clearance for side in scene.size)
        pose = free_pose(generator, body, scene, (-x, -y), (x, y))
        if pose is not None:
            return pose
        raise InvalidInput(
            f"scene.obstacles must leave room for the body, got {len(scene.obstacles)} obstacles "
            f"in which ten thousand random poses all collide; remove some or enlarge the room"
        )
