"""The command line: ``coopenv <command> --help``, or ``python -m coopenv``."""

from coopenv.missing import told

try:
    from coopenv.cli.policies import find_policy
    from coopenv.cli.program import COMMANDS, Command, main
except ModuleNotFoundError as error:
    raise told(error, "the command line") from error

__all__ = ["COMMANDS", "Command", "find_policy", "main"]
