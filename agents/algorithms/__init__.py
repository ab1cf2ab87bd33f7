"""Other algorithms than PPO: SAC and recurrent PPO, with settings that learn on many worlds."""

from .recipes import RECIPES, Recipe, recipe_of
from .recurrent import RecurrentConfig
from .sac import SACConfig

__all__ = ["RECIPES", "Recipe", "RecurrentConfig", "SACConfig", "recipe_of"]
