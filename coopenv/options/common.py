"""Options that every command has, and marks of fields that make options of them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

POSITIONAL: Any = None
ALONE: Any = None
try:
    import tyro
except ImportError:  # asked for where the command line is read
    pass
else:
    POSITIONAL = tyro.conf.Positional  # told by its place
    ALONE = tyro.conf.FlagCreatePairsOff  # a flag that a file may also hold: none undoes it


@dataclass(frozen=True, slots=True, kw_only=True)
class Common:
    """The same for every command."""

    json: bool = False
    """Print one JSON document, whose keys docs/commands.md lists. What people read goes to standard
    error."""
    config: Path | None = None
    """.toml or .json file with options by their names; those that are given win."""
