"""SAC of Stable-Baselines3 with one policy for the team."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from stable_baselines3 import SAC

from benchmarks.learning.algorithms.curve import Curve, Drawn
from coopenv.agents.algorithms.models import sac_settings
from coopenv.agents.algorithms.sac import SACConfig as Recipe
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv, feature_scale
from coopenv.agents.seeds import training_seeds
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX

OF: Mapping[str, Mapping[str, Any]] = {  # what differs from the `Recipe`, which the search chose
    "BeamTransport": {"steps": 150_000},
    "BeamTracking": {"steps": 100_000},
    "WalkerTurn": {"steps": 400_000},
    "BeamDoorway": {"steps": 600_000},
    "WalkerAvoid": {"steps": 400_000},
    "BeamLift": {"steps": 400_000},
}


def settings(env: str) -> dict[str, Any]:
    """Those with which it is trained: of a `Recipe`."""
    return asdict(Recipe(**OF[env]))


def learn(env: str, seed: int, given: dict[str, Any]) -> tuple[SB3Policy, Curve]:
    """Train with such settings of a `Recipe`."""
    recipe = Recipe(**given)
    environment = train_config(f"{PREFIX}{env}-v0").environment.config()
    curve = Curve(environment.horizon, recipe.num_worlds)
    venv = TransportVecEnv(environment, recipe.num_worlds)
    model = SAC("MlpPolicy", venv, seed=seed, **sac_settings(recipe, feature_scale(venv)))
    venv.seed(training_seeds(seed, recipe.num_worlds)[0])  # after the model, which seeds them too
    model.learn(recipe.steps, callback=Drawn(curve))
    return SB3Policy(model), curve
