"""MAPPO: PPO of agents that share a policy, with a critic that sees what all of them see.

It is trained by what `examples/train_torchrl.py` shows, from TorchRL's own parts.
"""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from tensordict import TensorDict, TensorDictBase
from torchrl.modules import ProbabilisticActor

from benchmarks.learning.algorithms.curve import Curve
from benchmarks.learning.algorithms.environment import environment_of
from coopenv.agents import torchrl
from coopenv.agents.noise import Keyed, normals
from coopenv.agents.policy import Policy
from coopenv.agents.seeds import training_seeds
from coopenv.envs.registry import PREFIX
from coopenv.transition import Transition
from examples.train_torchrl import Config, train

SETTINGS = {"num_worlds": 256, "rollout": 32, "epochs": 5, "minibatch": 512}  # by the search
OF: Mapping[str, Mapping[str, int]] = {
    "BeamTransport": {"total_steps": 300_000},
    "BeamTracking": {"total_steps": 300_000},
    "WalkerTurn": {"total_steps": 1_000_000},
    "BeamDoorway": {"total_steps": 1_800_000},
    "WalkerAvoid": {"total_steps": 1_200_000},
    "BeamLift": {"total_steps": 600_000, "minibatch": 2048},
}
BY_HANDS: Mapping[str, Mapping[str, int]] = {"WalkerAvoid": {"total_steps": 2_400_000}}


def settings(env: str, action: str | None = None) -> dict[str, Any]:
    """Those with which it is trained: of the example's `Config`."""
    by_hands = BY_HANDS.get(env, {}) if action else {}
    config = Config(env=f"{PREFIX}{env}-v0", **{**SETTINGS, **OF[env], **by_hands})
    apart = ("seed", "episodes")
    return {name: value for name, value in asdict(config).items() if name not in apart}


def learn(
    env: str, seed: int, given: dict[str, Any], action: str | None = None
) -> tuple["Actors", Curve]:
    """Train with such settings."""
    config = replace(Config(**given), seed=seed)
    environment = environment_of(env, action)
    curve = Curve(environment.horizon, config.num_worlds)
    first = training_seeds(seed, config.num_worlds)[0]
    worlds = torchrl.make_env(environment, config.num_worlds, seed=first, info=("success",))

    def watch(batch: TensorDictBase) -> None:
        over = batch["next", "done"][..., 0].T  # (step, world)
        success = batch["next", "agents", "info", "success"][:, :, 0, 0].bool().T
        for ended, succeeded in zip(over, success, strict=True):
            curve.add(succeeded[ended].tolist())

    return Actors(train(worlds, config, watch)), curve


class Actors(Keyed):
    """A policy of TorchRL that every agent runs on what it sees itself.

    Parameters
    ----------
    actor
        As `examples.train_torchrl.make_policy` makes it.
    deterministic
        Take the mean action instead of a sample.
    """

    def __init__(self, actor: ProbabilisticActor, *, deterministic: bool = True):
        super().__init__()
        self._actor, self._deterministic = actor, deterministic

    def sampled(self) -> Policy:
        """The same policy with sampled actions."""
        return Actors(self._actor, deterministic=False)

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``."""
        self._keys.follow(transition)
        seen = TensorDict({("agents", "observation"): torch.from_numpy(obs)}, obs.shape[:1])
        with torch.no_grad():
            told = self._actor[0](seen)["agents"]
        mean = told["loc"].numpy()
        if self._deterministic:
            return mean
        noise = normals(self._keys.of_step(transition), int(np.prod(mean.shape[1:])))
        return mean + told["scale"].numpy() * noise.reshape(mean.shape)
