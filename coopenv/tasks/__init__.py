"""What is to be carried where."""

from coopenv.tasks.base import Episode, FurnishedTask, GuidedTask, MovingTask, Pose, Task
from coopenv.tasks.transport import TransportTask

__all__ = [
    "Episode",
    "FurnishedTask",
    "GuidedTask",
    "MovingTask",
    "Pose",
    "Task",
    "TransportTask",
]
