"""RLlib: PPO of each agent on PettingZoo's view, and of the team on Gymnasium's vector view."""

# pyright: reportMissingImports=false

import json
import logging
import math
import os
from typing import Any

os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")

import gymnasium
import numpy as np
import ray
import torch
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

import coopenv

IDS = {
    "coopenv/BeamTransport-v0": coopenv.beam_transport_v0,
    "coopenv/WalkerAvoid-v0": coopenv.walker_avoid_v0,
}
HORIZON = 40  # control steps
WORLDS = 8  # of the vector view
STEPS = 400  # control steps in an iteration
ITERATIONS = 2


def main() -> None:
    """Run all of it, and print one line of JSON."""
    ray.init(num_cpus=1, include_dashboard=False, log_to_driver=False, logging_level=logging.ERROR)
    for view in IDS:
        every_agent(view)
        whole_team(view)
    ray.shutdown()
    checked = (
        "PPO of the new API stack changes its weights and reports returns of whole episodes: one "
        "policy for all agents over ParallelPettingZooEnv, and one for the team over our vector "
        f"view of {WORLDS} worlds"
    )
    told = {"library": "RLlib", "version": ray.__version__, "ids": list(IDS), "checked": checked}
    print(json.dumps(told))


def settings() -> PPOConfig:
    """A small PPO that runs in this process."""
    return (
        PPOConfig()
        .learners(num_learners=0)
        .training(train_batch_size_per_learner=STEPS, minibatch_size=100, num_epochs=2, lr=1e-3)
        .rl_module(model_config=DefaultModelConfig(fcnet_hiddens=[32]))
        .debugging(seed=0, log_level="ERROR")
    )


def every_agent(view: str) -> None:
    """Each agent acts on what it sees itself; both have the same policy."""
    name = f"every agent of {view}"
    register_env(name, lambda _: ParallelPettingZooEnv(IDS[view].parallel_env(horizon=HORIZON)))
    config = (
        settings()
        .environment(name)
        .env_runners(num_env_runners=0)
        .multi_agent(policies={"shared"}, policy_mapping_fn=lambda *_, **__: "shared")
    )
    learn(config, "shared")


def whole_team(view: str) -> None:
    """The team acts as one, in all worlds of one core."""
    name = f"team of {view}"

    def make(context: Any) -> gymnasium.Env | gymnasium.vector.VectorEnv:
        if "num_envs" not in context:
            return gymnasium.make(view, horizon=HORIZON)
        return gymnasium.make_vec(view, num_envs=context["num_envs"], horizon=HORIZON)

    register_env(name, make)
    config = (
        settings()
        .environment(name)
        .env_runners(
            num_env_runners=0,
            num_envs_per_env_runner=WORLDS,
            gym_env_vectorize_mode=gymnasium.VectorizeMode.VECTOR_ENTRY_POINT,
        )
    )
    runner = learn(config, "default_policy")
    assert runner.env.unwrapped.transport.num_worlds == WORLDS


def learn(config: PPOConfig, policy: str) -> Any:
    """Two iterations; the runner that collected for them."""
    algorithm = config.build_algo()
    before = weights(algorithm.get_module(policy))
    seen = [algorithm.train()["env_runners"] for _ in range(ITERATIONS)][-1]
    after = weights(algorithm.get_module(policy))
    assert any(not torch.equal(mine, theirs) for mine, theirs in zip(before, after, strict=True))
    assert math.isfinite(seen["episode_return_mean"])
    length = seen["episode_len_mean"]  # one more where RLlib learned in the midst of an episode
    assert 0 < length <= HORIZON + 1, length
    assert np.sum(seen["num_env_steps_sampled_lifetime"]) >= ITERATIONS * STEPS
    runner = algorithm.env_runner
    algorithm.stop()
    return runner


def weights(module: Any) -> list[torch.Tensor]:
    """Copies of a module's weights."""
    return [each.detach().clone() for each in module.parameters()]


if __name__ == "__main__":
    main()
