"""Which process made a file, and whether it is still alive."""

import os
import platform
import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

PROC = Path("/proc")
NAME, START = 2, 22  # fields of /proc/PID/stat; START: ticks from the machine's start on, proc(5)


@dataclass(frozen=True, slots=True, kw_only=True)
class Process:
    """A process, told from another that was given its number later.

    Its marks are short digests: of letters and digits, so that names of files can hold them.
    """

    pid: int
    started: str  # mark of when; "0" where the system does not say
    host: str  # mark of the machine, and of how it numbers: containers do so by themselves

    @classmethod
    def current(cls) -> "Process":
        """The one that asks."""
        pid = os.getpid()
        return cls(pid=pid, started=_started(pid), host=_host())

    def is_here(self) -> bool:
        """Whether it ran where its number can be looked up."""
        return self.host == _host()

    def is_dead(self) -> bool:
        """Whether it has certainly ended; one that ran elsewhere may live."""
        if not self.is_here() or sys.platform == "win32":  # where asking by a signal would kill it
            return False
        try:
            os.kill(self.pid, 0)
        except (ProcessLookupError, OverflowError):
            return True
        except PermissionError:  # it is somebody else's
            pass
        return _started(self.pid) != self.started


def kernel() -> str:
    """Mark of the running system: another after every start of the machine, one in its containers.

    Empty where the system does not say.
    """
    return _mark(_read("sys/kernel/random/boot_id"))


def _started(pid: int) -> str:
    """Mark of when the process of that number started, also told from one before a restart."""
    fields = _read(f"{pid}/stat").rpartition(")")[2].split()  # its name may hold blanks
    place = START - NAME - 1
    return _mark(f"{kernel()} {fields[place]}") if len(fields) > place else "0"


@cache
def _host() -> str:
    machine, numbering = "", ""
    with suppress(OSError):
        machine = Path("/etc/machine-id").read_text()  # other machines may be of the same name
    with suppress(OSError, ValueError):
        numbering = os.readlink(PROC / "self" / "ns" / "pid")
    return _mark(f"{platform.node()} {machine} {numbering}")


def _read(name: str) -> str:
    try:
        return (PROC / name).read_text()
    except (OSError, UnicodeDecodeError):
        return ""


def _mark(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:8] if text.strip() else ""
