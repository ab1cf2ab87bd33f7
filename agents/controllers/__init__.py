"""Scripted controllers, and which of them does which task."""

from typing import Any

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.tasks import DoorwayTask, LiftTask, RollingTask, TrackingTask

from ..policy import RandomPolicy
from .active import ActiveFollower
from .doorway import DoorwayController
from .follower import Follower, Still, released
from .impedance import Gains, ImpedanceController, approach, wrapped
from .lift import LiftController
from .motion import MotionController
from .roles import Roles
from .straight import Along, Straight
from .tracking import TrackingController
from .walker import WalkerController

__all__ = [
    "CONTROLLERS",
    "ActiveFollower",
    "Along",
    "DoorwayController",
    "Follower",
    "Gains",
    "ImpedanceController",
    "LiftController",
    "MotionController",
    "RandomPolicy",
    "Roles",
    "Still",
    "Straight",
    "TrackingController",
    "WalkerController",
    "approach",
    "find_controller",
    "find_guide",
    "released",
    "wrapped",
]

# The first whose task it is; any other task is left to the impedance controller.
CONTROLLERS: dict[type, type[ImpedanceController] | type[WalkerController]] = {
    DoorwayTask: DoorwayController,
    LiftTask: LiftController,
    TrackingTask: TrackingController,
    RollingTask: WalkerController,
}


def find_controller(
    config: TransportConfig, **options: Any
) -> ImpedanceController | WalkerController | MotionController:
    """The scripted controller for the task of ``config``; ``options`` are the controller's own.

    Where hands carry out the actions it is a `MotionController`, which takes ``gains`` alone.

    Raises
    ------
    UnknownName
        If the method of allocation does not exist.
    InvalidInput
        If the controller does not take an option.
    """
    if config.hands is None:
        return find_guide(config, **options)
    if options.keys() - {"gains"}:
        raise InvalidInput(
            f"options must be gains alone for action={config.action!r}, got {sorted(options)}; "
            "drop the others: hands share what is needed as one rigid body would"
        )
    return MotionController(config, find_guide(config, **options))


def find_guide(config: TransportConfig, **options: Any) -> ImpedanceController | WalkerController:
    """`find_controller` for the way that it knows alone, whatever kind the actions are of."""
    kind = next(
        (kind for task, kind in CONTROLLERS.items() if isinstance(config.task, task)),
        ImpedanceController,
    )
    try:
        return kind(config, **options)
    except TypeError as error:
        raise InvalidInput(
            f"options must be among those of {kind.__name__}, got {sorted(options)}; drop the "
            "others"
        ) from error
