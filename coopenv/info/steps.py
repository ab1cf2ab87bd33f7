"""Infos of resets and steps: the decomposition, its measures and the reward terms, all flat.

The keys, shapes and dtypes of a reset are those of every step, and every value is a number or an
array of numbers, so that any library can stack them. Nothing in them is NaN.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray, with_rows
from coopenv.info.entries import BODY, COST, REWARD, Info
from coopenv.transition import Transition

CLIPPED = "observation_clipped"

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
        if name in _ENTRIES:
            return True
        if not isinstance(name, str):
            return False
        if name == _STORED_ENERGY:
            return self._transition.stored_energy is not None
        if name.startswith(REWARD):
            return name.removeprefix(REWARD) in self._parts
        if name.startswith(BODY):
            return name.removeprefix(BODY) in self._parameters()
        return name in self._more

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


def with_worlds(info: Info, worlds: IntArray, other: Info) -> Info:
    """A copy of ``info`` with ``worlds`` replaced by those of ``other``, in order."""
    return Info({name: with_rows(value, worlds, other[name]) for name, value in info.items()})
