"""Infos as views hand them out: copies, of a team, of each agent, of Gymnasium's vector."""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.info.entries import COST, REWARD, Info

TRIPLES = ("partner_plan", "surroundings_wrench")  # three numbers a world, not one an agent
_OF_LEARNERS = REWARD, f"{COST}/"


@lru_cache
def is_of_learners(name: str) -> bool:
    """Whether a value has a row for each agent that learns, rather than for each agent."""
    return name.startswith(_OF_LEARNERS) or name == COST


def copied(info: Info) -> Info:
    """A copy down to the arrays, so that what its owner does to it changes nothing here."""
    return Info({name: value.copy() for name, value in info.items()})


class _Seen:
    """Entries of another info, in another form."""

    __slots__ = ("_info",)

    def __init__(self, info: Info):
        self._info = info

    def __iter__(self) -> Iterator[str]:
        return self._info.names()

    def __contains__(self, name: object) -> bool:
        return name in self._info

    def __getitem__(self, name: str) -> Any:
        return self._info[name].copy()


class _OfTeam(_Seen):
    __slots__ = ()

    def __getitem__(self, name: str) -> Any:
        value = self._info[name]
        if value.ndim == 1:
            return value.item()
        return mean(value) if is_of_learners(name) else value[0].copy()


class _OfAgent(_Seen):
    __slots__ = ("_agent", "_row")

    def __init__(self, info: Info, agent: int, row: int):
        self._info, self._agent, self._row = info, agent, row

    def __getitem__(self, name: str) -> Any:
        value = self._info[name]
        if value.ndim == 1:
            return value.item()
        if name in TRIPLES:
            return value[0].copy()
        row = self._row if is_of_learners(name) else self._agent
        return value.item(row) if value.ndim == 2 else value[0, row].copy()


class _OfVector(_Seen):
    __slots__ = ("_present",)

    def __init__(self, info: Info, present: BoolArray):
        self._info, self._present = info, present

    def __iter__(self) -> Iterator[str]:
        for name in self._info.names():
            yield name
            yield f"_{name}"

    def __contains__(self, name: object) -> bool:
        return name in self._info or (isinstance(name, str) and self._masks(name))

    def __getitem__(self, name: str) -> Any:
        if self._masks(name):
            return self._present.copy()
        value = self._info[name]
        return means(value) if is_of_learners(name) else value

    def _masks(self, name: str) -> bool:
        return name.startswith("_") and name[1:] in self._info


def copied_when_read(info: Info) -> Info:
    """`copied`, each entry when it is asked for; for an ``info`` whose arrays nobody changes."""
    return Info.of(_Seen(info))


def of_team(info: Info) -> Info:
    """What a team of one world is told: single numbers as Python's own, reward and cost averaged.

    ``info`` is of one world, and nobody changes its arrays; arrays lose their first axis.
    """
    return Info.of(_OfTeam(info))


def of_agents(info: Info, agents: Sequence[int]) -> list[Info]:
    """What each of these ``agents``, the learners of one world, is told: its own row.

    Reward and cost have a row for each of ``agents``, other arrays one for each of all. What is
    true of the world is told to all. Nobody changes the arrays of ``info``.
    """
    return [Info.of(_OfAgent(info, agent, row)) for row, agent in enumerate(agents)]


def of_vector(info: Info, present: BoolArray) -> Info:
    """Reward and cost averaged over the team, and Gymnasium's ``_key`` mask beside each key.

    ``present`` ``(world,)`` marks the worlds that the info is of.
    """
    return Info.of(_OfVector(info, present))


def means(values: FloatArray) -> FloatArray:
    """Mean of the team's numbers in each world ``(world,)``, of ``(world, learner)``.

    To the bits of NumPy's own, which takes twice as long to call.
    """
    return np.add.reduce(values, axis=1) / values.shape[1]


def mean(values: FloatArray) -> float:
    """Mean of the team's numbers in one world ``(1, learner)``.

    NumPy's own takes longer to call than to add them.
    """
    (team,) = values.tolist()
    return sum(team) / len(team)
