"""A fork server for commands: a process that has coopenv imported and forks a child for each.

A child is the program ``coopenv`` from its first line on, without the seconds of its imports: it
has its own folder, its outputs go to files, and it ends as a process does, so that it can be killed
at any moment. The process that forks is in `forking`.

Both ends talk in lines of JSON: a `Task` in, the child's number out, and its exit code once it has
ended.
"""

import atexit
import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from math import inf
from pathlib import Path
from select import select
from typing import IO, Any

from benchmarks.soak.commands import faults

ROOT = Path(__file__).parents[3]
ALONE = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
OUT, ERR = "stdout.txt", "stderr.txt"
LONGEST = 300.0  # [s] that a command may take


@dataclass(frozen=True, kw_only=True)
class Task:
    """What a child does."""

    folder: str
    """Where it runs, and leaves what it prints."""
    arguments: tuple[str, ...]
    """Of ``coopenv``."""
    module: str = ""
    """In that folder, which is imported instead."""
    fault: tuple[str, int, int] | None = None
    """What is made to fail: kind, number of the call, number of the error (`faults`)."""


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a child ended, and what it said."""

    code: int
    """Exit code, or minus the number of the signal."""
    out: str
    err: str
    arguments: tuple[str, ...]
    seconds: float
    """Of processor time."""
    struck: bool
    """Whether a fault struck."""

    def __str__(self) -> str:
        return f"{' '.join(self.arguments)}: exit code {self.code}\n{self.err[-2000:]}"


class Child:
    """A command that runs."""

    def __init__(self, task: Task, pid: int, replies: IO[str]):
        self._task, self._replies = task, replies
        self.pid = pid

    def kill(self, number: signal.Signals) -> None:
        """Send a signal, unless it has ended."""
        with suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def seconds(self) -> float:
        """Processor time that it has used; infinite once it has ended."""
        try:
            return time.clock_gettime(~self.pid << 3 | 2)  # Linux: the clock of a process
        except OSError:
            return inf

    def wait(self) -> Ended:
        """Wait until it has ended.

        Raises
        ------
        AssertionError
            If it hangs; it is killed.
        """
        if not select([self._replies], [], [], LONGEST)[0]:
            self.kill(signal.SIGABRT)  # it then says where it is
            _line(self._replies)
            where = (Path(self._task.folder) / ERR).read_text(errors="replace")[-2000:]
            raise AssertionError(
                f"{' '.join(self._task.arguments)} hangs for {LONGEST:g} s\n{where}"
            )
        ended = _line(self._replies)
        folder = Path(self._task.folder)
        out, err = ((folder / name).read_text(errors="replace") for name in (OUT, ERR))
        struck = (folder / faults.MARK).exists()
        for name in (OUT, ERR, faults.MARK):
            (folder / name).unlink(missing_ok=True)
        return Ended(
            code=int(ended["code"]),
            seconds=ended["seconds"],
            struck=struck,
            out=out,
            err=err,
            arguments=self._task.arguments,
        )


class Server:
    """The process that forks; it ends with this one."""

    def __init__(self) -> None:
        environment = {**os.environ, **dict.fromkeys(ALONE, "1"), "SDL_VIDEODRIVER": "dummy"}
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, (str(ROOT), *_paths())))
        self._process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.soak.commands.forking"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
            start_new_session=True,  # Ctrl-C is for those who ask, not for this
        )
        atexit.register(self.close)

    def start(self, task: Task) -> Child:
        """Begin a command; one at a time."""
        asked, replies = self._process.stdin, self._process.stdout
        assert asked is not None
        assert replies is not None
        for name in (OUT, ERR):  # also where it is killed before it opens them
            (Path(task.folder) / name).touch()
        print(json.dumps(asdict(task)), file=asked, flush=True)
        return Child(task, int(_line(replies)["pid"]), replies)

    def run(self, task: Task) -> Ended:
        """Run a command to its end."""
        return self.start(task).wait()

    def close(self) -> None:
        """End the process, which reads to the end of its input."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


@cache
def server() -> Server:
    """The one of this process."""
    return Server()


def is_sentence(said: str) -> bool:
    """Whether it is the one line with which the program refuses something."""
    return said.startswith("coopenv: ") and len(said.splitlines()) == 1


def _paths() -> list[str]:
    given = os.environ.get("PYTHONPATH")
    return [given] if given else []


def _line(replies: IO[str]) -> dict[str, Any]:
    line = replies.readline()
    if not line:
        server.cache_clear()  # the next trial has another
        raise RuntimeError("the server of commands has ended")
    return json.loads(line)
