"""Hyperparameters of PPO: keywords for Stable-Baselines3 from the settings of a run."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..features import scale_of_features
from ..learned import FallingRate, Scaled
from ..settings import TrainConfig
from ..vec_env import TransportVecEnv
from .teams_vec_env import TeamsVecEnv


def recommended(
    venv: TransportVecEnv | TeamsVecEnv, config: TrainConfig | None = None
) -> dict[str, Any]:
    """Keywords for ``PPO("MlpPolicy", venv, **keywords)``: those with which `train` learns.

    An update is made from as many control steps as in `train`, however many worlds there are. The
    learning rate falls to zero at the end of what ``learn`` is told.

    Parameters
    ----------
    venv
        Of `coopenv.agents.sb3.make_vec_env`.
    config
        Settings of a run; the defaults if ``None``. ``seed`` is not among the keywords.
    """
    config = config if config is not None else TrainConfig()
    keywords = ppo_settings(config, rows=venv.num_envs, scale=feature_scale(venv))
    worlds = sum(part.transport.num_worlds for part in getattr(venv, "parts", [venv]))
    keywords["n_steps"] = max(2, round(config.rollout * config.num_worlds / worlds))
    keywords["batch_size"] = min(config.batch_size, keywords["n_steps"] * venv.num_envs)
    del keywords["seed"]
    return keywords


def ppo_settings(config: TrainConfig, *, rows: int, scale: Sequence[float]) -> dict[str, Any]:
    """What a ``PPO`` of Stable-Baselines3, or one like it, is made with for a run.

    Parameters
    ----------
    config
        Of the run.
    rows
        Of its ``VecEnv``.
    scale
        One factor a feature of a row.
    """
    return {
        "n_steps": config.rollout,
        "batch_size": min(config.batch_size, config.rollout * rows),
        "n_epochs": config.epochs,
        "learning_rate": FallingRate(config.learning_rate),
        "gamma": config.discount,
        "gae_lambda": config.gae_lambda,
        "clip_range": config.clip_range,
        "ent_coef": config.entropy_weight,
        "policy_kwargs": {
            "net_arch": list(config.hidden),
            "log_std_init": float(np.log(config.initial_std)),
            "features_extractor_class": Scaled,
            "features_extractor_kwargs": {"scale": list(scale)},
        },
        "seed": config.seed,
        "device": "cpu",
    }


def feature_scale(venv: TransportVecEnv | TeamsVecEnv) -> list[float]:
    """One factor a feature, which brings it to order one (`features.scale_of_features`)."""
    rows = 1 if venv.control == "shared" else len(venv.transport.learners)
    return scale_of_features(venv.transport) * rows
