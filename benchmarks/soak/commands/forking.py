"""The process that forks a child for every command, with coopenv imported and its kernels loaded.

It has one thread, which is what makes forking it sound.
"""

import faulthandler
import gc
import json
import os
import sys
import traceback
from contextlib import redirect_stdout, suppress
from importlib import import_module
from os import _exit as end_at_once
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NoReturn

from benchmarks.soak.commands import faults
from benchmarks.soak.commands.server import ERR, OUT, ROOT, Task

WARM = (  # commands that load most kernels, fonts and the like
    "evaluate random scripted --horizon 2 --episodes 2",
    "evaluate random --env coopenv/WalkerTurn-v0 --horizon 2 --episodes 2",
    "study walker-turn --out turn",
)
ALLOCATOR = "jemalloc_bg_thd"  # thread of pyarrow, which stops it at a fork


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
    faulthandler.enable()  # one that hangs and is aborted says where it was
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


def _warm_up() -> None:
    """Run commands in the server itself, so that children find their kernels loaded."""
    import torch

    from coopenv.cli import main

    torch.optim.Adam([torch.zeros(1, requires_grad=True)])  # imports a compiler
    with TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere:
        os.chdir(folder)
        with redirect_stdout(nowhere):
            for words in WARM:
                if main(words.split()):
                    raise RuntimeError(f"the server could not run {words!r}")
        os.chdir(ROOT)
    names = [path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")]
    others = [name for name in names if name != ALLOCATOR]
    if len(others) > 1:
        raise RuntimeError(f"the server must have one thread to be forked, got {others}")


if __name__ == "__main__":
    with suppress(BrokenPipeError):  # who asked has gone
        _serve()
