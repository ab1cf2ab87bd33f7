"""Kinds: the classes and functions of this package that JSON may name, by their public names."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import is_dataclass
from typing import Any, TypeAlias

from coopenv import rewards
from coopenv.errors import UnknownName
from coopenv.observation import Block, EachOther, RangeReading, Sensor, ranges
from coopenv.physics.actuators import Actuators
from coopenv.physics.body import Body
from coopenv.physics.hands import Hands
from coopenv.physics.scene import Box, Scene
from coopenv.randomisation import Ranges
from coopenv.tasks import TASKS, Reference
from coopenv.wrench import Settings

Maker: TypeAlias = Callable[..., Any]  # of a value, from keywords

SUM = "coopenv.rewards.RewardSum"  # its terms are no fields


def dataclasses_of(face: str, names: Iterable[str], scope: Mapping[str, Any]) -> dict[str, Maker]:
    """The dataclasses among the ``names`` of a package's face, by their public names."""
    return {
        f"{face}.{name}": scope[name]
        for name in names
        if isinstance(scope[name], type) and is_dataclass(scope[name])
    }


_kinds: dict[str, Maker] = {
    **{
        f"coopenv.{kind.__name__}": kind
        for kind in (*TASKS, Actuators, Body, Box, Hands, Scene, Ranges, Reference)
    },
    "coopenv.Block": Block,
    "coopenv.Sensor": Sensor,
    "coopenv.observation.EachOther": EachOther,
    "coopenv.observation.RangeReading": RangeReading,
    "coopenv.observation.ranges": ranges,
    "coopenv.wrench.Settings": Settings,
    **dataclasses_of("coopenv.rewards", rewards.__all__, vars(rewards)),
}
FUNCTIONS: dict[str, Callable[..., Any]] = {"coopenv.rewards.closeness": rewards.closeness}

_later: dict[str, Callable[[], Mapping[str, Maker]]] = {}


def add_kinds(package: str, load: Callable[[], Mapping[str, Maker]]) -> None:
    """Register kinds of a ``package`` above the core, which cannot import it.

    ``load`` is called when a name, or an object, from there is first met.
    """
    _later[package] = load


def kinds_at(place: str) -> Mapping[str, Maker]:
    """Name → kind, those of the package that holds ``place`` included."""
    for package, load in list(_later.items()):
        if place.startswith(f"{package}."):
            _kinds.update(load())
            del _later[package]
    return _kinds


def find_kind(name: str, what: str) -> Maker:
    """The kind of that public name; ``what`` is for the error.

    Raises
    ------
    UnknownName
        If there is none.
    """
    known = kinds_at(name)
    if name not in known:
        raise UnknownName(what, name, [*known, SUM])
    return known[name]


def kind_name(kind: Maker) -> str | None:
    """The public name of one of our kinds; ``None`` for a class that is none."""
    known = kinds_at(kind.__module__)
    return next((name for name, maker in known.items() if maker is kind), None)
