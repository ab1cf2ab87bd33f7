"""The crew: threads of this process that take parts of what `spread` puts on its board."""

import atexit
import os
from functools import cache
from threading import Lock, Thread, local

import numpy as np

from coopenv.compiled.kinds import compiled
from coopenv.compiled.parallel.board import (
    AWAKE,
    BED,
    CLOSED,
    LINE,
    MOST_PARTS,
    NAP,
    add,
    exchanged,
    new_board,
    read,
    write,
)
from coopenv.compiled.parallel.gates import (
    ACQUIRE,
    ACQUIRE_TIMED,
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
    most
        How many threads there may be; they are started when they are first wanted. Those who have
        work for them work too.

    Attributes
    ----------
    board
        Address of the board, 0 if there are no helpers.
    """

    def __init__(self, most: int):
        self._board, self.most = new_board(), most
        self.board = self._board.ctypes.data if most else 0
        self._functions, self._bed = functions(), new_gate()
        self._board[NAP], self._board[BED] = self._functions[ACQUIRE_TIMED], self._bed
        self._gates = np.array([new_gate() for _ in range(most)], dtype=np.int64)
        self._sleeps = np.zeros(most * LINE, dtype=np.int64)
        self._board[CLOSED] = 1  # what is called here returns at once, and is compiled
        if most:
            self._wake(1)
            self._help(0)
        self._sleeps[:], self._board[CLOSED] = 0, 0
        self._started, self._starting = 0, Lock()

    @property
    def awake(self) -> int:
        """How many helpers look for work now."""
        return int(self._board[AWAKE])

    def wake(self, helpers: int) -> None:
        """Let so many helpers look for work; at most a microsecond where they do."""
        helpers = min(helpers, self.most)
        if self._started < helpers:
            self._start(helpers)
        if self._board[AWAKE] < helpers:
            self._wake(helpers)

    def close(self) -> None:
        """Let all helpers end, before what they run goes."""
        self._board[CLOSED] = 1
        self._wake(self.most)

    def _start(self, helpers: int) -> None:
        """Start as many as are missing; where the system gives no more threads, fewer do."""
        with self._starting:
            for number in range(self._started, helpers):
                thread = Thread(target=self._help, args=(number,), name="coopenv", daemon=True)
                try:
                    thread.start()
                except RuntimeError:
                    self.most = number
                    return
                self._started = number + 1

    def _wake(self, helpers: int) -> None:
        _open(self._functions[RELEASE], self._gates[:helpers], self._sleeps.ctypes.data)

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
def _open(release, gates, sleeps):
    """Open the gates of all who sleep, each once."""
    for number in range(len(gates)):
        if exchanged(sleeps, LINE * number, 1, 0):
            open_gate(release, gates[number])


_making = Lock()


def crew() -> Crew:
    """The helpers of this process, one for each core but one."""
    with _making:
        return _made()


@cache
def _made() -> Crew:
    made = Crew(max(0, cores() - 1))
    atexit.register(made.close)
    return made


class _Sharing(local):
    """How many threads what a thread calls now may use."""

    threads = 1


_now = _Sharing()


class shared:  # noqa: N801 - a context manager, in a step of some microseconds
    """Let kernels that are called within use up to ``threads``, the caller's own among them.

    No more than there are cores for this process at the moment.
    """

    __slots__ = ("_before", "_threads")

    def __init__(self, threads: int):
        self._threads, self._before = threads, 1

    def __enter__(self) -> None:
        threads = self._threads
        if threads > 1:
            threads = min(threads, cores())
            if threads > 1:
                crew().wake(threads - 1)
        self._before, _now.threads = _now.threads, threads

    def __exit__(self, *_: object) -> None:
        _now.threads = self._before


def sharing(count: int) -> tuple[int, int]:
    """Board and number of parts for `spread`, where ``count`` parts are as many as make sense."""
    if count < 2:
        return 0, 1
    threads = _now.threads
    if threads == 1:
        return 0, 1
    found = crew()
    return found.board, min(count, MOST_PARTS if threads > found.most else threads)


def sharing_rows(count: int) -> tuple[int, int]:
    """`sharing` for kernels that do little with each of ``count`` rows."""
    return sharing(count // ROWS) if count >= 2 * ROWS else (0, 1)


def cores() -> int:
    """How many this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _forget() -> None:
    global _making
    _making = Lock()
    _made.cache_clear()


if hasattr(os, "register_at_fork"):  # threads do not survive a fork: a child makes its own
    os.register_at_fork(after_in_child=_forget)
