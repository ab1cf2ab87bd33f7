"""A fork server for commands: a process that has coopenv imported and forks a child for each.

A child is the program ``coopenv`` from its first line on, without the seconds of its imports: it
has its own folder, its outputs go to files, and it ends as a process does, so that it can be killed
at any moment. The server itself has one thread, which is what makes forking it sound.

Both ends talk in lines of JSON: a `Task` in, the child's number out, and its exit code once it has
ended.
"""

import atexit
import gc
import json
import os
import signal
import subprocess
import sys
import time
import traceback
from contextlib import redirect_stdout, suppress
from dataclasses import asdict, dataclass
from functools import cache
from importlib import import_module
from math import inf
from os import _exit as end_at_once
from pathlib import Path
from select import select
from tempfile import TemporaryDirectory
from typing import IO, Any, NoReturn

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
            self.kill(signal.SIGKILL)
            _line(self._replies)
            raise AssertionError(f"{' '.join(self._task.arguments)} hangs for {LONGEST:g} s")
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
            [sys.executable, "-m", __name__],
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


def _import_all() -> None:
    """Import what commands import when they run, so that no child has to."""
    import matplotlib.backends.backend_agg
    import pandas  # noqa: F401
    import pyarrow.parquet  # noqa: F401
    import statsmodels.formula.api  # noqa: F401
    import tensorboard.compat.tensorflow_stub  # noqa: F401
    import torch

    import coopenv.agents.record
    import coopenv.agents.studies.walker.turn
    import coopenv.agents.train
    import coopenv.cli
    import coopenv.logs.run  # noqa: F401

    torch.set_num_threads(1)
    matplotlib.use("agg")


WARM = (  # commands that load most kernels, fonts and the like
    "evaluate random scripted --horizon 2 --episodes 2",
    "evaluate random --env coopenv/WalkerTurn-v0 --horizon 2 --episodes 2",
    "study walker-turn --out turn",
)


def _warm_up() -> None:
    """Run commands in the server itself, so that children find their kernels loaded."""
    import torch

    from coopenv.cli import main

    torch.optim.Adam([torch.zeros(1, requires_grad=True)])  # imports a compiler
    with TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere:
        os.chdir(folder)
        with redirect_stdout(nowhere):
            for words in WARM:
                main(words.split())
        os.chdir(ROOT)
    others = _threads() - {"jemalloc_bg_thd"}  # of pyarrow's allocator, which stops it at a fork
    if len(others) > 1:
        raise RuntimeError(f"the server must have one thread to be forked, got {others}")


def _threads() -> set[str]:
    """Names and numbers of this process's threads."""
    return {path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")}


def _serve() -> None:
    """Fork a child for every task."""
    _import_all()
    _warm_up()
    gc.collect()
    gc.freeze()  # else each child looks through what was imported, and copies it by that
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    for line in iter(sys.stdin.readline, ""):
        task = Task(**json.loads(line))
        pid = os.fork()
        if not pid:
            replies.close()
            _become(task)
        print(json.dumps({"pid": pid}), file=replies, flush=True)
        _, status, used = os.wait4(pid, 0)
        code, seconds = os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime
        print(json.dumps({"code": code, "seconds": seconds}), file=replies, flush=True)


def _become(task: Task) -> NoReturn:
    """Be the program in this child, and end without taking apart what the server imported."""
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for number, name in ((1, OUT), (2, ERR)):
        place = os.open(Path(task.folder) / name, os.O_WRONLY)
        os.dup2(place, number)
    os.chdir(task.folder)
    sys.argv = ["coopenv", *task.arguments]
    try:
        code = _run(task)
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 1
    except BaseException:  # as the interpreter says it
        traceback.print_exc()
        code = 1
    with suppress(OSError):
        sys.stdout.flush()
    end_at_once(code)


def _run(task: Task) -> int:
    """The exit code of the program."""
    if task.fault is not None:
        faults.install(*task.fault, folder=os.getcwd())
    if task.module:
        name = task.module
        sys.path.insert(0, task.folder)
        import_module(name)
        return 0
    from coopenv.cli import main

    return main()


if __name__ == "__main__":
    with suppress(BrokenPipeError):  # who asked has gone
        _serve()
