"""Scripted partners: ``partner="follower"`` in any view, or an object for other numbers."""

from coopenv.errors import UnknownName

from .combined import Lagging, Noisy, Population, Switching
from .kinds import Follower, Impedance, Leader, LoadSharing, Stubborn
from .person import Kind, Person

__all__ = [
    "DEFAULT",
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
    "Stubborn",
    "Switching",
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
}
DEFAULT = "impedance"  # agrees about the goal and does its part


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
