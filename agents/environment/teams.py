"""Sizes of the teams that one policy learns in side by side, and the environment of each."""

from collections.abc import Sequence
from typing import Any

from coopenv.arrays import whole
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.observation import Entry
from coopenv.observation.observation import find_block

from .overrides import with_team

OF_ANY_TEAM = ("near_goal", "others_wrench", "place")
"""Blocks that a policy of any team sees beside those that it has of its environment."""
REMEDY = "others_wrench and place say of all others together what a policy of any team needs"


def read_teams(given: Any, *, control: str, num_worlds: int) -> tuple[int, ...]:
    """Sizes of teams, none or different ones.

    Parameters
    ----------
    given
        A sequence of numbers of agents.
    control
        Of the run.
    num_worlds
        In all; every size has at least one.

    Raises
    ------
    InvalidInput
        If it breaks a rule.
    """
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise InvalidInput(f"teams must be a list of numbers of agents, got {given!r}; 2 4 is one")
    sizes = tuple(whole(each, "teams", at_least=1, at_most=1000) for each in given)
    if len(set(sizes)) < len(sizes):
        raise InvalidInput(f"teams must be different sizes, got {given!r}; leave one out")
    if sizes and control != "shared":
        raise InvalidInput(
            f"control must be 'shared' for teams of several sizes, got {control!r}; a policy that "
            "every agent runs by itself is the only one that fits them all (--control shared)"
        )
    if len(sizes) > num_worlds:
        raise InvalidInput(
            f"num_worlds must be at least one for each size of teams, got {num_worlds} for "
            f"{given!r}; give more worlds"
        )
    return sizes


def team_configs(config: TransportConfig, teams: Sequence[int]) -> tuple[TransportConfig, ...]:
    """The environment of each size: ``config`` with another team; ``config`` alone without any.

    Raises
    ------
    InvalidInput
        If its body is none for any team, or an observation block's size grows with the team.
    """
    if not teams:
        return (config,)
    made = tuple(with_team(config, size) for size in teams)
    growing = sorted(_growing(config.observe))
    if len(teams) > 1 and growing:
        raise InvalidInput(
            "observe must hold blocks of one size for teams of several, got "
            f"{', '.join(growing)}, with numbers about each other agent; leave them out: {REMEDY}"
        )
    return made


def worlds_of(num_worlds: int, teams: Sequence[int]) -> list[int]:
    """How many of the worlds each size has: as many, the first ones one more where some remain."""
    each, rest = divmod(num_worlds, len(teams))
    return [each + (number < rest) for number in range(len(teams))]


def seen_in_any_team(config: TransportConfig, also: Sequence[str] = ()) -> tuple[str, ...] | None:
    """Names of its blocks whose size does not grow with the team, of ``also`` and `OF_ANY_TEAM`.

    ``None`` where it has blocks that no name stands for: sensors, or blocks of the user's own.
    """
    own = {block.name: block for block in config.task.blocks}
    if not all(isinstance(entry, str) or entry in own.values() for entry in config.observe):
        return None
    growing = _growing(config.observe)
    kept = [name for name in map(_name, config.observe) if name not in growing]
    return tuple(dict.fromkeys((*kept, *also, *OF_ANY_TEAM)))


def _growing(observe: Sequence[Entry]) -> set[str]:
    """Names of the blocks that have more features in a larger team."""
    blocks = map(find_block, observe)
    return {block.name for block in blocks if block.width(2) != block.width(3)}


def _name(entry: Entry) -> str:
    return find_block(entry).name
