"""The crew: threads of this process that take parts of what `spread` puts on its board."""

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock, Thread, local

from coopenv.compiled.kinds import compiled
from coopenv.compiled.parallel.board import AWAKE, CLOSED, MOST_PARTS, add, new_board, read, write
from coopenv.compiled.parallel.spread import take_part

_PATIENCE = 200_000  # looks at an empty board before a thread sleeps


class Crew:
    """Helpers of one board; they sleep where there was no work for a while.

    Parameters
    ----------
    helpers
        How many threads; those who have work for them work too.

    Attributes
    ----------
    board
        Address of the board, 0 if there are no helpers.
    """

    def __init__(self, helpers: int):
        self._board = new_board()
        self.helpers = helpers
        self.board = self._board.ctypes.data if helpers else 0
        self._gates = [Lock() for _ in range(helpers)]
        for gate in self._gates:
            gate.acquire()
            Thread(target=self._help, args=(gate,), name="coopenv", daemon=True).start()

    @property
    def awake(self) -> int:
        """How many helpers look for work now."""
        return int(self._board[AWAKE])

    def wake(self) -> None:
        """Let all helpers look for work; at most a microsecond where they do."""
        if self._board[AWAKE] < self.helpers:
            for gate in self._gates:
                if gate.locked():
                    try:
                        gate.release()
                    except RuntimeError:  # another thread was quicker
                        continue

    def close(self) -> None:
        """Let all helpers end, before what they run goes."""
        write_closed(self.board)
        self.wake()

    def _help(self, gate: Lock) -> None:
        while not self._board[CLOSED]:
            gate.acquire()
            serve(self.board, _PATIENCE)


@compiled
def serve(board, patience):
    """Take parts until ``patience`` looks found none."""
    add(board, AWAKE, 1)
    looks = 0
    while looks < patience and read(board, CLOSED) == 0:
        looks = 0 if take_part(board, False) else looks + 1
    add(board, AWAKE, -1)


@compiled
def write_closed(board):
    """Tell all who serve that the board is closed."""
    if board != 0:
        write(board, CLOSED, 1)


@cache
def crew() -> Crew:
    """The helpers of this process, one for each core but one."""
    made = Crew(max(0, cores() - 1))
    atexit.register(made.close)
    return made


class _Sharing(local):
    """How many threads what a thread calls now may use."""

    threads = 1


_now = _Sharing()


@contextmanager
def shared(threads: int) -> Iterator[None]:
    """Let kernels that are called within use up to ``threads``, the caller's own among them."""
    before, _now.threads = _now.threads, threads
    if threads > 1:
        crew().wake()
    try:
        yield
    finally:
        _now.threads = before


def sharing(count: int) -> tuple[int, int]:
    """Board and number of parts for `spread`, where ``count`` parts are as many as make sense."""
    threads = _now.threads
    if threads == 1 or count < 2:
        return 0, 1
    return crew().board, min(count, MOST_PARTS if threads > crew().helpers else threads)


def cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


if hasattr(os, "register_at_fork"):  # threads do not survive a fork: a child makes its own
    os.register_at_fork(after_in_child=crew.cache_clear)
