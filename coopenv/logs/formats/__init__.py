"""File formats of recordings, and the registry that opens a file by the suffix of its name.

A format is one file or folder of this folder with a `Source`, which reads, and a `Sink`, which
writes, and one line in `FORMATS`; or with a source alone, and a line in `READ`.
"""

import os
from collections.abc import Sequence
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.files import reading
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.formats.bags import BagSource, require_recording, topics
from coopenv.logs.formats.c3d import C3dSource, parts
from coopenv.logs.formats.chunks import Format, Sink, Source
from coopenv.logs.formats.hdf5 import Hdf5Source
from coopenv.logs.formats.matlab import MatSource
from coopenv.logs.formats.npz import NpzSink, NpzSource
from coopenv.logs.formats.parquet import ParquetSink, ParquetSource
from coopenv.logs.formats.text import TextSink, TextSource
from coopenv.logs.limits import Limits

FORMATS = (
    Format((".csv", ".tsv", ".txt"), TextSource, TextSink),
    Format((".npz",), NpzSource, NpzSink),
    Format((".parquet",), ParquetSource, ParquetSink),
)
"""Those that are read and written."""

BAGS = Format((".mcap", ".db3", ".bag"), BagSource, None, topics)
"""Also folders with a `metadata.yaml`."""

READ = (
    Format((".csv.gz", ".tsv.gz", ".txt.gz"), TextSource, None),
    Format((".mat",), MatSource, None),
    Format((".h5", ".hdf5", ".hdf", ".he5"), Hdf5Source, None),
    BAGS,
    Format((".c3d",), C3dSource, None, parts),
)
"""Those that are only read."""

PARTED = READ[1:]
"""Those of which a part can be read alone."""


def open_source(
    path: str | os.PathLike,
    dialect: Dialect | None = None,
    limits: Limits | None = None,
    part: str = "",
) -> Source:
    """Open a file for reading.

    Parameters
    ----------
    path, dialect, limits
        See `Source`.
    part
        A group, structure or topic of a file of several; all of it if empty.

    Raises
    ------
    InvalidInput
        If there is no such file, or it cannot be read, its suffix or content is not understood, or
        it is beyond a limit.
    MissingExtra
        If reading it needs an extra.
    """
    path = Path(path)
    require_recording(path)
    with reading(path):
        known = find_format(path)
        if part and known not in PARTED:
            raise InvalidInput(
                f"{path}: part must be left out of such files, which have none, got {part!r}; "
                "leave it out"
            )
        given = (path, dialect or Dialect(), limits if limits is not None else Limits())
        return known.source(*given, *filter(None, [part]))


def parts_of(path: Path, limits: Limits | None = None) -> list[str]:
    """Streams that a file of this format keeps apart, such as topics; none of most formats."""
    require_recording(path)
    known = find_format(path)
    if known.parts is None:
        return []
    with reading(path):
        return known.parts(path, limits if limits is not None else Limits())


def open_sink(path: str | os.PathLike) -> Sink:
    """Open a file for writing a table.

    Raises
    ------
    InvalidInput
        If no format that is written has its suffix.
    MissingExtra
        If writing it needs the extra ``analysis``.
    """
    path = Path(path)
    sink = find_format(path, FORMATS).sink
    assert sink is not None  # of all in FORMATS
    return sink(path)


def find_format(path: Path, among: Sequence[Format] = (*FORMATS, *READ)) -> Format:
    """The format of which the file has the suffix, in capitals or not; a folder is a ROS bag.

    Raises
    ------
    InvalidInput
        If no format has it.
    """
    name = path.name.lower()
    if BAGS in among and path.is_dir():
        return BAGS
    for known in among:
        if name.endswith(known.suffixes) and name not in known.suffixes:
            return known
    suffixes = [suffix for known in among for suffix in known.suffixes]
    raise InvalidInput(
        f"file must end in one of {', '.join(suffixes)}, got {path.name!r}; convert or rename it"
    )


def table_beside(path: Path) -> Path:
    """Where the table of a recording goes by default, in its format if that is written."""
    known = find_format(path)
    if path.is_dir():
        here = path if path.name not in ("", "..") else path.resolve()
        return here.with_name(f"{here.name}.decomposed{FORMATS[0].suffixes[0]}")
    suffix = next(each for each in known.suffixes if path.name.lower().endswith(each))
    stem, own = path.name[: -len(suffix)], path.name[-len(suffix) :]
    if known.sink is None or len(known.suffixes) > 1:  # a table is CSV, whatever text was read
        own = FORMATS[0].suffixes[0]
    return path.with_name(f"{stem}.decomposed{own}")
