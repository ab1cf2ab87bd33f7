"""Suites of the benchmark, by their names."""

from collections.abc import Sequence

from coopenv.errors import UnknownName

from ..scenario import Suite
from .bodies import BODIES
from .haptics import HAPTICS
from .partners import PARTNERS
from .team import TEAM

__all__ = ["SUITES", "find_suites"]

SUITES: dict[str, Suite] = {suite.name: suite for suite in (TEAM, PARTNERS, BODIES, HAPTICS)}


def find_suites(names: Sequence[str] = ()) -> tuple[Suite, ...]:
    """The suites of these names, each once; all without one.

    Raises
    ------
    UnknownName
        If there is none of a name.
    """
    for name in names:
        if name not in SUITES:
            raise UnknownName("suite", name, SUITES)
    return tuple(SUITES[name] for name in dict.fromkeys(names or SUITES))
