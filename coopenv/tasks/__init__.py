"""What is to be carried where."""

from coopenv.tasks.base import (
    Episode,
    FurnishedTask,
    GuidedTask,
    JudgedTask,
    MarkedTask,
    MovingTask,
    Pose,
    SensedTask,
    Task,
    WayTask,
)
from coopenv.tasks.doorway import DoorwayTask
from coopenv.tasks.pose import PoseTask
from coopenv.tasks.reference import Reference
from coopenv.tasks.tracking import TrackingTask
from coopenv.tasks.transport import TransportTask

TASKS = (TransportTask, DoorwayTask, TrackingTask)  # those of this package, as JSON may name them

__all__ = [
    "TASKS",
    "DoorwayTask",
    "Episode",
    "FurnishedTask",
    "GuidedTask",
    "JudgedTask",
    "MarkedTask",
    "MovingTask",
    "Pose",
    "PoseTask",
    "Reference",
    "SensedTask",
    "Task",
    "TrackingTask",
    "TransportTask",
    "WayTask",
]
