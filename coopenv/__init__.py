"""Learning to carry things together.

Importing this package registers its environments with Gymnasium.
"""

from importlib.metadata import version

import gymnasium

from coopenv import rewards, wrench
from coopenv.body import Body
from coopenv.config import TransportConfig
from coopenv.observation import BLOCKS, Block
from coopenv.partner import Partner, Player
from coopenv.scene import Box, Scene
from coopenv.tasks import Episode, Task, TransportTask
from coopenv.transition import State, Transition
from coopenv.transport import Transport

__version__ = version("coopenv")

__all__ = [
    "BLOCKS",
    "Block",
    "Body",
    "Box",
    "Episode",
    "Partner",
    "Player",
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

from coopenv import beam_transport_v0

_MODULES = {"BeamTransport-v0": beam_transport_v0}

for _name, _module in _MODULES.items():
    gymnasium.register(
        id=f"coopenv/{_name}",
        entry_point=f"{_module.__name__}:single_env",
        vector_entry_point=f"{_module.__name__}:vector_env",
    )
