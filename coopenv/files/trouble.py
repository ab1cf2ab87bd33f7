"""What the system says against reading or writing a file, as an error of ours.

Whoever reads or writes a file does it in `reading` or `writing` (`coopenv.files.written` does so
itself), and the command line says what is left; all use the sentence of `file_trouble`.
"""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager

from coopenv.errors import CoopenvError, FileTrouble, InvalidInput

FORBIDDEN = "change its permissions, or choose another place (--out)"
REMEDIES = {
    errno.EACCES: FORBIDDEN,
    errno.EPERM: FORBIDDEN,
    errno.EROFS: "the disk is read-only: choose another place (--out)",
    errno.ENOSPC: "the disk is full: make room, or choose another place (--out)",
    errno.EDQUOT: "the quota is used up: make room, or choose another place (--out)",
    errno.EFBIG: "the file gets too large: make room, or choose another place (--out)",
    errno.EISDIR: "it is a folder: name a file in it",
    errno.EEXIST: "a file is where a folder should be: choose another place (--out)",
    errno.ENOTDIR: "a file is where a folder should be: choose another place (--out)",
    errno.ENOENT: "check its name, and that the folder exists",
    errno.ENAMETOOLONG: "check its name, which has to be shorter",
    errno.ELOOP: "its links go in a circle: choose another place (--out)",
    errno.EMFILE: "too many files are open: close some, or raise the limit (ulimit -n)",
    errno.ENFILE: "too many files are open: close some",
}


@contextmanager
def reading(path: str | os.PathLike) -> Iterator[None]:
    """Turn whatever goes wrong with a file while it is read into our errors.

    Libraries that parse formats raise a dozen kinds of exceptions where a file is damaged.
    """
    try:
        yield
    except (CoopenvError, MemoryError):
        raise
    except Exception as error:
        if isinstance(error, OSError) and error.errno is not None:  # of the system
            raise file_trouble(error, path, "readable") from error
        said = (str(error).splitlines() or [""])[0]
        raise InvalidInput(
            f"{os.fspath(path)} must be whole and of the format that its name says, got "
            f"{type(error).__name__}: {said}; write the file again"
        ) from error


@contextmanager
def writing(path: str | os.PathLike) -> Iterator[None]:
    """Turn what the system says against writing a file into `FileTrouble`."""
    try:
        yield
    except (CoopenvError, BrokenPipeError):
        raise
    except OSError as error:
        raise file_trouble(error, path, "writable") from error


def file_trouble(
    error: OSError, path: str | os.PathLike | None = None, rule: str = "usable"
) -> FileTrouble:
    """The sentence about a file with which the system had trouble: which, what, and a remedy.

    ``path`` is the file that was meant, if it is not the one that the error names.
    """
    if path is None:
        path = error.filename if isinstance(error.filename, str | os.PathLike) else "the output"
    remedy = REMEDIES.get(error.errno or 0, "check its name, its permissions and the disk")
    return FileTrouble(
        f"{os.fspath(path)} must be {rule}, got: {error.strerror or error}; {remedy}"
    )
