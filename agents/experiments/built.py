"""What options of a run come to: its settings, its environment and its algorithm, checked."""

from dataclasses import replace
from typing import NamedTuple

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput

from ..algorithms import RECIPES, Recipe
from ..algorithms.recipes import require_actions
from ..settings import TrainConfig
from .levels import Options
from .terms import with_terms


class Built(NamedTuple):
    """What a run is made of."""

    training: TrainConfig
    environment: TransportConfig
    recipe: Recipe | None


def built(options: Options, *, complete: bool = True) -> Built:
    """Settings, environment and recipe of a run.

    Parameters
    ----------
    options
        Of the run.
    complete
        Whether all levels are in it, so that whoever acts by a script has to find one.

    Raises
    ------
    InvalidInput, UnknownName
        If something of it breaks its rule, or does not go with the rest.
    """
    env = options.environment.get("env", "")
    if ":" in str(env):
        raise InvalidInput(
            f"env must be an id without a module in an experiment, got {env!r}; a file "
            "imports nothing: train it with coopenv train --env"
        )
    shared = RECIPES[options.algorithm].SHARED if options.algorithm in RECIPES else ()
    of_ppo = {name: value for name, value in options.training.items() if name not in shared}
    training = TrainConfig(environment=options.choice(), threads=1, **of_ppo)
    environment = training.environment.config()
    if options.terms:
        reward = with_terms(environment.terms, options.terms)
        environment = replace(environment, reward=reward)
    if complete and options.algorithm == "scripted":
        from ..controllers import find_controller

        find_controller(environment)
    if options.algorithm in RECIPES:
        require_actions(options.algorithm, environment.action == "discrete")
    return Built(training, environment, options.recipe())
