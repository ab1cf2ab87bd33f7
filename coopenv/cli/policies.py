"""Policies by their names on the command line, and what a table calls them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from coopenv.agents.pretrained.naming import is_name
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.files import reading

if TYPE_CHECKING:
    from coopenv.agents.policy import Policy


def find_policy(name: str, config: TransportConfig, *, trust: bool = False) -> "Policy":
    """The policy of that name for an environment: a kind of scripted one, or a trained one.

    ``trust`` as of `coopenv.agents.sb3.SB3Policy.load`.
    """
    from coopenv.agents.controllers import RandomPolicy, find_controller

    kind, _, allocation = name.partition(":")
    if kind == "scripted":
        return find_controller(config, **({"method": allocation} if allocation else {}))
    if name == "random":
        return RandomPolicy(config)
    from coopenv.agents.pretrained import read

    with reading(name):
        if not is_name(name) and not Path(name).is_file():
            inside = Path(name) / "policy.zip"
            remedy = (
                f"give {str(inside)!r}" if inside.is_file() else "coopenv train writes such a file"
            )
            raise InvalidInput(
                "policy must be random, scripted, pretrained or the file of a trained policy, got "
                f"{name!r}; {remedy}"
            )
        return read(name, trust=trust)


def labels(names: Sequence[str]) -> list[str]:
    """What to call policies in a table: the folder of a ``policy.zip``, else the name itself.

    Of the package's without what is before the colon.
    """
    short = [_short(name) for name in names]
    return [
        label if label and short.count(label) == 1 else name
        for label, name in zip(short, names, strict=True)
    ]


def _short(name: str) -> str:
    if is_name(name):
        return name.partition(":")[2]
    return Path(name).parent.name if Path(name).name == "policy.zip" else name
