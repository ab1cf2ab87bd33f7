"""Reading of the command line: which command, and its options."""

import io
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import fields, is_dataclass
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Annotated, Any, Union, get_type_hints

from coopenv.config.own_code import Trust
from coopenv.errors import CoopenvError, MissingExtra, likely
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene

PROGRAM = "coopenv"
ABOUT = (
    "Learn to carry things together. coopenv --version says which libraries are used. Exit codes: "
    "0 done; 1 refused or failed, with the reason; 2 options that make no sense; 130 interrupted."
)


def read(arguments: Sequence[str], commands: Mapping[str, type]) -> Any:
    """The command that arguments name, with their options; help if there are none.

    Raises
    ------
    CoopenvError
        If a value breaks its rule.
    MissingExtra
        If the library that reads options is not installed.
    SystemExit
        After help, with 0, and after an explanation of what makes no sense, with 2.
    """
    try:
        import tyro
    except ImportError as error:
        extra = (
            "analysis"
            if arguments and arguments[0] in ("decompose", "inspect", "show")
            else "train"
        )
        raise MissingExtra("the command line", extra) from error
    before = _default(arguments, commands)
    kinds: list[Any] = []
    for name, kind in commands.items():
        default = {"default": before} if type(before) is kind else {}
        kinds.append(Annotated[kind, tyro.conf.subcommand(name, **default)])
    explained = io.StringIO()
    try:
        with redirect_stderr(explained):
            command: Any = tyro.cli(  # pyright: ignore[reportCallIssue]
                Union[tuple(kinds)],  # pyright: ignore[reportArgumentType]  # noqa: UP007
                prog=PROGRAM,
                description=ABOUT,
                args=list(arguments) or ["--help"],
                config=(
                    tyro.conf.OmitArgPrefixes,
                    tyro.conf.OmitSubcommandPrefixes,
                    tyro.conf.PositionalRequiredArgs,
                ),
            )
        return command if before is None else command.over(before)
    except SystemExit as stopped:
        for error in _causes(stopped):
            if isinstance(error, CoopenvError):  # in our words, without those of the reader
                raise error from None
        said = _meant(arguments, commands) or explained.getvalue().rstrip()
        if said:
            print(said, file=sys.stderr)
        raise


def _default(arguments: Sequence[str], commands: Mapping[str, type]) -> Any:
    """The command as it is where nothing is given, of a file or of an id; None if it is always so.

    With the options of the file that ``--config`` names, and what suits the id that ``--env`` does.
    """
    kind = commands.get(next(iter(arguments), ""))
    path, env = _value_of("--config", arguments), _value_of("--env", arguments)
    configured, suited = getattr(kind, "configured", None), getattr(kind, "suited", None)
    if configured is not None and path:
        beside = {"env": env} if suited is not None and env else {}
        return configured(Path(path), _trusted(arguments), **beside)
    return suited(env) if suited is not None and env else None


def _value_of(wanted: str, arguments: Sequence[str]) -> str | None:
    """What an option is given, the last time if several."""
    found = None
    for option, following in pairwise([*arguments, ""]):
        name, equals, value = option.partition("=")
        if name == wanted:
            found = value if equals else following
    return found


def _trusted(arguments: Sequence[str]) -> Trust:
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


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """An error, and those in whose handling it was raised."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _meant(arguments: Sequence[str], commands: Mapping[str, type]) -> str | None:
    """One line about the first option that is not known; None where all are."""
    if not arguments or arguments[0] not in commands:
        return None
    known = set(_options(commands[arguments[0]])) | {"help"}
    for given in arguments[1:]:
        option = given.partition("=")[0]
        name = option.removeprefix("--").removeprefix("no-").replace("-", "_")
        if not option.startswith("--") or name in known:
            continue
        place = _place(name)
        meant = f"--{place}" if place and place.split()[0] in known else likely(name, known)
        rule = f"{PROGRAM}: option must be one of coopenv {arguments[0]} --help, got {option}"
        if meant is None:
            return f"{rule}; look there"
        meant = meant if meant.startswith("--") else f"--{meant.replace('_', '-')}"
        return f"{rule}; did you mean {meant}?"
    return None


def _place(name: str) -> str | None:
    """How to write a number of body or scene as an option: ``body mass=...``."""
    group, dot, entry = name.partition(".")
    if dot:
        return f"{group} {entry}=..."
    for group, kind in (("body", Body), ("scene", Scene)):
        if name in {entry.name for entry in fields(kind)}:
            return f"{group} {name}=..."
    return None


def _options(kind: type) -> Iterator[str]:
    """Names of the options of a command, those of its parts too."""
    types = get_type_hints(kind)
    for entry in fields(kind):
        if is_dataclass(types[entry.name]):
            yield from _options(types[entry.name])  # pyright: ignore[reportArgumentType]
        else:
            yield entry.name
