"""Scripted teams for the suite of feeling alone, entered as anybody's functions are.

``coopenv benchmark coopenv.agents.benchmark.references:assists --suites haptics``. Agent 0, who is
told the goal, goes straight to its place there; what the other does has a function each.
"""

from collections.abc import Callable

from coopenv.config import TransportConfig

from ..controllers.active import ActiveFollower
from ..controllers.follower import Follower, Still
from ..controllers.impedance import ImpedanceController
from ..controllers.roles import Roles
from ..controllers.straight import Straight
from ..policy import Policy
from .entries import Nobody


def alone(config: TransportConfig) -> Policy:
    """The other does nothing: gives no wrench; its hand, if it has one, stays where it is."""
    if config.hands is None:
        return Roles(config, {0: ImpedanceController(config), 1: Nobody()})
    return _beside(Still)(config)


def gives_way(config: TransportConfig) -> Policy:
    """The other's hand gives way to what it feels; by hands alone."""
    return _beside(Follower)(config)


def assists(config: TransportConfig) -> Policy:
    """The other infers what its partner wants, and takes a share of it; by hands alone."""
    return _beside(ActiveFollower)(config)


def told(config: TransportConfig) -> Policy:
    """The other is told the goal, against the rules of the suite: what could be reached."""
    return ImpedanceController(config) if config.hands is None else Straight(config)


def _beside(follower: Callable[[TransportConfig], Policy]) -> Callable[[TransportConfig], Policy]:
    return lambda config: Roles(config, {0: Straight(config), 1: follower(config)})
