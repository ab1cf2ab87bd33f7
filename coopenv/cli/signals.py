"""SIGTERM as an interruption: what Slurm, docker and init send before they kill."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic
from types import FrameType

TERMINATED = 128 + signal.SIGTERM  # exit code, as shells count
SAME = 1.0  # [s] after a signal in which others count as the same: timeout(1) sends two at once


@dataclass(slots=True)
class Termination:
    """Whether the process was told to end."""

    since: float | None = None  # of the monotonic clock [s]

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Interrupt what is done as Ctrl-C would; a later signal ends the process at once."""
        now = monotonic()
        if self.since is None:
            self.since = now
            raise KeyboardInterrupt("terminated")
        if now - self.since > SAME:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)


@contextmanager
def interrupted_by_termination() -> Iterator[Termination]:
    """Let SIGTERM raise `KeyboardInterrupt`; after the block it does what it did before.

    Only the main thread may say what signals do, and one that the process was started to ignore
    stays ignored: then nothing changes.
    """
    told = Termination()
    before = signal.getsignal(signal.SIGTERM)
    mine = threading.current_thread() is threading.main_thread()
    if not mine or before in (signal.SIG_IGN, None):  # None: set by no Python code
        yield told
        return
    signal.signal(signal.SIGTERM, told.handle)
    try:
        yield told
    finally:
        signal.signal(signal.SIGTERM, before)
