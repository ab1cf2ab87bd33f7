"""What a campaign of the soak test is: a module with a name, a share of the time, and trials.

A trial is a function of its seed: it draws everything from it, so that a failure is met again by
its seed alone. A module may have its own ``TIMEOUT``, and a function ``warm_up`` that a worker
calls before its first trial.
"""

from pathlib import Path
from types import ModuleType
from typing import Protocol, cast

TIMEOUT = 600.0  # [s] a trial that has not ended by then hangs; a campaign may have its own TIMEOUT


class Campaign(Protocol):
    """A module of trials."""

    @property
    def NAME(self) -> str:  # noqa: N802 - a constant of the module
        """What it is called on the command line."""
        ...

    @property
    def SHARE(self) -> float:  # noqa: N802
        """Of the time, beside the shares of the others."""
        ...

    def trial(self, seed: int, folder: Path) -> dict[str, int]:
        """Try one thing; ``folder`` is empty and removed afterwards.

        Returns counts of what was tried, which are added up, such as ``{"steps": 102400}``. Raises
        an `AssertionError` that says what broke; any other exception counts as a failure too.
        """
        ...


def warm_up(campaign: Campaign) -> None:
    """Load what its trials import and compile at first use, which no growth of a worker is."""
    getattr(campaign, "warm_up", lambda: None)()


def timeout_of(campaign: Campaign) -> float:
    """Seconds after which a trial of it hangs."""
    return getattr(campaign, "TIMEOUT", TIMEOUT)


def module_of(campaign: Campaign) -> str:
    """Name of the module that it is."""
    return cast(ModuleType, campaign).__name__
