"""Checks before the work: there is such a file, and outputs can be written."""

import os
from contextlib import suppress
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.files.temporary import begin, discard, temporary_name
from coopenv.files.trouble import reading, writing


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
    part = temporary_name(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        begin(part)
    finally:
        discard(part)
        with suppress(OSError):
            for folder in made:
                folder.rmdir()
