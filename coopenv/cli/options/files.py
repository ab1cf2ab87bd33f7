"""Commands with the options of a file, ``--config``: every option by its name."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, fields, is_dataclass, replace
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any, get_args, get_type_hints

from coopenv.agents.environment import EnvironmentChoice
from coopenv.cli.options.content import (
    checked,
    content_of,
    environment,
    environment_table,
    without_fresh,
)
from coopenv.cli.options.values import converted
from coopenv.config.own_code import Trust

TABLE = "environment"  # of a file: what says which environment it is
NOT_IN_FILES = ("config", "trust")  # what a file cannot say


def before(arguments: Sequence[str], commands: Mapping[str, type], missing: Any) -> Any:
    """The command as it is before options are given; None if it is always so.

    With the options of the file that ``--config`` names, and what suits the id that ``--env`` does,
    the actions that ``--action`` and the learners that ``--control`` does.

    Parameters
    ----------
    arguments
        Of the command line, the command's name first.
    commands
        Name → class.
    missing
        What stands for options that have to be given and are not in the file.

    Raises
    ------
    InvalidInput, UnknownName
        If the file cannot be read, a name is not known or a value breaks its rule.
    """
    kind = commands.get(next(iter(arguments), ""))
    if kind is None:
        return None
    config, suited = _value_of("--config", arguments), getattr(kind, "suited", None)
    named = {name: _value_of(f"--{name}", arguments) for name in ("env", "action", "control")}
    chosen = {name: value for name, value in named.items() if value}
    if not config:
        return suited(**chosen) if suited is not None and chosen else None
    path, trust = Path(config), trusted(arguments)
    own = getattr(kind, "configured", None)  # a form of its own
    if own is not None:
        return own(path, trust, **(chosen if suited is not None else {}))
    below = parts(kind)
    chosen = below.get(next(iter(arguments[1:]), "")) if below else kind
    if chosen is None or "config" not in options(chosen):
        return None
    content = without_fresh(checked(content_of(path), f"option in {path}", _known(chosen)), path)
    made = _made(chosen, content, path, trust, missing)
    return kind(**{fields(kind)[0].name: made}) if below else made


def over(command: Any, file: Any) -> Any:
    """The command, its environment's numbers over those of the command from a file."""
    if isinstance(command, EnvironmentChoice):
        return command.over_file(file)
    changes = {
        entry.name: over(own, getattr(file, entry.name))
        for entry in fields(command)
        if is_dataclass(own := getattr(command, entry.name)) and _holds_environment(type(own))
    }
    return replace(command, **changes) if changes else command


def options(kind: type) -> Iterator[str]:
    """Names of the options of a command, those of its parts too."""
    for entry, hint in _entries(kind):
        if is_dataclass(hint):
            yield from options(hint)  # pyright: ignore[reportArgumentType]
        else:
            yield entry.name


def parts(kind: type) -> dict[str, type]:
    """The commands below a command, by name; none for most."""
    (_, hint), *_ = _entries(kind)
    kinds = [each for each in get_args(hint) if is_dataclass(each) and isinstance(each, type)]
    return {re.sub(r"(?<!^)(?=[A-Z])", "-", each.__name__).lower(): each for each in kinds}


def trusted(arguments: Sequence[str]) -> Trust:
    """Modules that the command line itself names; all if it trusts its files as a whole."""
    named: list[str] = []
    for place, option in enumerate(arguments):
        name, equals, value = option.partition("=")
        words = takewhile(lambda word: not word.startswith("--"), arguments[place + 1 :])
        given = [value] if equals else [*words]
        if name == "--trust" and not given:
            return True
        if name == "--trust":
            named += given
        elif name == "--env" and given:
            named.append(given[0].rpartition(":")[0])
    return named


def _value_of(wanted: str, arguments: Sequence[str]) -> str | None:
    """What an option is given, the last time if several."""
    found = None
    for option, following in pairwise([*arguments, ""]):
        name, equals, value = option.partition("=")
        if name == wanted:
            found = value if equals else following
    return found


def _entries(kind: type) -> list[tuple[Field[Any], Any]]:
    """Fields of a command, and their types."""
    hints = get_type_hints(kind)
    return [(entry, hints[entry.name]) for entry in fields(kind)]


def _holds_environment(kind: type) -> bool:
    return kind is EnvironmentChoice or any(
        is_dataclass(hint) and _holds_environment(hint)  # pyright: ignore[reportArgumentType]
        for _, hint in _entries(kind)
    )


def _known(kind: type) -> Iterator[str]:
    """Names that a file may have."""
    for entry, hint in _entries(kind):
        if hint is EnvironmentChoice:
            yield TABLE
        elif is_dataclass(hint):
            yield from _known(hint)  # pyright: ignore[reportArgumentType]
        elif entry.name not in NOT_IN_FILES:
            yield entry.name


def _made(
    kind: type,
    content: Mapping[str, Any],
    path: Path,
    trust: Trust,
    missing: Any,
    start: Any = None,
) -> Any:
    """A command, or a part of one, with what the file has of it, over ``start``."""
    values: dict[str, Any] = {}
    for entry, hint in _entries(kind):
        if start is not None:
            own = getattr(start, entry.name)
        elif entry.default_factory is not MISSING:
            own = entry.default_factory()
        else:
            own = missing if entry.default is MISSING else entry.default
        if hint is EnvironmentChoice:
            own = environment(environment_table(content.get(TABLE, {}), path, trust), own)
        elif is_dataclass(hint):
            own = _made(type(own), content, path, trust, missing, own)
        elif entry.name in content:
            own = converted(content[entry.name], hint, entry.name)
        values[entry.name] = own
    return kind(**values)
