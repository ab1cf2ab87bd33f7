"""Locks of folders in which one process works at a time.

The system's own lock on a file ends with the process, however it ends. What the file says, who has
the folder and since when, is for people, and for file systems and machines that do not know of each
other's locks.
"""

import json
import os
import platform
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import asdict, dataclass
from datetime import datetime
from functools import partial
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.files.ending import promise, settle
from coopenv.files.process import Process, kernel
from coopenv.files.temporary import NO_LINKS
from coopenv.files.trouble import writing

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

LOCK = ".coopenv.lock"  # name of the file, there as long as the folder is locked
BEYOND = 1 << 30  # byte that Windows locks: past the text, which others may read
MOST = 10_000  # bytes that are read of a file of that name

_HELD: ContextVar[Mapping[Path, list[int]]] = ContextVar("held")
_OPEN: dict[int, list[int]] = {}  # descriptors of locks, not to be held by a forked child; whose


@dataclass(frozen=True, slots=True, kw_only=True)
class Holder:
    """Who has a folder: what the file says."""

    process: Process
    kernel: str  # mark of the system that it runs on
    node: str  # name of the machine
    since: str  # local time of that machine

    @classmethod
    def current(cls) -> "Holder":
        """The process that asks, from now on."""
        return cls(
            process=Process.current(),
            kernel=kernel(),
            node=platform.node() or "this machine",
            since=datetime.now().isoformat(" ", "seconds"),
        )

    @classmethod
    def parse(cls, text: str) -> "Holder | None":
        """What `encode` made; None if it is none or not all of one."""
        try:
            given = json.loads(text)
            return cls(**{**given, "process": Process(**given["process"])})
        except (ValueError, TypeError, KeyError):
            return None

    def encode(self) -> str:
        """One line for people and for `parse`."""
        return json.dumps(asdict(self)) + "\n"

    def may_live(self, *, unlocked: bool) -> bool:
        """Whether it may be at work; ``unlocked``: the system says that its lock is free."""
        if unlocked and self.kernel and self.kernel == kernel():
            return False
        return not self.process.is_here() or not (unlocked or self.process.is_dead())


@contextmanager
def locked(folder: str | os.PathLike) -> Iterator[None]:
    """Have a folder alone; inside, the same caller may lock it again.

    A lock whose process is dead is taken over. Forked children do not keep it. The folder is made
    if there is none, and removed again if it stays empty.

    Parameters
    ----------
    folder
        To be locked.

    Raises
    ------
    InvalidInput
        If another process or thread has it, or one on another machine may have it.
    FileTrouble
        If the system does not let a file be written there.
    """
    place = Path(os.path.realpath(folder))
    held = _HELD.get({})
    if _is_open(held.get(place)):
        yield
        return
    path = Path(folder) / LOCK
    made = [each for each in path.parents if not each.exists()]
    taken: list[int] = []
    promise(id(taken), partial(_leave, path.absolute(), taken))
    try:
        with writing(folder):
            path.parent.mkdir(parents=True, exist_ok=True)
            _take(path, taken)
        _HELD.set({**held, place: taken})
        yield
    finally:
        _HELD.set(held)
        _leave(path, taken)
        settle(id(taken))
        with suppress(OSError):
            for each in made:
                each.rmdir()


def _take(path: Path, taken: list[int]) -> None:
    """Lock and sign the file; its descriptor goes into ``taken`` and ``_OPEN``."""
    while True:
        taken.clear()
        taken.append(file := os.open(path, os.O_RDWR | os.O_CREAT | NO_LINKS, 0o666))
        try:
            free = _lock(file)
            holder = Holder.parse(_text(file))
            if free is False or (holder is not None and holder.may_live(unlocked=free is True)):
                raise InvalidInput(_refusal(path, holder, here=free is False))
            if _is_there(path, file):
                _OPEN[file] = taken
                os.ftruncate(file, 0)
                os.write(file, Holder.current().encode().encode())
                return
        finally:
            if file not in _OPEN:  # refused, or who had it removed it: another lies in its place
                os.close(file)


def _leave(path: Path, taken: list[int]) -> None:
    """Undo as much as was done of locking when it was interrupted, or all of it."""
    if _is_open(taken):
        _release(path, taken[0])
    else:  # refused, closed in a forked child, or interrupted as soon as the file was there
        _remove_unsigned(path)


def _is_open(taken: list[int] | None) -> bool:
    """Whether a lock has not been left since, here or because this is a forked child."""
    return bool(taken) and _OPEN.get(taken[0]) is taken


def _release(path: Path, file: int) -> None:
    """Remove the file while it is locked, so that nobody finds it free and signed."""
    if sys.platform == "win32":  # which removes no open file
        os.ftruncate(file, 0)
        del _OPEN[file]
        os.close(file)
        with suppress(OSError):
            path.unlink()
    else:
        with suppress(OSError):
            if _is_there(path, file):
                path.unlink()
        del _OPEN[file]
        os.close(file)


def _remove_unsigned(path: Path) -> None:
    """Remove a file that nobody locked or signed."""
    with suppress(OSError):
        file = os.open(path, os.O_RDWR | NO_LINKS)
        try:
            if _lock(file) and not _text(file) and _is_there(path, file):
                path.unlink()
        finally:
            os.close(file)


def _refusal(path: Path, holder: Holder | None, *, here: bool) -> str:
    start = f"out must be a folder in which nobody else is at work, got {str(path.parent)!r}, which"
    if holder is None:
        return f"{start} another process has; wait until it ends, or choose another out (--out)"
    who = f"process {holder.process.pid} on {holder.node} has had since {holder.since}"
    if here or holder.process.is_here():
        return f"{start} {who}; wait until it ends, or choose another out (--out)"
    return (
        f"{start} {who}, another machine or container; wait until it ends, choose another out "
        f"(--out), or, if it has ended, remove {path}"
    )


def _text(file: int) -> str:
    os.lseek(file, 0, os.SEEK_SET)
    content = os.read(file, MOST)
    os.lseek(file, 0, os.SEEK_SET)
    return content.decode(errors="replace")


def _is_there(path: Path, file: int) -> bool:
    """Whether the path still names the open file."""
    try:
        return os.path.samestat(path.stat(follow_symlinks=False), os.fstat(file))
    except FileNotFoundError:
        return False


def _lock(file: int) -> bool | None:
    """True if the system locked the file, False if another has it, None if it cannot lock here."""
    try:
        if sys.platform == "win32":
            os.lseek(file, BEYOND, os.SEEK_SET)
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:  # some network file systems have no locks
        return None
    return True


def _close_in_child() -> None:
    for file in _OPEN:
        with suppress(OSError):
            os.close(file)
    _OPEN.clear()


if sys.platform != "win32":
    os.register_at_fork(after_in_child=_close_in_child)
