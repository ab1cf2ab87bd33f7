"""SIGTERM and Ctrl-C: interruptions that no destructor swallows.

SIGTERM is what Slurm, docker and init send before they kill.
"""

import gc
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import monotonic, sleep
from types import FrameType

TERMINATED = 128 + signal.SIGTERM  # exit code, as shells count
SOON = 0.01  # [s] until a signal comes again that found a destructor at work
SAME = 1.0  # [s] after a signal in which others count as the same: timeout(1) sends two at once

Handler = Callable[[int, FrameType | None], None]


@dataclass(slots=True)
class Termination:
    """Whether the process was told to end, by SIGTERM or by Ctrl-C."""

    since: float | None = None  # of the monotonic clock [s]; when SIGTERM came
    asked: bool = False  # by Ctrl-C

    @property
    def is_told(self) -> bool:
        """Whether either came."""
        return self.asked or self.since is not None

    def ask(self, number: int, frame: FrameType | None) -> None:
        """Interrupt what is done, as Python does at Ctrl-C."""
        self.asked = True
        signal.default_int_handler(number, frame)

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
    """Let SIGTERM raise `KeyboardInterrupt`; after the block signals do what they did before.

    Ctrl-C raises it too, as ever, but like SIGTERM not in a destructor. Only the main thread may
    say what signals do, and one that the process was started to ignore stays ignored.
    """
    told = Termination()
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    handlers: dict[signal.Signals, _OutsideDestructors] = {}
    if threading.current_thread() is threading.main_thread():
        if before[signal.SIGTERM] not in (signal.SIG_IGN, None):  # None: set by no Python code
            handlers[signal.SIGTERM] = _OutsideDestructors(told.handle)
        if before[signal.SIGINT] is signal.default_int_handler:
            handlers[signal.SIGINT] = _OutsideDestructors(told.ask)
    for number, handler in handlers.items():
        signal.signal(number, handler)
    try:
        yield told
    finally:
        for number, handler in handlers.items():
            handler.waits = False
            signal.signal(number, before[number])


@dataclass(slots=True)
class _OutsideDestructors:
    """A handler that waits while a destructor runs, in which Python ignores what is raised.

    There are no locks in it, as signals interrupt it too.
    """

    handler: Handler
    waits: bool = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        if not _is_in_destructor(frame):
            self.waits = False
            self.handler(number, frame)
        elif not self.waits:
            self.waits = True
            threading.Thread(target=self._insist, args=(number,), daemon=True).start()

    def _insist(self, number: int) -> None:
        """Send the signal again until it is handled: one that comes just before a sleep waits."""
        sleep(SOON)
        while self.waits:
            _send(number)
            sleep(SOON)


def _send(number: int) -> None:
    """Send this process a signal that wakes its main thread, which may sleep."""
    main = threading.main_thread().ident
    if main is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main, number)
    else:
        signal.raise_signal(number)


def _is_in_destructor(frame: FrameType | None) -> bool:
    """Whether a ``__del__`` or a callback, of a weak reference, pymunk or ``gc``, is at work."""
    of_gc = [getattr(one, "__code__", None) for one in gc.callbacks]
    while frame is not None:
        name, module = frame.f_code.co_name, str(frame.f_globals.get("__name__"))
        if frame.f_code in of_gc or name == "__del__" or module in ("weakref", "_weakrefset"):
            return True
        if name.startswith("free") and module.partition(".")[0] == "pymunk":
            return True
        frame = frame.f_back
    return False
