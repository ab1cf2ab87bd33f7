"""Options of commands: those that all have, and marks of fields that make options of them."""

from coopenv.options.common import ALONE, POSITIONAL, Common

__all__ = ["ALONE", "POSITIONAL", "Common"]
