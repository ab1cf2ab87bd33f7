"""Forked children of a process that has imported what tests need, but none of the code under test.

A child costs its own tests only, and not the seconds that torch and numba take to import.
"""

import contextlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

HEAVY = (
    *("numpy", "numba", "scipy.optimize", "scipy.stats", "clarabel", "pymunk"),
    *("gymnasium", "pettingzoo", "torch", "stable_baselines3", "sb3_contrib"),
    *("pandas", "pyarrow.parquet", "statsmodels.api", "matplotlib.pyplot", "rich.progress"),
    *("tyro", "hypothesis", "pytest", "coverage"),
)
UNDER_TEST = ("coopenv", "tests", "benchmarks", "examples")


def warm_up() -> None:
    """Import what is there of the packages that tests use."""
    for name in HEAVY:
        with contextlib.suppress(ImportError):
            import_module(name)


@dataclass(frozen=True)
class Ended:
    """How a child ended: with an exit code, by a signal, or because it took too long."""

    code: int | None
    signal: int | None
    cpu: float  # [s], with that of its own children


class Child:
    """A forked process in a tree of its own code."""

    def __init__(self, act: Callable[[], int], *, tree: Path, cache: Path, log: Path) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        self.begun = time.monotonic()
        self.pid = os.fork()
        if self.pid == 0:
            code = 70
            try:
                _enter(tree, cache, log)
                code = act()
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)

    def poll(self, wall: float) -> Ended | None:
        """How it ended; None while it runs. It is killed after ``wall`` seconds."""
        pid, status, used = os.wait4(self.pid, os.WNOHANG)
        if pid == 0:
            if time.monotonic() - self.begun < wall:
                return None
            self._kill()
            _, status, used = os.wait4(self.pid, 0)
            return Ended(None, signal.SIGALRM, used.ru_utime + used.ru_stime)
        self._kill()
        cpu = used.ru_utime + used.ru_stime
        if os.WIFSIGNALED(status):
            return Ended(None, os.WTERMSIG(status), cpu)
        return Ended(os.WEXITSTATUS(status), None, cpu)

    def wait(self, wall: float) -> Ended:
        """Wait until it ends, at most ``wall`` seconds."""
        try:
            while (ended := self.poll(wall)) is None:
                time.sleep(0.05)
        except BaseException:
            self._kill()
            raise
        return ended

    def _kill(self) -> None:
        """End it and what it has started."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)


def _enter(tree: Path, cache: Path, log: Path) -> None:
    """Make the tree the place that code is imported from, here and in processes of this one."""
    os.setpgid(0, 0)
    out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(out, 1)
    os.dup2(out, 2)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    here = {"", os.getcwd()}
    sys.path[:] = [str(tree), *(place for place in sys.path if place not in here)]
    os.chdir(tree)
    for name in [*sys.modules]:
        if name.partition(".")[0] in UNDER_TEST:
            del sys.modules[name]
    os.environ.update(
        PYTHONPATH=str(tree),
        NUMBA_CACHE_DIR=str(cache),
        SDL_VIDEODRIVER="dummy",
        OMP_NUM_THREADS="1",
    )
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(cache)
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(1)
