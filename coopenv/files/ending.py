"""What has to be undone before the process ends, if nothing else undid it first.

A signal interrupts between any two calls, also in a ``finally`` that was about to remove a file.
What waits in memory alone for its turn is lost then. So whoever makes a file that is not to stay
says first how to undo it.
"""

import atexit
import os
import sys
import threading
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from typing import NamedTuple


class _Due(NamedTuple):
    thread: int  # that said so
    undo: Callable[[], object]


_DUE: dict[Hashable, _Due] = {}
_LAST = -1000  # priority among what multiprocessing does as a process ends: after its own -100


def promise(key: Hashable, undo: Callable[[], object]) -> None:
    """Have something undone at the end of this process, unless `settle` is told before.

    A forked child has promised nothing of what its parent has.

    Parameters
    ----------
    key
        To settle it by.
    undo
        May raise `OSError`, which nobody hears. It is called again if a signal interrupts it.
    """
    _tell_multiprocessing()
    _DUE[key] = _Due(threading.get_ident(), undo)


def settle(key: Hashable) -> None:
    """Say that nothing is left to be undone."""
    _DUE.pop(key, None)


def is_due(key: Hashable) -> bool:
    """Whether it was promised and not yet settled."""
    return key in _DUE


@contextmanager
def nothing_left() -> Iterator[None]:
    """Undo after the block what this thread promised in it and did not settle."""
    before = set(_DUE)
    try:
        yield
    finally:
        me = threading.get_ident()
        _undo([key for key, due in _DUE.copy().items() if due.thread == me and key not in before])


def _undo(keys: list[Hashable]) -> None:
    """Newest first, as the blocks would have ended."""
    for key in reversed(keys):
        due = _DUE.get(key)
        if due is not None:
            with suppress(OSError):
                due.undo()
            settle(key)


@atexit.register
def _undo_all() -> None:
    _undo([*_DUE])


def _tell_multiprocessing() -> None:
    """Have its forked children undo too: they end without atexit, by finalizers of their own.

    Where nobody imported it there are none.
    """
    finalize = getattr(sys.modules.get("multiprocessing.util"), "Finalize", None)
    if finalize is not None:
        _tell(finalize)


@cache
def _tell(finalize: Callable[..., object]) -> None:
    """Once in a process: each child tells it anew, as it forgets its parent's finalizers."""
    finalize(None, _undo_all, exitpriority=_LAST)


def _forget() -> None:
    _DUE.clear()
    _tell.cache_clear()


if sys.platform != "win32":
    os.register_at_fork(after_in_child=_forget)
