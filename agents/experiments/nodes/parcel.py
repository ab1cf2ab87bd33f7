"""Parcels: all files of a cell's folder in one piece, as they travel between machines."""

import io
import zipfile
from pathlib import Path

from coopenv.files import reading, written

from ..cell import CELL, RESULT

LAST = ("policy.zip", RESULT)  # what a finished training and a finished cell are known by


def packed(folder: Path) -> bytes:
    """The files below a folder but hidden ones, which are locks and unfinished; no links."""
    data = io.BytesIO()
    with reading(folder), zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*")):
            name = path.relative_to(folder)
            if path.is_file() and not path.is_symlink() and not _is_hidden(name):
                archive.writestr(name.as_posix(), path.read_bytes())
    return data.getvalue()


def names_in(parcel: bytes) -> list[str]:
    """Of its files, in the order in which they are to be written: what says the end comes last."""
    with zipfile.ZipFile(io.BytesIO(parcel)) as archive:
        names = archive.namelist()
    return sorted(names, key=lambda name: (LAST.index(name) + 1 if name in LAST else 0, name))


def unpack(parcel: bytes, folder: Path, sent: bytes | None = None) -> None:
    """Write the files of a parcel, each whole or not at all, the result last.

    So a folder has a result only where it has everything else.

    Parameters
    ----------
    folder
        That they go into, over those of the same names.
    sent
        The parcel that this one answers: what was in it and did not come back is removed.

    Raises
    ------
    InvalidInput
        If a name in it leads out of the folder, or it is damaged.
    """
    with reading("parcel"):
        names = names_in(parcel)
        for name in (*names, *(names_in(sent) if sent else ())):
            if Path(name).is_absolute() or ".." in Path(name).parts:
                raise ValueError(f"{name!r} leads out of its folder")
        for name in {*(names_in(sent) if sent else ())} - {*names, CELL}:
            (folder / name).unlink(missing_ok=True)
        with zipfile.ZipFile(io.BytesIO(parcel)) as archive:
            for name in names:
                with written(folder / name) as part:
                    part.write_bytes(archive.read(name))


def _is_hidden(name: Path) -> bool:
    return any(part.startswith(".") for part in name.parts)
