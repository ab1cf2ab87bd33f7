"""PettingZoo's view for RLlib: features of order one, and world seeds of the training alone."""

from dataclasses import fields
from typing import Any

import gymnasium
import numpy as np
from ray.rllib.env.wrappers.pettingzoo_env import (  # pyright: ignore[reportMissingImports]
    ParallelPettingZooEnv,
)

from coopenv.config import TransportConfig
from coopenv.envs.parallel import TransportParallelEnv

from ..features import scale_of_features
from ..seeds import training_seeds

NAME = "coopenv"


def view_of(config: TransportConfig) -> TransportParallelEnv:
    """PettingZoo's view of an environment."""
    given = {entry.name: getattr(config, entry.name) for entry in fields(config)}
    return TransportParallelEnv(name=NAME, **given)


class CarryingEnv(ParallelPettingZooEnv):
    """A team of which every agent sees, acts and is rewarded by itself.

    RLlib makes one for every world of every runner, on whatever node that is; each has a world seed
    of its own (`coopenv.agents.seeds`), whatever seed RLlib gives it.

    Parameters
    ----------
    context
        RLlib's; with ``environment`` (`TransportConfig.to_json`), ``seed`` and ``worlds``, the
        number of environments of a runner.
    """

    def __init__(self, context: Any):
        config = TransportConfig.from_json(context["environment"])
        super().__init__(view_of(config))
        self._scale = np.array(scale_of_features(self.par_env.transport), dtype=np.float32)
        worlds = context["worlds"]
        number = context.worker_index * worlds + context.vector_index
        self._seed: int | None = training_seeds(context["seed"], number + 1)[-1]
        spaces: Any = {
            agent: self._scaled(space) for agent, space in self.observation_space.items()
        }
        self.observation_space = gymnasium.spaces.Dict(spaces)

    def reset(self, *, seed: int | None = None, options: dict | None = None) -> tuple[Any, Any]:
        """Begin an episode: the first of its world seed, then those that follow it."""
        obs, info = super().reset(seed=self._seed, options=options)
        self._seed = None
        return self._seen(obs), info

    def step(self, action_dict: dict[str, Any]) -> tuple[Any, ...]:
        """As PettingZoo's, with scaled observations."""
        obs, *rest = super().step(action_dict)
        return self._seen(obs), *rest

    def _seen(self, obs: dict[str, Any]) -> dict[str, Any]:
        return {agent: seen * self._scale for agent, seen in obs.items()}

    def _scaled(self, space: Any) -> gymnasium.spaces.Box:
        low, high = space.low * self._scale, space.high * self._scale
        return gymnasium.spaces.Box(low, high, dtype=np.float32)
