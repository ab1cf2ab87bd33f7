"""Worker process of the soak test: runs trials of one campaign and reads its own size.

It is a process of its own, so that a crash or a hang of the interpreter ends nothing but the trial.
"""

import ctypes
import faulthandler
import gc
import multiprocessing
import os
import shutil
import signal
import threading
import time
import traceback
import warnings
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple, cast

from benchmarks.soak.frame.campaign import Campaign, timeout_of, warm_up

READ_EVERY = 1.0  # [s] between two readings of the process's size
LINES, WIDTH = 6, 300  # of what is told of a failure


class Size(NamedTuple):
    """How large a process is."""

    resident: int  # [bytes]
    descriptors: int  # open ones


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What a trial came to."""

    seconds: float
    counts: dict[str, int] = field(default_factory=dict)
    failure: str | None = None
    trace: str = ""


def attempt(campaign: Campaign, seed: int, folder: Path) -> Outcome:
    """Run one trial in an empty folder; whatever it raises is its failure."""
    began = time.perf_counter()
    folder.mkdir(parents=True)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)  # NaN and overflow, as in the tests
            counts = campaign.trial(seed, folder)
    except Exception as error:
        return Outcome(
            seconds=time.perf_counter() - began, failure=told(error), trace=traceback.format_exc()
        )
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return Outcome(seconds=time.perf_counter() - began, counts=counts)


def told(error: BaseException) -> str:
    """What broke and where, in a few lines."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    place = f"at {os.path.relpath(frame.filename)}:{frame.lineno} in {frame.name}"
    lines = [line for line in f"{type(error).__name__}: {error}".splitlines() if line.strip()]
    return "\n".join([*(line[:WIDTH] for line in lines[:LINES]), place])


def serve(pipe: Connection, module: str, folder: Path, log: Path) -> None:
    """Run the seeds that come through the pipe, until ``None`` comes; send an `Outcome` for each.

    With it goes the process's `Size`, now and then.

    What is printed, and where it crashed or hung, goes into ``log``.
    """
    os.setpgid(0, 0)  # with its children: they end together, and no Ctrl-C comes from the terminal
    with log.open("wb") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    faulthandler.enable(all_threads=False)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    campaign = cast(Campaign, import_module(module))
    warm_up(campaign)
    pipe.send(None)  # it is up
    last = -READ_EVERY
    while (seed := pipe.recv()) is not None:
        faulthandler.dump_traceback_later(timeout_of(campaign), exit=True)
        outcome = attempt(campaign, seed, folder / f"{campaign.NAME}-{seed}")
        faulthandler.cancel_dump_traceback_later()
        size = None
        if time.perf_counter() - last > READ_EVERY:
            size, last = size_of_process(), time.perf_counter()
        pipe.send((outcome, size))


def _end_with_parent() -> None:
    """A killed parent leaves nobody behind."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os.killpg(0, signal.SIGKILL)


def size_of_process() -> Size:
    """Resident bytes, after what is free has been given back, and open descriptors; of Linux."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return Size(pages * os.sysconf("SC_PAGE_SIZE"), len(os.listdir("/proc/self/fd")))
