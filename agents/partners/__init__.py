"""Partners: ``partner="follower"`` in any view, a trained policy's file, or an object.

Scripted ones have a name, and other numbers as an object; a policy is a partner as it is.
"""

import os
from typing import Any

from coopenv.config import TransportConfig
from coopenv.errors import UnknownName
from coopenv.partner import Partner
from coopenv.tasks import RollingTask

from .combined import Lagging, Noisy, Population, Switching
from .haptic import Compliant, Guiding
from .kinds import Follower, Impedance, Leader, LoadSharing, Stubborn
from .learned import LearnedPartner, PolicyPartner, is_file_name, trusting
from .person import Kind, Person
from .walking import Robot, Walking

__all__ = [
    "DEFAULT",
    "DEFAULTS",
    "PARTNERS",
    "Compliant",
    "Follower",
    "Guiding",
    "Impedance",
    "Kind",
    "Lagging",
    "Leader",
    "LearnedPartner",
    "LoadSharing",
    "Noisy",
    "Person",
    "PolicyPartner",
    "Population",
    "Robot",
    "Stubborn",
    "Switching",
    "Walking",
    "default_partner",
    "find_partner",
    "partner_of",
    "trusting",
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
    "compliant": Compliant(),
    "guiding": Guiding(),
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


def partner_of(value: Any) -> Partner:
    """The partner for which a name, a policy's file or a policy stands.

    A name is one of `PARTNERS`; text with a folder or ``.zip`` is a file, and so is a path.

    Raises
    ------
    UnknownName, InvalidInput
        If it is no such name, file or policy.
    """
    if is_file_name(value) and value not in PARTNERS:
        return LearnedPartner(path=os.fspath(value))
    return find_partner(value) if isinstance(value, str) else PolicyPartner(policy=value)
