"""The command line: ``coopenv <command> --help``, or ``python -m coopenv``."""

from coopenv.cli.policies import find_policy
from coopenv.cli.program import COMMANDS, Command, main

__all__ = ["COMMANDS", "Command", "find_policy", "main"]
