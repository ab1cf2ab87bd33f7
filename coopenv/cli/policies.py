"""Policies by their names on the command line, and what a table calls them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.files import reading

if TYPE_CHECKING:
    from coopenv.agents.policy import Policy


def find_policy(name: str, config: TransportConfig, *, trust: bool = False) -> "Policy":
    """The policy of that name for an environment: a kind of scripted one, or a trained file.

    ``trust`` as of `coopenv.agents.sb3.SB3Policy.load`.
    """
    from coopenv.agents.controllers import RandomPolicy, find_controller

    kind, _, allocation = name.partition(":")
    if kind == "scripted":
        return find_controller(config, **({"method": allocation} if allocation else {}))
    if name == "random":
        return RandomPolicy(config)
    from coopenv.agents.sb3 import SB3Policy

    with reading(name):
        if not Path(name).is_file():
            inside = Path(name) / "policy.zip"
            remedy = (
                f"give {str(inside)!r}" if inside.is_file() else "coopenv train writes such a file"
            )
            raise InvalidInput(
                f"policy must be random, scripted or the file of a trained policy, got {name!r}; "
                f"{remedy}"
            )
        return SB3Policy.load(name, trust=trust)


def labels(names: Sequence[str]) -> list[str]:
    """What to call policies in a table: the folder of a ``policy.zip``, else the name itself."""
    short = [Path(name).parent.name if Path(name).name == "policy.zip" else name for name in names]
    return [
        label if label and short.count(label) == 1 else name
        for label, name in zip(short, names, strict=True)
    ]
