"""ROS bags, of one file or a folder of them."""

from coopenv.logs.formats.bags.folder import require_recording
from coopenv.logs.formats.bags.messages import BagSource, topics

__all__ = ["BagSource", "require_recording", "topics"]
