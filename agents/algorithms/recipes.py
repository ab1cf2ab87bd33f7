"""Recipes: all that a training of an algorithm beside PPO is told of the algorithm, by its name."""

import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any, TypeAlias

from coopenv.errors import InvalidInput, MissingExtra, UnknownName

from .recurrent import RecurrentConfig
from .sac import SACConfig

Recipe: TypeAlias = SACConfig | RecurrentConfig
"""Settings of an algorithm."""

RECIPES: Mapping[str, type[Recipe]] = {"sac": SACConfig, "recurrent": RecurrentConfig}
"""Name of an algorithm -> its settings."""


def settings_in(name: str) -> tuple[str, ...]:
    """Names of the settings of the algorithm of that name."""
    return tuple(entry.name for entry in fields(RECIPES[name]))


def recipe_of(name: str, given: Mapping[str, Any]) -> Recipe:
    """Settings of the algorithm of that name; lists stand for tuples, as files have them.

    Raises
    ------
    InvalidInput, UnknownName
        If the algorithm or a setting is not known, or a setting breaks its rule.
    """
    if name not in RECIPES:
        raise UnknownName("algorithm", name, RECIPES)
    known = settings_in(name)
    for key in given:
        if key not in known:
            raise UnknownName(f"setting of {name}", key, known)
    values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in given.items()}
    return RECIPES[name](**values)


def name_of(recipe: Recipe) -> str:
    """The name in `RECIPES`."""
    return next(name for name, kind in RECIPES.items() if type(recipe) is kind)


def plain(recipe: Recipe) -> dict[str, Any]:
    """Numbers, strings and lists, of which `recipe_of` makes the same again."""
    return json.loads(json.dumps(asdict(recipe)))


def require_installed(name: str) -> None:
    """Raise `MissingExtra` if sb3-contrib trains an algorithm and is not installed."""
    if name != "recurrent":
        return
    try:
        import sb3_contrib  # noqa: F401
    except ImportError as error:
        raise MissingExtra("recurrent PPO", "contrib") from error


def require_actions(name: str, discrete: bool) -> None:
    """Raise `InvalidInput` if an algorithm of `RECIPES` cannot choose among pushes."""
    if name == "sac" and discrete:
        raise InvalidInput(
            "action must be made of numbers for SAC, got 'discrete', the number of a push; choose "
            "another action, or learn by PPO"
        )
