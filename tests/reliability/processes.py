"""Forked children that are watched: what hangs or crashes there is told here."""

import os
import signal
import time
import traceback
from collections.abc import Callable

import pytest

needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")


def in_fork(work: Callable[[], object], seconds: float = 120.0) -> None:
    """Call ``work`` in a forked child; raises if it raises there, crashes or takes too long."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            work()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    code = _exit_code(child, seconds)
    if code is None:
        raise AssertionError(f"the child hangs: no end after {seconds:g} s")
    if code < 0:
        raise AssertionError(f"the child died of {signal.Signals(-code).name}")
    assert code == 0, "the child raised; see its traceback in what it printed"


def _exit_code(child: int, seconds: float) -> int | None:
    """The exit code of a child, negative for a signal; None, and killed, if it takes too long."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None
