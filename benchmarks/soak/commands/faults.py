"""Failures of the disk, made to happen in a process of its own.

Python tells an audit hook before it opens, renames, makes or removes something; the hook raises in
place of the n-th such call in a folder. A file whose writing fails is opened, and then its
descriptor leads to ``/dev/full``, which refuses whatever Python's own buffers or a library in C
write to it; one that is read as well is refused by Python alone. What opens files without Python is
stopped by a limit of size.
"""

import builtins
import errno
import io
import os
import resource
import sys
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

ERRORS = (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EACCES, errno.EROFS)
KINDS = ("open", "write", "fsync", "rename", "mkdir", "size")
EVENTS = {"open": "open", "rename": "os.rename", "mkdir": "os.mkdir"}  # of the audit
MARK = "fault.txt"  # in the folder, once something was made to fail


def install(kind: str, number: int, error: int, *, folder: str) -> None:
    """Let one call in this process fail; it cannot be undone.

    Parameters
    ----------
    kind
        One of `KINDS`: what fails, or the size of files.
    number
        Of the call in ``folder`` that fails, from 0; of ``"size"`` the largest file [byte].
    error
        What the system says; of ``"write"`` and ``"size"`` it says what it does by itself.
    folder
        Where calls count.
    """
    if kind == "size":
        hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        resource.setrlimit(resource.RLIMIT_FSIZE, (number, hard))
        return
    due = _due(number, Path(folder) / MARK)
    if kind == "fsync":
        os.fsync = _failing(os.fsync, due, error)
    elif kind == "write":
        _divert(due, folder)
    else:
        sys.addaudithook(_hook(EVENTS[kind], due, error, folder))


def _due(number: int, mark: Path) -> Callable[[], bool]:
    """Says True the n-th time, once, and leaves a mark that it did."""
    calls = count()
    place = os.open(mark.parent, os.O_RDONLY)

    def due() -> bool:
        if next(calls) != number:
            return False
        os.close(os.open(mark.name, os.O_WRONLY | os.O_CREAT, dir_fd=place))
        return True

    return due


def _hook(event: str, due: Callable[[], bool], error: int, folder: str) -> Callable[..., None]:
    """An audit hook that raises in place of a call."""

    def hook(name: str, given: tuple[Any, ...]) -> None:
        if name == event and _is_inside(given[0], folder) and due():
            raise OSError(error, os.strerror(error), given[0])

    return hook


def _failing(call: Callable[..., Any], due: Callable[[], bool], error: int) -> Callable[..., Any]:
    """A function of the system that fails when it is due."""

    def failing(*given: Any) -> Any:
        if due():
            raise OSError(error, os.strerror(error))
        return call(*given)

    return failing


def _divert(due: Callable[[], bool], folder: str) -> None:
    """Let what is written to the n-th file that Python opens for it end on a full disk."""
    opened: Callable[..., Any] = io.open

    def diverting(file: Any, mode: str = "r", *rest: Any, **named: Any) -> Any:
        strikes = bool(set(mode) & set("wax+")) and _is_inside(file, folder) and due()
        if strikes and {*"b+"} <= {*mode}:
            return io.BufferedRandom(_Full(file, mode.replace("b", "")))
        made = opened(file, mode, *rest, **named)
        if strikes:
            full = os.open("/dev/full", os.O_WRONLY)
            os.dup2(full, made.fileno())
            os.close(full)
        return made

    builtins.open = io.open = diverting


class _Full(io.FileIO):
    """A file on a full disk, of which what is there can be read: ``/dev/full`` has zeros no end."""

    def write(self, given: Any, /) -> int:
        """Refuse it."""
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), self.name)


def _is_inside(place: Any, folder: str) -> bool:
    """Whether a path lies in the folder; descriptors do not, nor what is told of the failure."""
    if not isinstance(place, str | bytes | os.PathLike):
        return False
    path = os.path.abspath(os.fsdecode(place))
    return path.startswith(folder + os.sep) and os.path.basename(path) != MARK
