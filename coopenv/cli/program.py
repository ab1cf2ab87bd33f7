"""The program ``coopenv``: its commands, reading of their options, exit codes.

A command is a dataclass whose fields are its options and whose ``run`` does it; `COMMANDS` lists
them. What needs an extra is imported when it runs.
"""

import sys
from collections.abc import Sequence
from typing import Protocol

from coopenv.cli.evaluate import Evaluate
from coopenv.cli.study import Study
from coopenv.cli.train import Train
from coopenv.errors import CoopenvError, MissingExtra
from coopenv.logs.command import Decompose


class Command(Protocol):
    """What the command line can run."""

    def run(self) -> None:
        """Do it, printing for people and writing files for programs."""
        ...


COMMANDS: dict[str, type[Command]] = {
    "train": Train,
    "evaluate": Evaluate,
    "decompose": Decompose,
    "study": Study,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command that ``arguments`` (by default those of the process) name."""
    try:
        _read(arguments).run()
    except CoopenvError as error:
        print(f"coopenv: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as stop:
        print(f"coopenv: {str(stop) or 'interrupted'}", file=sys.stderr)
        return 130
    return 0


def _read(arguments: Sequence[str] | None) -> Command:
    """The command and its options; tyro prints help and stops where they make no sense."""
    try:
        import tyro
    except ImportError as error:
        wanted = list(sys.argv[1:] if arguments is None else arguments)[:1]
        extra = "analysis" if wanted == ["decompose"] else "train"
        raise MissingExtra("the command line", extra) from error
    return tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="coopenv",
        description="Learn to carry things together.",
        args=arguments,
        config=(
            tyro.conf.OmitArgPrefixes,
            tyro.conf.OmitSubcommandPrefixes,
            tyro.conf.PositionalRequiredArgs,
        ),
    )
