"""Learning to carry things together.

Importing this package registers its environments with Gymnasium.
"""

from importlib.metadata import version

import gymnasium

from coopenv import rewards, wrench
from coopenv.body import Body
from coopenv.config import TransportConfig
from coopenv.observation import BLOCKS, Block
from coopenv.scene import Box, Scene
from coopenv.tasks import Task, TransportTask
from coopenv.transition import State, Transition
from coopenv.transport import Transport

__version__ = version("coopenv")

__all__ = [
    "BLOCKS",
    "Block",
    "Body",
    "Box",
    "Scene",
    "State",
    "Task",
    "Transition",
    "Transport",
    "TransportConfig",
    "TransportTask",
    "__version__",
    "beam_transport_v0",
    "rewards",
    "wrench",
]

gymnasium.register(
    id="coopenv/BeamTransport-v0",
    entry_point="coopenv.envs:TransportEnv",
    vector_entry_point="coopenv.envs:TransportVectorEnv",
)

from coopenv import beam_transport_v0  # noqa: E402  - a view of all the above
