"""Infos of resets and steps: the decomposition, its measures and the reward terms, all flat.

The keys, shapes and dtypes of a reset are those of every step, and every value is a number or an
array of numbers, so that any library can stack them. Nothing in them is NaN.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, IntArray, with_rows
from coopenv.pytrees import register_dictionary
from coopenv.transition import Transition

REWARD, BODY, COST = "reward/", "body/", "cost"  # what keys of a group begin with
CLIPPED = "observation_clipped"
GROUPS = {  # what indexing gives as a dictionary of its own
    "reward_terms": REWARD,
    "body": BODY,
    "cost_terms": f"{COST}/",
}
TRIPLES = ("partner_plan", "surroundings_wrench")  # three numbers a world, not one an agent
_OF_LEARNERS = REWARD, f"{COST}/"


class Info(dict[str, Any]):
    """What an environment tells beside the observation: names and numbers.

    ``info["reward_terms"]`` is the dictionary of all ``info["reward/<term>"]``, and
    ``info["body"]``, where bodies are randomised, that of all ``info["body/<number>"]``; where
    there is a cost, ``info["cost_terms"]`` is that of all ``info["cost/<term>"]``. They are made
    when they are asked for: they are no entries, and nothing that goes through the entries meets
    them.

    >>> info = Info({"success": False, "reward/progress": 0.25})
    >>> info["reward_terms"]
    {'progress': 0.25}
    >>> list(info)
    ['success', 'reward/progress']
    """

    def __missing__(self, name: str) -> dict[str, Any]:
        start = GROUPS.get(name)
        group = {} if start is None else self._group(start)
        if start is None or (not group and name != "reward_terms"):
            raise KeyError(name)
        return group

    def _group(self, start: str) -> dict[str, Any]:
        return {name[len(start) :]: self[name] for name in self if name.startswith(start)}

    def copy(self) -> "Info":
        """A copy that knows its groups too."""
        return type(self)(self)


register_dictionary(Info)


def step_info(transition: Transition, parts: dict[str, FloatArray]) -> Info:
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
    decomposition, of_agents = transition.decomposition, transition.of_agents
    share, power = transition.share_or_even, transition.power
    info = Info(
        internal_wrench=of_agents(decomposition.internal),
        manipulation_wrench=of_agents(decomposition.manipulation),
        force_load_share=share.force,
        force_load_share_defined=share.force_defined,
        torque_load_share=share.torque,
        torque_load_share_defined=share.torque_defined,
        relative_cost=decomposition.relative_cost,
        wasted_cost=decomposition.wasted_cost,
        internal_force_level=decomposition.internal_force_level,
        internal_torque_level=decomposition.internal_torque_level,
        energy_share=power.share,
        energy_share_defined=power.defined,
        internal_power=power.internal,
        success=transition.success,
        is_success=transition.success,
        contact_impulse=transition.contact_impulse,
        contact_shift=transition.contact_shift,
        surroundings_wrench=transition.surroundings_wrench,
    )
    if transition.stored_energy is not None:
        info["stored_energy"] = transition.stored_energy
    for name, part in parts.items():
        info[REWARD + name] = part
    if transition.conditions.randomised:
        for name, number in transition.conditions.parameters().items():
            info[BODY + name] = number
    return info


def start_info(
    start: Transition,
    reward_names: Iterable[str],
    num_learners: int,
    cost_names: Iterable[str] | None = None,
) -> Info:
    """Infos at the start of an episode: as after a step in which nothing was applied or earned."""
    nothing = np.zeros((len(start.applied), num_learners))
    info = step_info(start, {name: nothing.copy() for name in reward_names})
    if cost_names is not None:
        info.update(cost_info(nothing, {name: nothing for name in cost_names}))
    return info


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


def of_team(info: Info) -> Info:
    """What a team of one world is told: single numbers as Python's own, reward and cost averaged.

    ``info`` is of one world; arrays lose their first axis.
    """
    told = Info()
    for name, value in info.items():
        if value.ndim == 1:
            told[name] = value.item()
        else:
            told[name] = mean(value) if is_of_learners(name) else value[0].copy()
    return told


def of_agents(info: Info, agents: Sequence[int]) -> list[Info]:
    """What each of these ``agents``, the learners of one world, is told: its own row.

    Reward and cost have a row for each of ``agents``, other arrays one for each of all. What is
    true of the world is told to all.
    """
    of_world = {name: value.item() if value.ndim == 1 else value for name, value in info.items()}
    told = []
    for number, agent in enumerate(agents):
        own = Info(of_world)
        for name, value in info.items():
            if value.ndim == 1:
                continue
            row = number if is_of_learners(name) else agent
            if name in TRIPLES:
                own[name] = value[0].copy()
            else:
                own[name] = value.item(row) if value.ndim == 2 else value[0, row].copy()
        told.append(own)
    return told


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
