"""Files that cannot be read or written: what went wrong, said with the file and a remedy."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from coopenv.errors import CoopenvError, InvalidInput


class FileTrouble(InvalidInput, OSError):
    """A file that the system does not let be read or written."""


def require_file(path: Path) -> None:
    """Raise `InvalidInput` unless there is a file of that name."""
    with reading(path):
        if path.is_dir():
            raise InvalidInput(f"file must be a file, got the folder {str(path)!r}; name one in it")
        if not path.is_file():
            raise InvalidInput(f"file must exist, got {str(path)!r}; check its name")


@contextmanager
def reading(path: str | os.PathLike) -> Iterator[None]:
    """Turn whatever goes wrong with a file while it is read into our errors.

    Libraries that parse formats raise a dozen kinds of exceptions where a file is damaged.
    """
    try:
        yield
    except CoopenvError:
        raise
    except OSError as error:
        raise FileTrouble(
            f"{os.fspath(path)} must be readable, got: {_reason(error)}; check its name, its "
            "permissions and the disk"
        ) from error
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
    except CoopenvError:
        raise
    except OSError as error:
        raise FileTrouble(
            f"{os.fspath(path)} must be writable, got: {_reason(error)}; make room or choose "
            "another place with --out"
        ) from error


def require_writable(path: Path) -> None:
    """Raise `InvalidInput` unless a file of that name is none yet or may be written over."""
    if path.is_dir():
        raise InvalidInput(f"out must be a file, got a folder {str(path)!r}; choose another name")
    if path.exists() and not os.access(path, os.W_OK):
        raise PermissionError(f"{path} is write-protected")


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
