"""Temporary files beside what they will replace, and sweeping of those whose process is dead.

Named ``.NAME.PID-STARTED-HOST-RANDOM.part`` and the suffix of the name: nobody can guess it, and
everybody can see whose it is.
"""

import os
import re
import secrets
from collections.abc import Iterator
from contextlib import suppress
from functools import partial
from hashlib import sha256
from pathlib import Path

from coopenv.files.ending import is_due, promise, settle
from coopenv.files.process import Process

LONGEST = 100  # bytes of a target's name in a temporary one; systems take 143 or 255 in all
ENDING = re.compile(r"\.(\d{1,10})-([0-9a-f]{1,8})-([0-9a-f]{8})-[0-9a-f]{16}\.part(\.[^/]*)?")
NO_LINKS = getattr(os, "O_NOFOLLOW", 0)  # of systems that have it


def temporary_name(path: Path) -> Path:
    """Draw the name of a temporary file beside ``path``, of the same suffix."""
    me = Process.current()
    mark = f"{me.pid}-{me.started}-{me.host}-{secrets.token_hex(8)}"
    return path.with_name(f"{_beginning(path.name)}.{mark}.part{path.suffix}")


def begin(part: Path, mode: int = 0o666) -> None:
    """Make an empty file, never one or a link that was there before.

    It is removed at the latest as the process ends: a signal may come as soon as it is there, or
    as `discard` is about to remove it.

    Parameters
    ----------
    part
        Its name, of `temporary_name`.
    mode
        Permissions, of which the process's umask takes some away.
    """
    flags = os.O_CREAT | os.O_EXCL | os.O_WRONLY | NO_LINKS | getattr(os, "O_BINARY", 0)
    place = Path(os.path.abspath(part))  # the process may go elsewhere
    promise(place, partial(place.unlink, missing_ok=True))
    try:
        os.close(os.open(part, flags, mode))
    except FileExistsError:  # somebody's: not to be removed
        settle(place)
        raise


def discard(part: Path) -> None:
    """Remove what `begin` made, if it did and the file is still there under that name.

    What the system says against it is passed over: what went wrong first is what is told.
    """
    with suppress(OSError):
        place = Path(os.path.abspath(part))
        if is_due(place):
            place.unlink(missing_ok=True)
            settle(place)


def sweep(folder: Path, target: str | None = None) -> list[Path]:
    """Remove what dead processes of this machine left behind in a folder, and say what it was.

    Files of other machines and of containers stay, as nobody here knows whether they are written.

    Parameters
    ----------
    folder
        Where to look.
    target
        Only what was to replace the file of this name; else of any.
    """
    swept = []
    for path, owner in _left(folder, None if target is None else _beginning(target)):
        if owner.is_dead():
            with suppress(OSError):  # another sweeps too, or it is not ours to remove
                path.unlink()
                swept.append(path)
    return swept


def _left(folder: Path, beginning: str | None) -> Iterator[tuple[Path, Process]]:
    """Temporary files and their processes."""
    try:
        names = os.listdir(folder)
    except OSError:  # whoever writes there will say so
        return
    for name in names:
        found = ENDING.search(name)
        if found is None or not name.startswith(".") or found.end() != len(name):
            continue
        path = folder / name
        if beginning in (None, name[: found.start()]) and path.is_file() and not path.is_symlink():
            pid, started, host = found.group(1, 2, 3)
            yield path, Process(pid=int(pid), started=started, host=host)


def _beginning(name: str) -> str:
    """How temporary names of a target begin; a digest stands for a name that is long."""
    content = os.fsencode(name)
    return f".{name if len(content) <= LONGEST else sha256(content).hexdigest()[:32]}"
