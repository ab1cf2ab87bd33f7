"""Space of a search: which settings it draws, from where, and what Optuna is told of it."""

import json
from collections.abc import Collection, Mapping
from typing import Any

from coopenv.arrays import number, whole
from coopenv.errors import InvalidInput, UnknownName

from ..algorithms import RECIPES, recipe_of
from ..settings import TrainConfig
from .levels import ALGORITHMS, LEARNER, SETTINGS, taker
from .lines import Place, Source

RANGE = ("low", "high", "log")

Space = Mapping[str, Mapping[str, Any]]
"""Setting -> ``{low, high}``, perhaps with ``log``, or ``{choices}``."""


def space_of(spaces: Mapping[str, Any], algorithm: str) -> Space:
    """What is searched of an algorithm: the table of its name, or what stands in none for PPO."""
    if algorithm in RECIPES:
        return spaces.get(algorithm, {})
    return {name: entry for name, entry in spaces.items() if name not in RECIPES}


def distributions_of(space: Space, algorithm: str = LEARNER) -> dict[str, Any]:
    """Optuna's, one a setting of the algorithm; choices as JSON, as it takes no lists."""
    from optuna import distributions

    found: dict[str, Any] = {}
    for name, entry in space.items():
        if "choices" in entry:
            choices = [json.dumps(choice) for choice in entry["choices"]]
            found[name] = distributions.CategoricalDistribution(choices)
        else:
            kind = (
                distributions.IntDistribution
                if _is_whole(name, algorithm)
                else distributions.FloatDistribution
            )
            found[name] = kind(entry["low"], entry["high"], log=entry.get("log", False))
    return found


def settings_of(space: Space, drawn: Mapping[str, Any]) -> dict[str, Any]:
    """Settings from what Optuna has drawn."""
    return {
        name: json.loads(value) if "choices" in space[name] else value
        for name, value in drawn.items()
    }


def check_space(space: Any, algorithms: Collection[str], source: Source) -> None:
    """Raise, with the line, unless each algorithm takes what is searched of it, and is there.

    Parameters
    ----------
    space
        What stands under ``[search.space]``.
    algorithms
        Of the grid, as its levels say them.
    source
        The file.
    """
    place: Place = ("search", "space")
    known = {*ALGORITHMS}
    with source.at(place):
        if not isinstance(space, Mapping) or not space:
            raise InvalidInput(
                f"space must be a table of settings, got {space!r}; write [search.space]"
            )
    for name, entry in space.items():
        with source.at((*place, name)):
            if name not in RECIPES:
                check_entry(name, entry)
                if taker([*algorithms]) != LEARNER and known.issuperset(algorithms):
                    raise InvalidInput(
                        f"{name} must be searched for ppo or below the name of its algorithm, got "
                        "a grid without ppo; write [search.space.sac] or the like"
                    )
                continue
            if not isinstance(entry, Mapping) or not entry:
                raise InvalidInput(
                    f"space of {name} must be a table of its settings, got {entry!r}; write "
                    f"[search.space.{name}]"
                )
            if name not in algorithms and known.issuperset(algorithms):  # else told by its level
                raise InvalidInput(
                    f"space of {name} must be of an algorithm of the grid, got one that is no "
                    "level of it; add the level, or drop the space"
                )
        for setting, own in entry.items():
            with source.at((*place, name, setting)):
                check_entry(setting, own, name)


def check_entry(name: str, entry: Any, algorithm: str = LEARNER) -> None:
    """Raise unless a setting can be searched so, and its algorithm takes the ends of it."""
    if name not in SETTINGS[algorithm]:
        known = SETTINGS[algorithm] if algorithm in RECIPES else (*SETTINGS[algorithm], *RECIPES)
        raise UnknownName("setting to be searched", name, known)
    for key in entry if isinstance(entry, Mapping) else ():
        if key not in ("choices", *RANGE):
            raise UnknownName(f"entry of the space of {name}", key, ("choices", *RANGE))
    if not isinstance(entry, Mapping) or not ("choices" in entry or {"low", "high"} <= set(entry)):
        raise InvalidInput(
            f"space of {name} must be low and high, or choices, got {entry!r}; write "
            "{ low = 1e-4, high = 1e-2, log = true }"
        )
    if "choices" in entry and len(entry) > 1:
        raise InvalidInput(
            f"space of {name} must be choices or a range, got {', '.join(entry)}; drop one of them"
        )
    if "choices" in entry:
        values = entry["choices"]
        if not isinstance(values, list) or not values:
            raise InvalidInput(f"choices of {name} must be a list of them, got {values!r}")
    else:
        values = [_end(name, entry, key, algorithm) for key in ("low", "high")]
        if not values[0] < values[1]:
            raise InvalidInput(f"low of {name} must be below high, got {values}; exchange them")
        if not isinstance(entry.get("log", False), bool):
            raise InvalidInput(f"log of {name} must be true or false, got {entry['log']!r}")
        if entry.get("log", False) and values[0] <= 0:
            raise InvalidInput(
                f"low of {name} must be positive with log, got {values[0]}; raise it"
            )
    for value in values:
        _settings({"steps": 10**9, name: value}, algorithm)


def _settings(given: Mapping[str, Any], algorithm: str = LEARNER) -> Any:
    """Settings of a training, which raise where one breaks its rule; the others are defaults."""
    if algorithm in RECIPES:
        return recipe_of(algorithm, given)
    values: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in given.items()}
    return TrainConfig(**values)


def _end(name: str, entry: Mapping[str, Any], key: str, algorithm: str) -> float:
    default = getattr(_settings({}, algorithm), name)
    if isinstance(default, tuple | str | bool):
        raise InvalidInput(f"space of {name} must be choices, got a range; list some")
    if _is_whole(name, algorithm):
        return whole(entry[key], f"{key} of {name}", at_least=0)
    return number(entry[key], f"{key} of {name}")


def _is_whole(name: str, algorithm: str) -> bool:
    return isinstance(getattr(_settings({}, algorithm), name), int)
