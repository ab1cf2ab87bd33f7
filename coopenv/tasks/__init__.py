"""What is to be carried where."""

from coopenv.tasks.base import Episode, FurnishedTask, GuidedTask, MovingTask, Pose, Task, WayTask
from coopenv.tasks.rolling import RollingTask
from coopenv.tasks.transport import TransportTask
from coopenv.tasks.walker_avoid import WalkerAvoidTask
from coopenv.tasks.walker_turn import WalkerTurnTask

__all__ = [
    "Episode",
    "FurnishedTask",
    "GuidedTask",
    "MovingTask",
    "Pose",
    "RollingTask",
    "Task",
    "TransportTask",
    "WalkerAvoidTask",
    "WalkerTurnTask",
    "WayTask",
]
