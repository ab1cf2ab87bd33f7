"""Registry of the campaigns of the soak test."""

from collections.abc import Iterable
from importlib import import_module
from typing import cast

from benchmarks.soak import actions, damaged, disks, kills, memory, processes, wrenches
from benchmarks.soak.frame.campaign import Campaign
from coopenv.errors import UnknownName

CAMPAIGNS: tuple[Campaign, ...] = (
    actions,
    wrenches,
    kills,
    disks,
    damaged,
    memory,
    processes,
)


def chosen(only: str | None = None, also: Iterable[str] = ()) -> list[Campaign]:
    """The campaigns to run: all, or the one of that name.

    Parameters
    ----------
    only
        Name of a campaign.
    also
        Names of modules outside this folder that are campaigns too.

    Raises
    ------
    UnknownName
        If there is no campaign of that name.
    """
    others = (cast(Campaign, import_module(name)) for name in also)
    known = {each.NAME: each for each in (*CAMPAIGNS, *others)}
    if only is None:
        return list(known.values())
    if only not in known:
        raise UnknownName("only", only, known)
    return [known[only]]
