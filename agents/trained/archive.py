"""Archives of learned policies: opened once they are whole, and what others note in them."""

import json
import os
import zipfile
from pathlib import Path
from typing import Any

from coopenv.errors import InvalidInput

NOTES = "coopenv.json"  # member of the archive: what SB3 does not write; others may add keys
PLAIN = "coopenv_policy.json"  # member: the network of a policy in plain numbers
_NEEDED = ("data", "policy.pth")  # members without which another file is no policy
_MOST_GROWTH, _ALWAYS = 100, 10**8  # times its size, and [bytes], that a file may unpack to


def read_notes(path: str | os.PathLike) -> dict[str, Any]:
    """The member `NOTES` of a policy's file, of either form; empty if SB3 itself wrote it.

    Raises
    ------
    InvalidInput
        If the file is no policy.
    """
    file = existing(Path(path))
    with opened(file) as archive:
        return notes_in(archive, file)


def existing(path: Path) -> Path:
    """The file itself; like SB3, with ``.zip`` added where it is not there without."""
    for file in (path, path.with_name(f"{path.name}.zip") if path.name else path):
        if file.is_file():
            return file
    what = "a folder" if path.is_dir() else "which is not there"
    inside = path / "policy.zip"
    remedy = f"give {str(inside)!r}" if inside.is_file() else "coopenv train writes such a file"
    raise InvalidInput(
        f"policy must be the file of a trained policy, got {str(path)!r}, {what}; {remedy}"
    )


def opened(file: Path) -> zipfile.ZipFile:
    """The file opened, once all of it could be read and it holds a policy."""
    try:
        archive = zipfile.ZipFile(file)
    except (OSError, ValueError, NotImplementedError, zipfile.BadZipFile) as error:
        raise _no_policy(file, _likely(file, error)) from error
    try:
        names = archive.namelist()
        missing = [name for name in _NEEDED if PLAIN not in names and name not in names]
        if missing:
            raise _no_policy(file, f"an archive without {' and '.join(missing)}")
        unpacked = sum(member.file_size for member in archive.infolist())
        if unpacked > max(_MOST_GROWTH * file.stat().st_size, _ALWAYS):
            raise _no_policy(file, f"which would unpack to {unpacked:,} bytes")
        try:
            broken = archive.testzip()
        except Exception as error:  # a damaged archive can raise anything
            raise _no_policy(file, f"which is damaged ({first_line(error)})") from error
        if broken is not None:
            raise _no_policy(file, f"in which {broken} is damaged")
    except InvalidInput:
        archive.close()
        raise
    return archive


def _likely(file: Path, error: Exception) -> str:
    """What a file is that cannot be opened as an archive."""
    try:
        with file.open("rb") as opened:
            start = opened.read(2)
    except OSError:
        return f"which cannot be read ({error})"
    if not start:
        return "which is empty"
    return "an archive that was cut short" if start == b"PK" else "which is no archive"


def _no_policy(file: Path, what: str) -> InvalidInput:
    return InvalidInput(
        f"policy must be a file that SB3Policy.save or a model's save wrote, or coopenv export, "
        f"got {str(file)!r}, {what}; copy it again or give another"
    )


def notes_in(archive: zipfile.ZipFile, file: Path) -> dict[str, Any]:
    """The member `NOTES`; empty if there is none. Raises `InvalidInput` if it is damaged."""
    if NOTES not in archive.namelist():
        return {}
    return object_in(archive, NOTES, file)


def object_in(archive: zipfile.ZipFile, member: str, file: Path) -> dict[str, Any]:
    """The JSON object that a member holds; raises `InvalidInput` where it holds none."""
    try:
        found = json.loads(archive.read(member))
    except (ValueError, RecursionError) as error:
        raise _no_policy(file, f"in which {member} is no JSON") from error
    if not isinstance(found, dict):
        raise _no_policy(file, f"in which {member} is no object")
    return found


def first_line(error: Exception) -> str:
    """What an error says, in one line."""
    return (str(error).splitlines() or [""])[0]
