"""Models of Stable-Baselines3 and sb3-contrib as recipes say them."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from coopenv.errors import MissingExtra

from ..learned import FallingRate, Scaled
from ..training.hyperparameters import feature_scale, ppo_settings
from ..vec_env import TransportVecEnv
from .recipes import Recipe, require_installed
from .recurrent import RecurrentConfig
from .sac import SACConfig

try:
    from stable_baselines3 import SAC
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
except ImportError as error:
    raise MissingExtra("coopenv.agents.algorithms", "train") from error


def model_of(
    recipe: Recipe, venv: TransportVecEnv, *, seed: int, log: str | None = None
) -> BaseAlgorithm:
    """A model that has learned nothing yet.

    Parameters
    ----------
    recipe
        Its settings.
    venv
        That it is to learn in; it is seeded as well, with numbers of no run.
    seed
        Of weights and exploration.
    log
        Folder of TensorBoard's events, if any.

    Raises
    ------
    MissingExtra
        If the package of the algorithm is not installed.
    """
    scale = feature_scale(venv)
    if isinstance(recipe, SACConfig):
        rows = Fraction(venv.num_envs, venv.transport.num_worlds)
        keywords = sac_settings(recipe, scale, rows=rows)
        return SAC("MlpPolicy", venv, seed=seed, tensorboard_log=log, **keywords)
    return _recurrent(recipe, venv, scale, seed, log)


def sac_settings(
    recipe: SACConfig, scale: Sequence[float], *, rows: Fraction | int = 1
) -> dict[str, Any]:
    """Keywords for ``SAC("MlpPolicy", venv, **keywords)``.

    Parameters
    ----------
    recipe
        Of the training.
    scale
        One factor a feature of a row of the ``VecEnv`` (`coopenv.agents.sb3.feature_scale`).
    rows
        Of the ``VecEnv`` a control step of a world.
    """
    policy: dict[str, Any] = {"net_arch": list(recipe.hidden)}
    if recipe.scaled:
        policy["features_extractor_class"] = Scaled
        policy["features_extractor_kwargs"] = {"scale": list(scale)}
    rate = recipe.learning_rate
    several = {"n_steps": recipe.n_steps} if recipe.n_steps > 1 else {}  # new in version 2.7
    return {
        "train_freq": 1,
        "gradient_steps": recipe.gradient_steps,
        "batch_size": recipe.batch_size,
        "learning_rate": FallingRate(rate) if recipe.falling else rate,
        "gamma": recipe.discount,
        "ent_coef": recipe.entropy,
        "target_entropy": recipe.target_entropy,
        "tau": recipe.tau,
        "learning_starts": int(recipe.random_steps * rows),
        "buffer_size": int(recipe.buffer * rows),
        **several,
        "policy_kwargs": policy,
        "device": "cpu",
    }


def _recurrent(
    recipe: RecurrentConfig,
    venv: TransportVecEnv,
    scale: Sequence[float],
    seed: int,
    log: str | None,
) -> BaseAlgorithm:
    require_installed("recurrent")
    from sb3_contrib import RecurrentPPO

    from ..learned.sequences import Residual, WholeSequences

    keywords = ppo_settings(recipe.of_ppo(seed), rows=venv.num_envs, scale=scale)
    keywords["policy_kwargs"]["lstm_hidden_size"] = recipe.units
    policy = Residual if recipe.residual else WholeSequences
    return RecurrentPPO(policy, venv, tensorboard_log=log, **keywords)


def writable(model: BaseAlgorithm) -> BaseAlgorithm:
    """The model; a recurrent one as of its parent's class, which a file can name and acts alike.

    One with a residual layer acts otherwise, and files know its class.
    """
    if isinstance(model, OnPolicyAlgorithm) and not hasattr(model.policy_class, "ALIAS"):
        model.policy_class = model.policy_aliases["MlpLstmPolicy"]
    return model
