"""Space of a search: which settings it draws, from where, and what Optuna is told of it."""

import json
from collections.abc import Mapping
from typing import Any

from coopenv.arrays import number, whole
from coopenv.errors import InvalidInput, UnknownName

from ..settings import TrainConfig
from .levels import TRAINING

RANGE = ("low", "high", "log")
UNSEARCHED = ("hidden",)  # lists: to be chosen from, but in no range

Space = Mapping[str, Mapping[str, Any]]
"""Setting -> ``{low, high}``, perhaps with ``log``, or ``{choices}``."""


def distributions_of(space: Space) -> dict[str, Any]:
    """Optuna's, one a setting; choices as JSON, as it takes no lists."""
    from optuna import distributions

    found: dict[str, Any] = {}
    for name, entry in space.items():
        if "choices" in entry:
            choices = [json.dumps(choice) for choice in entry["choices"]]
            found[name] = distributions.CategoricalDistribution(choices)
        else:
            kind = (
                distributions.IntDistribution
                if _is_whole(name)
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


def check_entry(name: str, entry: Any) -> None:
    """Raise unless a setting can be searched so, and the trainer takes the ends of what it says."""
    if name not in TRAINING:
        raise UnknownName("setting to be searched", name, TRAINING)
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
        values = [_end(name, entry, key) for key in ("low", "high")]
        if not values[0] < values[1]:
            raise InvalidInput(f"low of {name} must be below high, got {values}; exchange them")
        if not isinstance(entry.get("log", False), bool):
            raise InvalidInput(f"log of {name} must be true or false, got {entry['log']!r}")
        if entry.get("log", False) and values[0] <= 0:
            raise InvalidInput(
                f"low of {name} must be positive with log, got {values[0]}; raise it"
            )
    for value in values:
        given = tuple(value) if isinstance(value, list) else value
        TrainConfig(**{"steps": 10**9, name: given})


def _end(name: str, entry: Mapping[str, Any], key: str) -> float:
    if name in UNSEARCHED:
        raise InvalidInput(f"space of {name} must be choices, got a range; list some")
    if _is_whole(name):
        return whole(entry[key], f"{key} of {name}", at_least=0)
    return number(entry[key], f"{key} of {name}")


def _is_whole(name: str) -> bool:
    return isinstance(getattr(TrainConfig(), name), int)
