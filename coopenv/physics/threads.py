"""Threads that call a core: one at a time."""

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

from coopenv.errors import CoreInUse

Given = ParamSpec("Given")
Result = TypeVar("Result")


def one_thread_at_a_time(
    method: Callable[Concatenate[Any, Given], Result],
) -> Callable[Concatenate[Any, Given], Result]:
    """Refuse a call of ``method`` while another thread is in one with the same ``self.turn``.

    That is a `threading.RLock`: methods may call each other, and what Ctrl-C leaves locked is
    open to the thread that was interrupted.

    Raises
    ------
    CoreInUse
        From what is returned, if another thread has the turn.
    """

    @wraps(method)
    def alone(self: Any, *args: Given.args, **keywords: Given.kwargs) -> Result:
        turn = self.turn
        if not turn.acquire(False):
            raise in_use()
        try:
            return method(self, *args, **keywords)
        finally:
            turn.release()

    return alone


def in_use() -> CoreInUse:
    """What is raised where another thread has the turn."""
    return CoreInUse(
        "a core must be stepped and reset by one thread at a time, got a second one; make one for "
        "each thread"
    )
