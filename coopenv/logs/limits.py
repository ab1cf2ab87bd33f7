"""Limits on what one recording may cost, checked beforehand; and short forms of what it says."""

import os
from collections.abc import Iterable
from dataclasses import dataclass

from coopenv.errors import InvalidInput

MEANING = {
    "row_bytes": "bytes of a row; of text, of a line, the header too",
    "columns": "columns",
    "effectors": "effectors",
    "rows": "rows of formats that say how many they have before they are read, as NPZ does",
    "block_bytes": "bytes that can only be read at once: Fortran order, row groups, bag chunks, "
    "old MATLAB",
}
"""What each limit is on, for the page on recordings."""

LONGEST_NAME = 1000  # [characters] of a column
SHOWN = 80  # characters of what a file says that a message repeats


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """The most that a file may have; each is a field ``max_…`` of a layout and an option."""

    row_bytes: int = 1 << 20  # of one row: in text of a line, the header too
    columns: int = 10_000
    effectors: int = 100
    rows: int = 100_000_000  # of formats that say how many before they are read: NPZ, Parquet
    block_bytes: int = 1 << 30  # of what can only be read at once: arrays in Fortran order, groups

    def require(self, name: str, found: int | str, place: str, remedy: str) -> None:
        """Raise `InvalidInput` if there is more than the limit of that name.

        Parameters
        ----------
        name
            Of a field.
        found
            How much there is, or a word where it is known to be too much.
        place
            File and line, column or array, for the message.
        remedy
            What else can be done than to raise the limit.
        """
        most = getattr(self, name)
        if isinstance(found, int) and found <= most:
            return
        said = f"{found:,}" if isinstance(found, int) else found
        what = {"row_bytes": "bytes in a row", "block_bytes": "bytes to be read at once"}
        raise InvalidInput(
            f"{place} must have at most {most:,} {what.get(name, name)}, got {said}; {remedy}, or "
            f"say --max-{name.replace('_', '-')}"
        )


def require_short_names(path: str, names: Iterable[str]) -> None:
    """Raise `InvalidInput` if a column's name is so long that it is none."""
    for number, name in enumerate(names, start=1):
        if len(name) > LONGEST_NAME:
            raise InvalidInput(
                f"{path}, column {number} must have a name of at most {LONGEST_NAME:,} "
                f"characters, got {len(name):,}: {shown(name)!r}; rename it"
            )


def shown(text: object, most: int = SHOWN) -> str:
    """What a message repeats of a text: on one line, and not all of it where it is long."""
    line = " ".join(str(text)[: 4 * most].split())
    return line if len(line) <= most else f"{line[:most]}…"


def legible(path: str | os.PathLike) -> str:
    """Name of a file as text that can be printed and written, whatever bytes it is."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")
