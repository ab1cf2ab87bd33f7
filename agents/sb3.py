"""Stable-Baselines3: worlds as a ``VecEnv``, trained models as policies, what a training needs."""

from typing import Any

from coopenv.config import TransportConfig

from .environment import find_config
from .learned import FallingRate, SB3Policy, Scaled, save_model
from .training.hyperparameters import feature_scale, recommended
from .training.teams_vec_env import TeamsVecEnv
from .vec_env import TransportVecEnv

__all__ = [
    "FallingRate",
    "SB3Policy",
    "Scaled",
    "TeamsVecEnv",
    "TransportVecEnv",
    "feature_scale",
    "make_vec_env",
    "recommended",
    "save_model",
]


def make_vec_env(
    env: str | TransportConfig = "coopenv/BeamTransport-v0",
    num_worlds: int = 64,
    *,
    control: str = "joint",
    seed: int | None = None,
    render_mode: str | None = None,
    **keywords: Any,
) -> TransportVecEnv:
    """A Stable-Baselines3 ``VecEnv`` in which all worlds are stepped together.

    Parameters
    ----------
    env
        A Gymnasium id of this package, or a whole configuration.
    num_worlds
        Worlds stepped together.
    control
        ``"joint"``: one policy moves the whole team; a row is a world. ``"shared"``: every agent
        runs the same policy on what it sees itself; a row is an agent. ``"partner"``: somebody
        else drives all agents but one (``partner=``, by default
        `coopenv.agents.partners.default_partner`); a row is a world. Agents that a partner drives
        have no part in any of the three.
    seed
        World k is seeded with ``seed + k`` at the first reset.
    render_mode
        ``"rgb_array"`` or ``None``.
    **keywords
        Fields of `coopenv.TransportConfig`, over those of the id; not beside a configuration.
    """
    config = find_config(env, keywords)
    venv = TransportVecEnv(config, num_worlds, control=control, render_mode=render_mode)
    if seed is not None:
        venv.seed(seed)
    return venv
