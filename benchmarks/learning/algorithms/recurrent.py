"""Recurrent PPO of sb3-contrib with one policy for the team.

Its settings are the defaults of `coopenv train`, with a recurrent layer and fewer control steps.
"""

from collections.abc import Mapping
from typing import Any

from sb3_contrib import RecurrentPPO

from benchmarks.learning.algorithms.curve import Curve, Drawn
from coopenv.agents.learned.sequences import Residual, WholeSequences
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv, feature_scale
from coopenv.agents.seeds import training_seeds
from coopenv.agents.settings import TrainConfig
from coopenv.agents.training.hyperparameters import ppo_settings
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX

MORE = {"num_worlds": 64, "rollout": 128}  # longer sequences, and four times as many updates
OF: Mapping[str, Mapping[str, Any]] = {  # what differs from `START`, by the search
    "BeamTransport": {"steps": 300_000, **MORE, "epochs": 10},
    "BeamTracking": {"steps": 300_000},
    "WalkerTurn": {"steps": 500_000, **MORE, "epochs": 10},
    "BeamDoorway": {"steps": 1_200_000, **MORE, "epochs": 10},
    "WalkerAvoid": {"steps": 600_000, **MORE, "epochs": 10},
    "BeamLift": {"steps": 1_800_000, **MORE, "residual": True},
}
TAKEN = ("num_worlds", "rollout", "epochs", "batch_size", "learning_rate")  # of the defaults
START = {
    "units": 64,
    "residual": False,
    **{name: getattr(TrainConfig(), name) for name in TAKEN},
}
OWN = ("units", "residual")  # settings that are none of a `TrainConfig`


def settings(env: str) -> dict[str, Any]:
    """Those with which it is trained."""
    return {**START, **OF[env]}


def learn(env: str, seed: int, given: dict[str, Any]) -> tuple[SB3Policy, Curve]:
    """Train with such settings."""
    others = {name: value for name, value in given.items() if name not in OWN}
    config = train_config(f"{PREFIX}{env}-v0", seed=seed, **others)
    environment = config.environment.config()
    curve = Curve(environment.horizon, config.num_worlds)
    venv = TransportVecEnv(environment, config.num_worlds)
    keywords = ppo_settings(config, rows=venv.num_envs, scale=feature_scale(venv))
    keywords["policy_kwargs"]["lstm_hidden_size"] = given["units"]
    policy = Residual if given["residual"] else WholeSequences
    model = RecurrentPPO(policy, venv, **keywords)
    venv.seed(training_seeds(seed, config.num_worlds)[0])  # after the model, which seeds them too
    model.learn(config.steps, callback=Drawn(curve))
    return SB3Policy(model), curve
