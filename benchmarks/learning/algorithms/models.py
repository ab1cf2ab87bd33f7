"""Trainings of Stable-Baselines3 and sb3-contrib by a recipe, with a curve of their own."""

from benchmarks.learning.algorithms.curve import Curve, Drawn
from coopenv.agents.algorithms import Recipe
from coopenv.agents.algorithms.models import model_of
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv
from coopenv.agents.seeds import training_seeds
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX


def learned(recipe: Recipe, env: str, seed: int) -> tuple[SB3Policy, Curve]:
    """Train one policy for the team, in what a training in that environment sees."""
    environment = train_config(f"{PREFIX}{env}-v0").environment.config()
    curve = Curve(environment.horizon, recipe.num_worlds)
    venv = TransportVecEnv(environment, recipe.num_worlds)
    model = model_of(recipe, venv, seed=seed)
    venv.seed(training_seeds(seed, recipe.num_worlds)[0])  # after the model, which seeds them too
    model.learn(recipe.steps, callback=Drawn(curve))
    return SB3Policy(model), curve
