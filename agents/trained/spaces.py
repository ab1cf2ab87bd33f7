"""Spaces of a learned policy against the environment that it is to act in."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray
from coopenv.errors import InvalidInput
from coopenv.observation import Observation
from coopenv.pushes import MOST_PUSHES
from coopenv.transport import Transport

_DTYPES = ("float32", "float64")
_MOST_AGENTS = 1000  # of a plate


class NotPlain(ValueError):
    """A value that no plain one stands for; the message is what it is."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spaces:
    """What a policy takes and gives in a row, which is of the team or of one agent."""

    features: int
    actions: int  # numbers in [−1, 1], or numbers of pushes
    bounded: BoolArray  # (feature,): which features have a bound
    action_space: gymnasium.Space
    pushes: int | None  # how many an agent chooses from; None: its actions are a box

    def check_sizes(self, num_agents: int, size: int, width: int) -> int:
        """How many agents share a row, if each sees ``size`` features and gives ``width`` numbers.

        Raises
        ------
        InvalidInput
            If the policy was trained on other sizes, or actions of another range.
        """
        return self.agents_in_row((num_agents,), size, width)

    def agents_in_row(self, counts: Sequence[int], size: int, width: int) -> int:
        """As `check_sizes`, for teams of the first of ``counts`` that it fits, or one agent."""
        box: Any = self.action_space
        if self.pushes is None and ((box.low != -1).any() or (box.high != 1).any()):
            raise InvalidInput(
                f"actions of a policy must be in [-1, 1], got {box}; it was trained in another "
                "kind of environment"
            )
        given = width if self.pushes is None else 1
        for agents in (*counts, 1):
            if (self.features, self.actions) == (agents * size, agents * given):
                return agents
        raise InvalidInput(
            f"obs and action must have the sizes the policy was trained on, {self.features} "
            f"features in and {self.actions} numbers out, for the team or each agent, got "
            f"{counts[0]} agents with {size} and {given} each; evaluate it with the observe=, "
            "also_observe=, action= and number of agents of its training"
        )

    def rows(self, obs: npt.NDArray, width: int) -> npt.NDArray:
        """``(row, feature)`` of observations ``(world, learner, feature)``, each giving ``width``.

        Raises
        ------
        InvalidInput
            If the policy was trained on other sizes, or actions of another range.
        """
        self.check_sizes(obs.shape[1], obs.shape[2], width)
        return obs.reshape(-1, self.features)

    def by_agent(self, action: npt.NDArray, obs: npt.NDArray, width: int) -> npt.NDArray:
        """``(world, learner, width)``, or pushes ``(world, learner)``, of ``action`` a row."""
        if self.pushes is not None:
            return action.reshape(obs.shape[:2]).astype(np.int64)
        return action.reshape(*obs.shape[:2], width).astype(np.float64)

    def check_environment(self, core: Transport) -> int:
        """How many agents share a row, if nothing shows that ``core`` is another environment.

        Blocks of the same size show by which of their features are bounded, if they do at all. A
        policy whose observation space has no bound says nothing.

        Raises
        ------
        InvalidInput
            If sizes or the bounds of what is seen show one, or it chooses from other pushes.
        """
        there = None if core.table is None else len(core.table)
        if self.pushes != there:
            raise InvalidInput(
                f"action must be what the policy was trained with, {said(self.pushes)}, got "
                f"{said(there)}; evaluate it with the action= and pushes= of its training"
            )
        agents = self.check_sizes(len(core.learners), core.observation.size, core.action_size)
        self.check_bounds(core.observation, agents)
        return agents

    def check_bounds(self, seen: Observation, agents: int) -> None:
        """Raise `InvalidInput` if bounds of ``seen``, for ``agents`` a row, show other blocks."""
        bounded = np.tile(np.isfinite(seen.low) | np.isfinite(seen.high), agents)
        if self.bounded.any() and (self.bounded != bounded).any():
            feature = int(np.flatnonzero(self.bounded != bounded)[0]) % seen.size
            (block,) = (name for name, at in seen.blocks.items() if feature in _numbers(at))
            raise InvalidInput(
                f"obs must be made of the blocks that the policy was trained on, got {block!r} "
                f"where it knew another (feature {feature} of an agent); evaluate it with the "
                "observe= of its training"
            )


def spaces_of(seen: gymnasium.Space, done: Any, algorithm: str) -> Spaces:
    """The spaces of what ``algorithm`` trained; raises `InvalidInput` unless they are of one row.

    Parameters
    ----------
    seen, done
        Of observations and of actions.
    """
    box = gymnasium.spaces.Box
    if not isinstance(seen, box) or len(seen.shape) != 1:
        raise InvalidInput(
            f"observation space of a policy must be a Box of one row, got {seen}; it was trained "
            "in another kind of environment"
        )
    if _is_of_pushes(done):
        pushes, actions = int(done.nvec[0]), done.nvec.size
    elif isinstance(done, box) and len(done.shape) == 1:
        pushes, actions = None, done.shape[0]
    elif type(done) is gymnasium.spaces.Discrete and done.start == 0:
        pushes, actions = int(done.n), 1
    else:
        raise InvalidInput(
            f"action space of a policy must be a Box of one row, or of numbers of pushes, got "
            f"{done} of {algorithm}; it was trained in another kind of environment"
        )
    return Spaces(
        features=seen.shape[0],
        actions=actions,
        bounded=np.isfinite(seen.low) | np.isfinite(seen.high),
        action_space=done,
        pushes=pushes,
    )


def _is_of_pushes(space: Any) -> bool:
    """Whether it is a row of numbers of pushes, for all agents of the same."""
    if type(space) is not gymnasium.spaces.MultiDiscrete or space.nvec.ndim != 1:
        return False
    return bool((space.nvec == space.nvec[0]).all() and not np.any(space.start))


def said(pushes: int | None) -> str:
    """The actions of an agent, in words."""
    return "numbers in [-1, 1]" if pushes is None else f"numbers of {pushes} pushes"


def plain_space(space: gymnasium.Space) -> dict[str, Any]:
    """A box of one row, or numbers of pushes, as JSON has it; raises `NotPlain` for another."""
    if type(space) is gymnasium.spaces.Discrete and space.start == 0:
        return {"pushes": int(space.n)}
    if _is_of_pushes(space):
        nvec: Any = space.nvec  # pyright: ignore[reportAttributeAccessIssue]
        return {"pushes": int(nvec[0]), "agents": int(nvec.size)}
    if not isinstance(space, gymnasium.spaces.Box) or len(space.shape) != 1:
        raise NotPlain(f"the space {space!r:.60}")
    if str(space.dtype) not in _DTYPES:
        raise NotPlain(f"a space of {space.dtype}")
    bounds = {name: [str(each) for each in getattr(space, name)] for name in ("low", "high")}
    return {**bounds, "dtype": str(space.dtype)}


def space_of(given: Any) -> gymnasium.Space:
    """What `plain_space` wrote; raises `ValueError`, or of another kind, for anything else."""
    if "pushes" in given:
        pushes = _count(given["pushes"], MOST_PUSHES)
        if set(given) == {"pushes"}:
            return gymnasium.spaces.Discrete(pushes)
        return gymnasium.spaces.MultiDiscrete([pushes] * _count(given["agents"], _MOST_AGENTS))
    if given["dtype"] not in _DTYPES:
        raise ValueError(f"a space of {given['dtype']!r:.40}")
    dtype: Any = np.dtype(given["dtype"]).type
    low, high = (np.array([float(each) for each in given[name]], dtype) for name in ("low", "high"))
    if np.isnan(low).any() or np.isnan(high).any() or (low > high).any():
        raise ValueError("a space without room")
    return gymnasium.spaces.Box(low, high, dtype=dtype)


def _count(value: Any, most: int) -> int:
    if type(value) is not int or not 1 <= value <= most:
        raise ValueError(f"a space of {value!r:.40}")
    return value


def _numbers(at: slice) -> range:
    return range(*at.indices(at.stop))
