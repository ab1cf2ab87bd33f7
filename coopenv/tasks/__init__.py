"""What is to be carried where."""

from coopenv.tasks.base import Pose, Task
from coopenv.tasks.transport import TransportTask

__all__ = ["Pose", "Task", "TransportTask"]
