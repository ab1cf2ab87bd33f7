"""What is to be carried where."""

from coopenv.tasks.base import Episode, FurnishedTask, GuidedTask, MovingTask, Pose, Task
from coopenv.tasks.transport import TransportTask
from coopenv.tasks.walker import RollingTask, WalkerAvoidTask, WalkerTurnTask

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
]
