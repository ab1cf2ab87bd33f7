"""Environments by name, and numbers of them that are changed: what options and files say."""

from .choice import EnvironmentChoice, find_config
from .overrides import GROUPS, changed, entries_of, values_of, with_team

__all__ = [
    "GROUPS",
    "EnvironmentChoice",
    "changed",
    "entries_of",
    "find_config",
    "values_of",
    "with_team",
]
