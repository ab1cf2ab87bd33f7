"""Threads of a core: spaces that advance side by side, and one caller at a time."""

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

from coopenv.errors import CoreInUse

Given = ParamSpec("Given")
Result = TypeVar("Result")


def side_by_side(work: Callable[[int], None], count: int) -> None:
    """Call ``work`` with 0 … ``count`` − 1, in threads where there are cores for them.

    Returns, or raises what one of the calls raised, when none is at work any more: what they work
    on may be used again at once, also after Ctrl-C.
    """
    if (os.cpu_count() or 1) < 2:
        for number in range(count):
            work(number)
        return
    futures: list[Future[None]] = []
    try:
        futures.extend(_threads().submit(work, number) for number in range(count))
        wait(futures)
    finally:
        wait(futures)
    for future in futures:
        future.result()


@cache
def _threads() -> ThreadPoolExecutor:
    """The threads of this process, which all cores share."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="coopenv")


if hasattr(os, "register_at_fork"):  # threads do not survive a fork: a child makes its own
    os.register_at_fork(after_in_child=_threads.cache_clear)


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
