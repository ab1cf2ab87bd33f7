"""Models of every algorithm that acts in a box, small and barely trained."""

import zipfile
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import sb3_contrib
import stable_baselines3
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from coopenv import Transport, TransportConfig
from coopenv.agents import sb3
from tests.helpers import EASY

PLAIN = {"policy_kwargs": {"net_arch": [8]}}
OFF_POLICY = {**PLAIN, "learning_starts": 2, "batch_size": 4, "buffer_size": 50}
ON_POLICY: dict[str, Any] = {**PLAIN, "n_steps": 4, "batch_size": 4, "n_epochs": 1}
ALGORITHMS: dict[str, tuple[type[BaseAlgorithm], dict[str, Any]]] = {
    "PPO": (stable_baselines3.PPO, ON_POLICY),
    "A2C": (stable_baselines3.A2C, {**PLAIN, "n_steps": 4}),
    "SAC": (stable_baselines3.SAC, OFF_POLICY),
    "TD3": (stable_baselines3.TD3, OFF_POLICY),
    "DDPG": (stable_baselines3.DDPG, OFF_POLICY),
    "TQC": (sb3_contrib.TQC, OFF_POLICY),
    "TRPO": (sb3_contrib.TRPO, {**PLAIN, "n_steps": 4, "batch_size": 4}),
    "ARS": (sb3_contrib.ARS, {**PLAIN, "n_delta": 1, "n_top": 1}),
    "CrossQ": (sb3_contrib.CrossQ, OFF_POLICY),
    "RecurrentPPO": (
        sb3_contrib.RecurrentPPO,
        {**ON_POLICY, "policy_kwargs": {"net_arch": [8], "lstm_hidden_size": 8}},
    ),
}
SPREADLESS = ("TD3", "DDPG", "ARS")
CONFIG = TransportConfig(task=EASY, horizon=6)


def small(control: str = "joint") -> sb3.TransportVecEnv:
    """Two worlds whose episodes end soon."""
    return sb3.make_vec_env(CONFIG, 2, control=control, seed=5)


def trained(name: str, venv: VecEnv, **keywords: Any) -> BaseAlgorithm:
    """A model after a dozen steps."""
    torch.set_num_threads(1)
    algorithm, given = ALGORITHMS[name]
    policy = "MlpLstmPolicy" if name == "RecurrentPPO" else "MlpPolicy"
    model: Any = algorithm(policy, venv, device="cpu", seed=1, **deepcopy({**given, **keywords}))
    return model.learn(12)


def untrained(algorithm: type[BaseAlgorithm], venv: Any, policy: Any = "MlpPolicy") -> Any:
    """A model of one's own kind of PPO, policy or environment."""
    made: Any = algorithm
    return made(policy, venv, device="cpu", **deepcopy(ON_POLICY))


def normalized(control: str = "joint") -> VecNormalize:
    """`small`, behind statistics that are far from none."""
    venv = VecNormalize(small(control))
    venv.reset()
    rng = np.random.default_rng(0)
    for _ in range(20):
        venv.step(rng.uniform(-1, 1, (venv.num_envs, *venv.action_space.shape)))  # type: ignore[misc]
    return venv


def start(num_worlds: int = 5, config: TransportConfig = CONFIG) -> tuple[Any, Any]:
    """First observations and the transition of a batch."""
    core = Transport(num_worlds=num_worlds, config=config)
    obs, _ = core.reset(seed=0)
    return obs, core.transition


def write_member(path: Path, name: str, text: str) -> None:
    """Put a member into an archive beside what it has."""
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(name, text)
