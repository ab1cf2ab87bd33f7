"""The crew: threads of this process that take parts of what `spread` puts on its board."""

import atexit
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Thread, local

import numpy as np

from coopenv.compiled.kinds import compiled
from coopenv.compiled.parallel.board import (
    AWAKE,
    CLOSED,
    LINE,
    MOST_PARTS,
    add,
    exchanged,
    new_board,
    read,
    write,
)
from coopenv.compiled.parallel.gates import (
    ACQUIRE,
    RELEASE,
    functions,
    new_gate,
    open_gate,
    pass_through,
)
from coopenv.compiled.parallel.spread import take_part

ROWS = 128  # of a batch in a part, which take longer than another thread does to take them
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
        self._board, self.helpers = new_board(), helpers
        self.board = self._board.ctypes.data if helpers else 0
        self._functions = functions()
        self._gates = np.array([new_gate() for _ in range(helpers)], dtype=np.int64)
        self._sleeps = np.zeros(helpers * LINE, dtype=np.int64)
        for number in range(helpers):
            Thread(target=self._help, args=(number,), name="coopenv", daemon=True).start()

    @property
    def awake(self) -> int:
        """How many helpers look for work now."""
        return int(self._board[AWAKE])

    def wake(self) -> None:
        """Let all helpers look for work; at most a microsecond where they do."""
        if self._board[AWAKE] < self.helpers:
            _wake(self._functions[RELEASE], self._gates, self._sleeps.ctypes.data)

    def close(self) -> None:
        """Let all helpers end, before what they run goes."""
        if self.helpers:
            _close(self.board)
            self.wake()

    def _help(self, number: int) -> None:
        sleeps = self._sleeps[LINE * number :].ctypes.data
        _serve(self.board, self._functions[ACQUIRE], self._gates[number], sleeps, _PATIENCE)


@compiled
def _serve(board, acquire, gate, sleeps, patience):
    """Take parts until the board is closed; sleep where ``patience`` looks found none."""
    while read(board, CLOSED) == 0:
        add(board, AWAKE, 1)
        looks = 0
        while looks < patience and read(board, CLOSED) == 0:
            looks = 0 if take_part(board, False) else looks + 1
        add(board, AWAKE, -1)
        write(sleeps, 0, 1)
        if read(board, CLOSED) == 0:  # looked at after what `Crew.close` looks at was written
            pass_through(acquire, gate)


@compiled
def _wake(release, gates, sleeps):
    """Open the gates of all who sleep, each once."""
    for number in range(len(gates)):
        if exchanged(sleeps, LINE * number, 1, 0):
            open_gate(release, gates[number])


@compiled
def _close(board):
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


def sharing_rows(count: int) -> tuple[int, int]:
    """`sharing` for kernels that do little with each of ``count`` rows."""
    return sharing(count // ROWS)


def cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


if hasattr(os, "register_at_fork"):  # threads do not survive a fork: a child makes its own
    os.register_at_fork(after_in_child=crew.cache_clear)
