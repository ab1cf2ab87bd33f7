"""Files: written whole or not at all, and what the system says against one as an error of ours.

Whoever reads or writes a file does it in `reading` or `writing` (`written` does so itself), and the
command line says what is left; all use the sentence of `file_trouble`.
"""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

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
def written(path: str | os.PathLike) -> Iterator[Path]:
    """A temporary path beside ``path``, which replaces it once the block ends without an error.

    Both have the same suffix, as writers choose the format by it.

    Raises
    ------
    FileTrouble
        If the system does not let it be written; it is an `OSError` too.

    >>> with written("table.csv") as part:
    ...     _ = part.write_text("a,b")
    """
    path = Path(path)
    part = path.with_name(f".part-{os.getpid()}-{path.name}")
    try:
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            yield part
            part.replace(path)
    finally:
        with suppress(OSError):  # what went wrong first is what is told
            part.unlink(missing_ok=True)


@contextmanager
def reading(path: str | os.PathLike) -> Iterator[None]:
    """Turn whatever goes wrong with a file while it is read into our errors.

    Libraries that parse formats raise a dozen kinds of exceptions where a file is damaged.
    """
    try:
        yield
    except (CoopenvError, MemoryError):
        raise
    except OSError as error:
        raise file_trouble(error, path, "readable") from error
    except Exception as error:
        raise InvalidInput(
            f"{os.fspath(path)} must be whole and of the format that its name says, got "
            f"{type(error).__name__}: {error}; write the file again"
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


def require_file(path: Path) -> None:
    """Raise `InvalidInput` unless there is a file of that name."""
    with reading(path):
        if path.is_dir():
            raise InvalidInput(f"file must be a file, got the folder {str(path)!r}; name one in it")
        if not path.is_file():
            raise InvalidInput(f"file must exist, got {str(path)!r}; check its name")


def require_writable(path: str | os.PathLike) -> None:
    """Raise `InvalidInput` unless a file of that name can be written; leaves nothing behind."""
    path = Path(path)
    with writing(path):
        if path.is_dir():
            raise InvalidInput(
                f"out must be a file, got a folder {str(path)!r}; choose another name"
            )
        if path.exists() and not os.access(path, os.W_OK):
            raise InvalidInput(f"{path} is write-protected; choose another name, or unprotect it")
        _try(path)


def require_folder(path: str | os.PathLike) -> None:
    """Raise `InvalidInput` unless files can be written in that folder; leaves nothing behind."""
    path = Path(path)
    with writing(path):
        if path.exists() and not path.is_dir():
            raise InvalidInput(f"out must be a folder, got the file {str(path)!r}; choose another")
        _try(path / "out")


def _try(path: Path) -> None:
    """Write a file beside ``path``, and remove it and the folders that it needed."""
    made = [folder for folder in path.parents if not folder.exists()]
    part = path.with_name(f".part-{os.getpid()}-{path.name}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.touch()
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)
            for folder in made:
                folder.rmdir()
