"""File formats of recordings, and the registry that opens a file by the suffix of its name.

A format is one file of this folder with a `Source`, which reads, and a `Sink`, which writes, and
one line in `FORMATS`.
"""

import os
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.files import reading, require_file
from coopenv.logs.formats.chunks import Format, Sink, Source
from coopenv.logs.formats.npz import NpzSink, NpzSource
from coopenv.logs.formats.parquet import ParquetSink, ParquetSource
from coopenv.logs.formats.text import TextSink, TextSource
from coopenv.logs.limits import Limits

FORMATS = (
    Format((".csv", ".tsv", ".txt"), TextSource, TextSink),
    Format((".npz",), NpzSource, NpzSink),
    Format((".parquet",), ParquetSource, ParquetSink),
)


def open_source(
    path: str | os.PathLike, decimal: str = ".", limits: Limits | None = None
) -> Source:
    """Open a file for reading.

    Raises
    ------
    InvalidInput
        If there is no such file, or it cannot be read, its suffix or content is not understood, or
        it is beyond a limit.
    MissingExtra
        If reading it needs the extra ``analysis``.
    """
    path = Path(path)
    require_file(path)
    with reading(path):
        return find_format(path).source(path, decimal, limits if limits is not None else Limits())


def open_sink(path: str | os.PathLike) -> Sink:
    """Open a file for writing a table.

    Raises
    ------
    InvalidInput
        If no format has its suffix.
    MissingExtra
        If writing it needs the extra ``analysis``.
    """
    path = Path(path)
    return find_format(path).sink(path)


def find_format(path: Path) -> Format:
    """The format of which the file has the suffix, in capitals or not.

    Raises
    ------
    InvalidInput
        If no format has it.
    """
    suffix = path.suffix.lower()
    for known in FORMATS:
        if suffix in known.suffixes:
            return known
    suffixes = [suffix for known in FORMATS for suffix in known.suffixes]
    raise InvalidInput(
        f"file must end in one of {', '.join(suffixes)}, got {path.name!r}; convert or rename it"
    )
