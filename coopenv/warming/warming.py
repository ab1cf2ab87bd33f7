"""Compiling everything, with a report of what came of it."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from numba.core import config, event

from coopenv.compiled.checks import is_finite
from coopenv.errors import CoopenvError
from coopenv.warming import decompositions, environments


class Warmed(NamedTuple):
    """What was compiled."""

    kernels: int  # functions that had to be compiled, helpers included
    seconds: float  # [s] of processor time
    cache: str | None  # folder of the compiled kernels; None where none can be written


def warmup(report: Callable[[int, int, str], None] | None = None) -> Warmed:
    """Compile everything for this processor, so that no later process has to.

    All ids with all kinds of actions, hands, actuators, gravity, partners, observations and
    rewards, and all methods of decomposition. What is in the cache already is not compiled again.
    It takes minutes with an empty cache. Meant for the image of a container, and for machines whose
    first answer must not be late (`docs/install.md`).

    Parameters
    ----------
    report
        Told before each piece of work: its number from 0 on, how many there are, what it is.

    Returns
    -------
    How many kernels were compiled, in which time, and where they are kept.
    """
    counter, began = _Counter(), time.process_time()
    with event.install_listener("numba:compile", counter):
        works = [*decompositions.works(), *environments.works()]
        for number, (name, work) in enumerate(works):
            if report is not None:
                report(number, len(works), name)
            try:
                work()
            except CoopenvError:  # a combination that there is not
                continue
    return Warmed(counter.count, time.process_time() - began, _folder())


def _folder() -> str | None:
    """The folder that all kernels lie under, each beside its source or all of them elsewhere."""
    one = is_finite.stats.cache_path
    if one is None:
        return None
    folders = [vars(config)["CACHE_DIR"], str(Path(__file__).parents[1])]
    return next(
        (at for at in folders if at and Path(one).is_relative_to(at)), str(Path(one).parent)
    )


class _Counter(event.Listener):
    def __init__(self):
        self.count = 0

    def on_start(self, event: Any) -> None:
        """Count a compilation."""
        self.count += 1

    def on_end(self, event: Any) -> None:
        """Nothing is left to do."""
