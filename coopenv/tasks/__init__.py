"""Tasks: what is to be carried where, and when it is done."""

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
from coopenv.tasks.lift import LiftTask
from coopenv.tasks.pose import PoseTask
from coopenv.tasks.reference import Reference
from coopenv.tasks.rolling import RollingTask
from coopenv.tasks.tracking import TrackingTask
from coopenv.tasks.transport import TransportTask
from coopenv.tasks.walker_avoid import WalkerAvoidTask
from coopenv.tasks.walker_turn import WalkerTurnTask

# Those of this package, as JSON may name them.
TASKS = (
    TransportTask,
    DoorwayTask,
    TrackingTask,
    WalkerAvoidTask,
    WalkerTurnTask,
    LiftTask,
)

__all__ = [
    "TASKS",
    "DoorwayTask",
    "Episode",
    "FurnishedTask",
    "GuidedTask",
    "JudgedTask",
    "LiftTask",
    "MarkedTask",
    "MovingTask",
    "Pose",
    "PoseTask",
    "Reference",
    "RollingTask",
    "SensedTask",
    "Task",
    "TrackingTask",
    "TransportTask",
    "WalkerAvoidTask",
    "WalkerTurnTask",
    "WayTask",
]
