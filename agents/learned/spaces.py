"""Spaces of a learned policy against the environment that it is to act in."""

from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.arrays import BoolArray
from coopenv.errors import InvalidInput
from coopenv.transport import Transport

from .plain import NotPlain

_DTYPES = ("float32", "float64")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spaces:
    """What a policy takes and gives in a row, which is of the team or of one agent."""

    features: int
    actions: int
    bounded: BoolArray  # (feature,): which features have a bound
    action_space: gymnasium.spaces.Box

    def check_sizes(self, num_agents: int, size: int, width: int) -> int:
        """How many agents share a row, if each sees ``size`` features and gives ``width`` numbers.

        Raises
        ------
        InvalidInput
            If the policy was trained on other sizes, or actions of another range.
        """
        box = self.action_space
        if (box.low != -1).any() or (box.high != 1).any():
            raise InvalidInput(
                f"actions of a policy must be in [-1, 1], got {box}; it was trained in another "
                "kind of environment"
            )
        for agents in (num_agents, 1):
            if (self.features, self.actions) == (agents * size, agents * width):
                return agents
        raise InvalidInput(
            f"obs and action must have the sizes the policy was trained on, {self.features} "
            f"features in and {self.actions} numbers out, for the team or each agent, got "
            f"{num_agents} agents with {size} and {width} each; evaluate it with the observe=, "
            "action= and number of agents of its training"
        )

    def check_environment(self, core: Transport) -> int:
        """How many agents share a row, if nothing shows that ``core`` is another environment.

        Blocks of the same size show by which of their features are bounded, if they do at all. A
        policy whose observation space has no bound says nothing.

        Raises
        ------
        InvalidInput
            If sizes or the bounds of what is seen show one.
        """
        seen = core.observation
        agents = self.check_sizes(len(core.learners), seen.size, core.action_size)
        bounded = np.tile(np.isfinite(seen.low) | np.isfinite(seen.high), agents)
        if self.bounded.any() and (self.bounded != bounded).any():
            feature = int(np.flatnonzero(self.bounded != bounded)[0]) % seen.size
            (block,) = (name for name, at in seen.blocks.items() if feature in _numbers(at))
            raise InvalidInput(
                f"obs must be made of the blocks that the policy was trained on, got {block!r} "
                f"where it knew another (feature {feature} of an agent); evaluate it with the "
                "observe= of its training"
            )
        return agents


def spaces_of(model: BaseAlgorithm) -> Spaces:
    """The spaces of a model; raises `InvalidInput` unless both are boxes of one row."""
    seen, done = model.observation_space, model.action_space
    box = gymnasium.spaces.Box
    if not isinstance(seen, box) or len(seen.shape) != 1:
        raise InvalidInput(
            f"observation space of a policy must be a Box of one row, got {seen}; it was trained "
            "in another kind of environment"
        )
    if not isinstance(done, box) or len(done.shape) != 1:
        raise InvalidInput(
            f"action space of a policy must be a Box of one row, got {done} of "
            f"{type(model).__name__}; choose an algorithm with continuous actions, PPO or SAC "
            "for example"
        )
    return Spaces(
        features=seen.shape[0],
        actions=done.shape[0],
        bounded=np.isfinite(seen.low) | np.isfinite(seen.high),
        action_space=done,
    )


def plain_box(space: gymnasium.Space) -> dict[str, Any]:
    """A box of one row as JSON has it; raises `NotPlain` for another space."""
    if not isinstance(space, gymnasium.spaces.Box) or len(space.shape) != 1:
        raise NotPlain(f"the space {space!r:.60}")
    if str(space.dtype) not in _DTYPES:
        raise NotPlain(f"a space of {space.dtype}")
    bounds = {name: [str(each) for each in getattr(space, name)] for name in ("low", "high")}
    return {**bounds, "dtype": str(space.dtype)}


def box_of(given: Any) -> gymnasium.spaces.Box:
    """What `plain_box` wrote; raises `ValueError`, or of another kind, for anything else."""
    if given["dtype"] not in _DTYPES:
        raise ValueError(f"a space of {given['dtype']!r:.40}")
    dtype: Any = np.dtype(given["dtype"]).type
    low, high = (np.array([float(each) for each in given[name]], dtype) for name in ("low", "high"))
    if np.isnan(low).any() or np.isnan(high).any() or (low > high).any():
        raise ValueError("a space without room")
    return gymnasium.spaces.Box(low, high, dtype=dtype)


def _numbers(at: slice) -> range:
    return range(*at.indices(at.stop))
