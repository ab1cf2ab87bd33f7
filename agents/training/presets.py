"""Settings of PPO for each environment: what ``coopenv train`` takes where nothing is said."""

from collections.abc import Mapping
from typing import Any

from ..settings import EnvironmentChoice, TrainConfig

_THOROUGH = {"num_worlds": 64, "rollout": 128, "epochs": 10}  # twice the gradient steps

PRESETS: Mapping[str, Mapping[str, Any]] = {
    "coopenv/BeamDoorway-v0": {**_THOROUGH, "steps": 1_800_000},
    "coopenv/BeamLift-v0": {**_THOROUGH, "steps": 1_200_000},
    "coopenv/BeamTracking-v0": {**_THOROUGH, "steps": 600_000},
    "coopenv/WalkerAvoid-v0": {**_THOROUGH, "steps": 1_800_000},
    "coopenv/WalkerTurn-v0": {**_THOROUGH, "steps": 600_000},
}
"""Gymnasium id to what is not as in `coopenv.agents.settings.TrainConfig`."""


def preset(env: str) -> dict[str, Any]:
    """Settings of a training in the environment of a Gymnasium id; none for one of your own.

    Parameters
    ----------
    env
        The id, with the module that registers it before a colon or without.
    """
    return dict(PRESETS.get(env.rpartition(":")[2], {}))


def train_config(environment: EnvironmentChoice | str, **settings: Any) -> TrainConfig:
    """Settings of a run: those that are given, the others as the environment's `preset` has them.

    Parameters
    ----------
    environment
        Of the run, or its id.
    **settings
        Fields of `coopenv.agents.settings.TrainConfig`.

    Raises
    ------
    InvalidInput, UnknownName
        If a setting breaks its rule, or the environment does not exist.

    Examples
    --------
    >>> train_config("coopenv/BeamDoorway-v0", seed=3).steps > TrainConfig().steps
    True
    """
    if isinstance(environment, str):
        environment = EnvironmentChoice(env=environment)
    return TrainConfig(environment=environment, **{**preset(environment.env), **settings})
