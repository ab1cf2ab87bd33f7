"""Reading of the command line: which command, and its options."""

import io
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from typing import Annotated, Any, Union

from coopenv.cli.options import files
from coopenv.cli.options.help import Caught, page_of_command, page_of_program
from coopenv.cli.options.meant import meant
from coopenv.errors import CoopenvError, MissingExtra

PROGRAM = "coopenv"
WITHOUT_TRAINING = ("decompose", "inspect", "show")  # what they need is in another extra


def read(
    arguments: Sequence[str],
    commands: Mapping[str, type],
    groups: Mapping[str, Sequence[str]] | None = None,
) -> Any:
    """The command that arguments name, with their options; help if there are none.

    Parameters
    ----------
    arguments
        Of the command line.
    commands
        Name → class.
    groups
        Title → names of commands, for the help of the program; all under one by default.

    Raises
    ------
    CoopenvError
        If a value breaks its rule.
    MissingExtra
        If the library that reads options is not installed.
    SystemExit
        After help, with 0, and after an explanation of what makes no sense, with 2.
    """
    if not arguments or arguments[0] in ("--help", "-h"):
        print(page_of_program(PROGRAM, commands, groups or {"commands": tuple(commands)}))
        raise SystemExit(0)
    tyro = _tyro(arguments)
    default = files.before(arguments, commands, tyro.MISSING)
    explained, told = io.StringIO(), Caught(sys.stdout)
    try:
        with redirect_stderr(explained), redirect_stdout(told):
            command = _parsed(tyro, arguments, commands, default)
        return command if default is None else files.over(command, default)
    except SystemExit as stopped:
        for error in _causes(stopped):
            if isinstance(error, CoopenvError):  # in our words, without those of the reader
                raise error from None
        if told.getvalue():
            print(page_of_command(told.getvalue(), arguments, commands))
        said = meant(arguments, commands, PROGRAM) or explained.getvalue().rstrip()
        if said and stopped.code:
            print(said, file=sys.stderr)
        raise


def completion(shell: str, commands: Mapping[str, type]) -> str:
    """Script of a shell that completes commands, options and their choices."""
    tyro, script = _tyro([]), io.StringIO()
    try:
        with redirect_stdout(script):
            _parsed(tyro, ["--tyro-print-completion", shell], commands, None)
    except SystemExit:
        return script.getvalue()
    raise AssertionError("no script was printed")


def _parsed(tyro: Any, arguments: Sequence[str], commands: Mapping[str, type], default: Any) -> Any:
    """What tyro makes of the arguments, over ``default`` where it is of their command."""
    kinds: list[Any] = []
    for name, kind in commands.items():
        own = {"default": default} if type(default) is kind else {}
        kinds.append(Annotated[kind, tyro.conf.subcommand(name, **own)])
    return tyro.cli(
        Union[tuple(kinds)],  # pyright: ignore[reportArgumentType]  # noqa: UP007
        prog=PROGRAM,
        args=list(arguments),
        config=(
            tyro.conf.OmitArgPrefixes,
            tyro.conf.OmitSubcommandPrefixes,
            tyro.conf.PositionalRequiredArgs,
        ),
    )


def _tyro(arguments: Sequence[str]) -> Any:
    try:
        import tyro
    except ImportError as error:
        extra = "analysis" if {*arguments[:1]} & {*WITHOUT_TRAINING} else "train"
        raise MissingExtra("the command line", extra) from error
    return tyro


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """An error, and those in whose handling it was raised."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__
