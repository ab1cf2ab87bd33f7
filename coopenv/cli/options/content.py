"""Content of a file of options: TOML or JSON, of which every name is known."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from coopenv.agents.environment import GROUPS, EnvironmentChoice, entries_of
from coopenv.agents.settings import UNSAVED, TrainConfig
from coopenv.config.own_code import Trust
from coopenv.envs.registry import require_trusted
from coopenv.errors import InvalidInput, UnknownName
from coopenv.files import reading, toml

ENVIRONMENT = tuple(entry.name for entry in fields(EnvironmentChoice))
TRAINING = tuple(entry.name for entry in fields(TrainConfig))
PLACES = {
    **dict.fromkeys(TRAINING, "put it on top of the file, before the first [table]"),
    **dict.fromkeys(ENVIRONMENT, "put it under [environment]"),
}


def content_of(path: Path) -> Any:
    """What the file holds.

    Raises
    ------
    InvalidInput
        If it cannot be read, or is neither TOML nor JSON.
    """
    if path.suffix not in (".toml", ".json"):
        raise InvalidInput(f"config must be a .toml or .json file, got {str(path)!r}; rename it")
    with reading(path):
        text = path.read_text(encoding="utf-8-sig")  # editors of some systems begin with a mark
        return toml.loads(text) if path.suffix == ".toml" else json.loads(text)


def checked(
    content: Any, what: str, known: Iterable[str], elsewhere: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """A table of options, its names with underscores; raise where one is not ``known``."""
    if not isinstance(content, dict):
        raise InvalidInput(f"{what} must be a name with a value, got {content!r}; write a table")
    names, known = {name: name.replace("-", "_") for name in content}, tuple(known)
    for name in names.values():
        if name not in known:
            raise UnknownName(what, name, known, elsewhere)
    twice = [name for name in names if list(names.values()).count(names[name]) > 1]
    if twice:
        raise InvalidInput(
            f"{what} must be said once, got {' and '.join(map(repr, twice))}; leave one out"
        )
    return {names[name]: value for name, value in content.items()}


def without_fresh(content: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """The options; raise if they would remove a run whenever the file is used.

    ``false`` is what runs of before wrote, and removes nothing.
    """
    for name in UNSAVED:
        if content.get(name, False) is not False:
            raise InvalidInput(
                f"{name} must be given on the command line, got {content[name]!r} in {path}, which "
                f"would remove a run each time; take it out of the file and give --{name}"
            )
    return {name: value for name, value in content.items() if name not in UNSAVED}


def environment_table(content: Any, path: Path, trust: Trust) -> dict[str, Any]:
    """The table ``[environment]`` of a file, that imports nothing which is not trusted."""
    table = checked(content, f"option in {path}, environment", ENVIRONMENT, PLACES)
    require_trusted(_plain(table.get("env", ""), "env"), trust, str(path))
    return table


def environment(given: Mapping[str, Any], start: EnvironmentChoice) -> EnvironmentChoice:
    """What a file says of the environment, over ``start``."""
    values = {
        name: entries_of(value, name) if name in GROUPS else _plain(value, name)
        for name, value in given.items()
    }
    return replace(start, **values)


def _plain(value: Any, name: str) -> Any:
    if name in ("observe", "also_observe") and isinstance(value, list):
        return tuple(value)
    if name == "env" and not isinstance(value, str):
        raise InvalidInput(f"env must be an id, got {value!r}; coopenv/BeamTransport-v0 is one")
    return value
