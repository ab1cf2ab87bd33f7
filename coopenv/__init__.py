"""Reinforcement learning environments for cooperative object transport, with wrench decomposition.

Importing this package registers its environments with Gymnasium. Where Gymnasium, PettingZoo or
pymunk is missing, all that needs none of them works, and the rest says what to install.
"""

from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from coopenv import rewards, wrench
from coopenv.config import TransportConfig
from coopenv.config.kinds import Maker, add_kinds, dataclasses_of
from coopenv.missing import refusal
from coopenv.observation import BLOCKS, Block
from coopenv.observation.sensor import Sensor
from coopenv.partner import Partner, Player, name_partners
from coopenv.physics.actuators import Actuators
from coopenv.physics.body import Body
from coopenv.physics.hands import Hands
from coopenv.physics.scene import Box, Scene
from coopenv.pushes import PUSHES
from coopenv.randomisation import Ranges
from coopenv.snapshot import Snapshot
from coopenv.tasks import (
    DoorwayTask,
    Episode,
    LiftTask,
    Reference,
    Task,
    TrackingTask,
    TransportTask,
    WalkerAvoidTask,
    WalkerTurnTask,
)
from coopenv.transition import State, Transition

__version__ = version("coopenv")

__all__ = [
    "BLOCKS",
    "PUSHES",
    "Actuators",
    "Block",
    "Body",
    "Box",
    "DoorwayTask",
    "Episode",
    "Hands",
    "LiftTask",
    "Partner",
    "Player",
    "Ranges",
    "Reference",
    "Scene",
    "Sensor",
    "Snapshot",
    "State",
    "Task",
    "TrackingTask",
    "Transition",
    "Transport",
    "TransportConfig",
    "TransportTask",
    "WalkerAvoidTask",
    "WalkerTurnTask",
    "__version__",
    "beam_doorway_v0",
    "beam_lift_v0",
    "beam_tracking_v0",
    "beam_transport_v0",
    "register",
    "rewards",
    "walker_avoid_v0",
    "walker_turn_v0",
    "warmup",
    "wrench",
]

try:
    from coopenv.envs.registry import register
    from coopenv.transport import Transport

    # In the order in which their ids are to be listed.
    # isort: off
    from coopenv import (
        beam_transport_v0,
        beam_doorway_v0,
        beam_tracking_v0,
        walker_avoid_v0,
        walker_turn_v0,
        beam_lift_v0,
    )
except ModuleNotFoundError as error:
    globals()["__getattr__"] = refusal(error, __name__, set(__all__) - set(globals()))


def warmup(report: Callable[[int, int, str], None] | None = None) -> tuple[int, float, str | None]:
    """Compile everything for this processor: see `coopenv.warming.warmup`."""
    from coopenv.warming import warmup as compile_everything  # it needs every agent and partner

    return compile_everything(report)


def _find_partner(value: Any) -> Partner:
    from coopenv.agents.partners import partner_of  # where one is named: they are compiled

    return partner_of(value)


def _partner_kinds() -> dict[str, Maker]:
    from coopenv.agents import controllers, partners

    found = dataclasses_of("coopenv.agents.partners", partners.__all__, vars(partners))
    return {**found, "coopenv.agents.controllers.Gains": controllers.Gains}


name_partners(_find_partner)
add_kinds("coopenv.agents", _partner_kinds)
