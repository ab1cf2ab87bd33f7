"""Infos of resets and steps: the decomposition, its measures and the reward terms, all flat.

The keys, shapes and dtypes of a reset are those of every step, and every value is a number or an
array of numbers, so that any library can stack them. Nothing in them is NaN.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, with_rows
from coopenv.entries import BODY, COST, REWARD, Info
from coopenv.transition import Transition

CLIPPED = "observation_clipped"
TRIPLES = ("partner_plan", "surroundings_wrench")  # three numbers a world, not one an agent
_OF_LEARNERS = REWARD, f"{COST}/"


_ENTRIES: dict[str, Callable[[Transition], npt.NDArray[Any]]] = {
    "internal_wrench": lambda step: step.of_agents(step.decomposition.internal),
    "manipulation_wrench": lambda step: step.of_agents(step.decomposition.manipulation),
    "force_load_share": lambda step: step.share_or_even.force,
    "force_load_share_defined": lambda step: step.share_or_even.force_defined,
    "torque_load_share": lambda step: step.share_or_even.torque,
    "torque_load_share_defined": lambda step: step.share_or_even.torque_defined,
    "relative_cost": lambda step: step.decomposition.relative_cost,
    "wasted_cost": lambda step: step.decomposition.wasted_cost,
    "internal_force_level": lambda step: step.decomposition.internal_force_level,
    "internal_torque_level": lambda step: step.decomposition.internal_torque_level,
    "energy_share": lambda step: step.power.share,
    "energy_share_defined": lambda step: step.power.defined,
    "internal_power": lambda step: step.power.internal,
    "success": lambda step: step.success,
    "is_success": lambda step: step.success,
    "contact_impulse": lambda step: step.contact_impulse,
    "contact_shift": lambda step: step.contact_shift,
    "surroundings_wrench": lambda step: step.surroundings_wrench,
}
_STORED_ENERGY = "stored_energy"


class _OfStep:
    """What is told of a step, from its transition; see `step_info`."""

    __slots__ = ("_body", "_more", "_parts", "_transition")

    def __init__(
        self, transition: Transition, parts: dict[str, FloatArray], more: Mapping[str, Any]
    ):
        self._transition, self._parts, self._more = transition, parts, more
        self._body: dict[str, FloatArray] | None = None

    def __iter__(self) -> Iterator[str]:
        yield from _ENTRIES
        if self._transition.stored_energy is not None:
            yield _STORED_ENERGY
        for name in self._parts:
            yield REWARD + name
        for name in self._parameters():
            yield BODY + name
        yield from self._more

    def __contains__(self, name: object) -> bool:
        return name in _ENTRIES or any(name == other for other in self)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        read = _ENTRIES.get(name)
        if read is not None:
            return read(self._transition)
        if name == _STORED_ENERGY:
            return getattr(self._transition, name)
        if name.startswith(REWARD):
            return self._parts[name.removeprefix(REWARD)]
        if name.startswith(BODY):
            return self._parameters()[name.removeprefix(BODY)]
        return self._more[name]

    def _parameters(self) -> dict[str, FloatArray]:
        """The numbers drawn, where there are any."""
        if self._body is None:
            conditions = self._transition.conditions
            self._body = conditions.parameters() if conditions.randomised else {}
        return self._body


def step_info(
    transition: Transition, parts: dict[str, FloatArray], more: Mapping[str, Any]
) -> Info:
    """Infos of all worlds after a step.

    Wrenches are in the object frame ``(world, agent, 3)`` [N, N·m]. Levels, γ and wasted cost
    are of the surroundings too, where the decomposition has them; agents share what they apply
    themselves. Shares ``(world, agent)`` are
    1/n where they are undefined, which ``force_load_share_defined`` and
    ``torque_load_share_defined`` ``(world,)`` tell; likewise ``energy_share``, of the power at the
    step's mean twist, and ``energy_share_defined``. The levels F_I [N] and T_I [N·m], γ, the wasted
    cost [N], ``internal_power`` [W], ``success``, which is ``is_success`` too, ``contact_impulse``
    [N·s] and ``contact_shift`` [m] are ``(world,)``, the last two as
    `coopenv.physics.collect.collect` has them. ``surroundings_wrench`` ``(world, 3)`` is the mean
    of what contacts and wheels gave, at the centre of mass. With hands, ``stored_energy``
    ``(world, agent)`` [J] is what their springs hold.
    ``reward/<term>`` is ``(world, agent)``. Where body and team are drawn anew in every episode,
    ``body/<number>`` are the numbers drawn (`coopenv.conditions.Conditions.parameters`).
    """
    return Info.of(_OfStep(transition, parts, more))


def start_info(
    start: Transition,
    reward_names: Iterable[str],
    num_learners: int,
    cost_names: Iterable[str] | None = None,
) -> Info:
    """Infos at the start of an episode: as after a step in which nothing was applied or earned."""
    nothing = np.zeros((len(start.applied), num_learners))
    costs = {} if cost_names is None else cost_info(nothing, {name: nothing for name in cost_names})
    return step_info(start, {name: nothing.copy() for name in reward_names}, costs)


def cost_info(total: FloatArray, parts: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """What a sum of terms takes, ``(world, learner)``, as ``cost`` and by term ``cost/<term>``."""
    told = {COST: 0.0 - total}
    told.update({f"{COST}/{name}": 0.0 - part for name, part in parts.items()})
    return told


@lru_cache
def is_of_learners(name: str) -> bool:
    """Whether a value has a row for each agent that learns, rather than for each agent."""
    return name.startswith(_OF_LEARNERS) or name == COST


def with_worlds(info: Info, worlds: IntArray, other: Info) -> Info:
    """A copy of ``info`` with ``worlds`` replaced by those of ``other``, in order."""
    return Info({name: with_rows(value, worlds, other[name]) for name, value in info.items()})


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
