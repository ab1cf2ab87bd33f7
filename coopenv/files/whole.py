"""Files that are written whole or not at all."""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.files.temporary import NO_LINKS, begin, discard, sweep, temporary_name
from coopenv.files.trouble import writing

NEVER_FLUSHED = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)  # said by file systems that cannot


@contextmanager
def written(path: str | os.PathLike) -> Iterator[Path]:
    """A temporary path beside ``path``, which replaces it once the block ends without an error.

    Both have the same suffix, as writers choose the format by it. The temporary file is there,
    empty, under a name that nobody can guess; what it holds is on the disk before it replaces
    ``path``. It takes the permissions of a file that it replaces. A link of that name is replaced
    itself: what it points to stays as it was. Left-overs of dead processes that wrote the same file
    are removed; its own goes with the process at the latest, whenever a signal comes.

    Raises
    ------
    FileTrouble
        If the system does not let it be written; it is an `OSError` too.
    InvalidInput
        If ``path`` is a device, a pipe or the like.

    >>> with written("table.csv") as part:
    ...     _ = part.write_text("a,b")
    """
    path = Path(path)
    part: Path | None = None
    try:
        with writing(path):
            mode = _mode(path)
            path.parent.mkdir(parents=True, exist_ok=True)
            sweep(path.parent, path.name)
            part = temporary_name(path)
            begin(part, 0o666 if mode is None else mode | stat.S_IWUSR)
            yield part
            _flush(part, mode)
            part.replace(path)
            _flush_folder(path.parent)
    finally:
        if part is not None:
            discard(part)


def _mode(path: Path) -> int | None:
    """Permissions of the file that is there, if it is one."""
    try:
        found = path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):  # the folder is made, or that is what fails
        return None
    if not (stat.S_ISREG(found) or stat.S_ISLNK(found) or stat.S_ISDIR(found)):
        raise InvalidInput(
            f"path must be a file, got the device or pipe {str(path)!r}; choose another name"
        )
    return stat.S_IMODE(found) & 0o777 if stat.S_ISREG(found) else None


def _flush(part: Path, mode: int | None) -> None:
    """Have the disk hold all of a file, and set its permissions."""
    file = os.open(part, os.O_RDWR | NO_LINKS)
    try:
        _sync(file)
    finally:
        os.close(file)
    if mode is not None:
        part.chmod(mode)


def _flush_folder(folder: Path) -> None:
    """Have the disk hold the new name, where a folder can be flushed.

    The file is in place already: what goes wrong here is no failure.
    """
    with suppress(OSError):
        file = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(file)
        finally:
            os.close(file)


def _sync(file: int) -> None:
    try:
        os.fsync(file)
    except OSError as error:
        if error.errno not in NEVER_FLUSHED:
            raise
