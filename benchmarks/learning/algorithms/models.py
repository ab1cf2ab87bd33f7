"""Trainings of Stable-Baselines3 and sb3-contrib by a recipe, with a curve of their own."""

from benchmarks.learning.algorithms.curve import Curve, Drawn
from benchmarks.learning.algorithms.environment import environment_of
from coopenv.agents.algorithms import Recipe
from coopenv.agents.algorithms.models import model_of
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv
from coopenv.agents.seeds import training_seeds


def learned(
    recipe: Recipe, env: str, seed: int, action: str | None = None
) -> tuple[SB3Policy, Curve]:
    """Train one policy for the team, in what a training in that environment sees."""
    environment = environment_of(env, action)
    curve = Curve(environment.horizon, recipe.num_worlds)
    venv = TransportVecEnv(environment, recipe.num_worlds)
    model = model_of(recipe, venv, seed=seed)
    venv.seed(training_seeds(seed, recipe.num_worlds)[0])  # after the model, which seeds them too
    model.learn(recipe.steps, callback=Drawn(curve))
    return SB3Policy(model), curve
