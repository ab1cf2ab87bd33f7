"""Other machines that work on the cells of an experiment: what they are sent, and send back."""

from .on_ray import joined
from .spread import AT_A_TIME, NodeLost, Nodes, Spread, Told
from .work import work_on

__all__ = ["AT_A_TIME", "NodeLost", "Nodes", "Spread", "Told", "joined", "work_on"]
