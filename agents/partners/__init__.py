"""Scripted partners: ``partner="follower"`` in any view, or an object for other numbers."""

from coopenv.config import TransportConfig
from coopenv.errors import UnknownName
from coopenv.tasks import RollingTask

from .combined import Lagging, Noisy, Population, Switching
from .kinds import Follower, Impedance, Leader, LoadSharing, Stubborn
from .person import Kind, Person
from .walking import Robot, Walking

__all__ = [
    "DEFAULT",
    "DEFAULTS",
    "PARTNERS",
    "Follower",
    "Impedance",
    "Kind",
    "Lagging",
    "Leader",
    "LoadSharing",
    "Noisy",
    "Person",
    "Population",
    "Robot",
    "Stubborn",
    "Switching",
    "Walking",
    "default_partner",
    "find_partner",
]

PARTNERS: dict[str, Kind] = {
    "impedance": Impedance(),
    "leader": Leader(),
    "follower": Follower(),
    "lagging": Lagging(),
    "noisy": Noisy(),
    "stubborn": Stubborn(),
    "load_sharing": LoadSharing(),
    "switching": Switching(),
    "population": Population(),
    "walking": Walking(),
    "robot": Robot(),
}
DEFAULT = "impedance"  # agrees about the goal and does its part
DEFAULTS: dict[type, str] = {RollingTask: "walking"}  # of tasks for which that is too little


def default_partner(config: TransportConfig) -> str:
    """Name of the partner that an environment gets where one is needed and none is named.

    `DEFAULT`, but "walking" for bodies on wheels, which have to be led along a way.
    """
    return next((name for task, name in DEFAULTS.items() if isinstance(config.task, task)), DEFAULT)


def find_partner(name: str) -> Kind:
    """The partner of that name.

    Raises
    ------
    UnknownName
        If there is none.
    """
    if name not in PARTNERS:
        raise UnknownName("partner", name, PARTNERS)
    return PARTNERS[name]
