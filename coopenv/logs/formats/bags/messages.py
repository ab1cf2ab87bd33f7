"""ROS bags: topics of MCAP, SQLite and ROS 1 files and rosbag2 folders, through rosbags.

Numbers of a message are columns, called by the way to them: ``wrench/force/x``.
"""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, fields, is_dataclass
from itertools import islice
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.errors import InvalidInput, MissingExtra
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.stamps import Stamps
from coopenv.logs.formats.bags.folder import require_whole
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Source, Wanted
from coopenv.logs.formats.damage import parsing
from coopenv.logs.limits import Limits, shown

TIME = "time"
DEEPEST = 6  # messages within one another
SECOND = 10**9  # [ns]


class BagSource(Source):
    """Messages of one topic, at the times of their headers, or of their recording without one.

    Parameters
    ----------
    path, dialect, limits
        See `Source`.
    part
        The topic; may be left out where only one has numbers.
    """

    def __init__(self, path: Path, dialect: Dialect, limits: Limits, part: str = ""):
        self._path, self._limits = path, limits
        with _bag(path, limits) as bag:
            numbers = _topics(bag)
            topic = part or (next(iter(numbers)) if len(numbers) == 1 else "")
            if topic not in numbers:
                raise InvalidInput(
                    f"{path}: part must be one of its topics with numbers, got {shown(part)!r}; "
                    f"has: {', '.join(map(shown, islice(numbers, 20))) or 'none'}"
                )
            self._topic, self._ways = topic, numbers[topic]
            self.columns = [TIME, *self._ways]
            self._messages = int(bag.topics[topic].msgcount)
        limits.require("columns", len(self.columns), f"{path}", "leave out what is not needed")
        self.stamped = TIME
        self._found = self._messages

    @property
    def notes(self) -> Sequence[str]:
        """Whether there were other messages than the bag says."""
        if self._found == self._messages:
            return ()
        return (
            f"warning: {self._path} says that it has {self._messages:,} messages of {self._topic}, "
            f"and has {self._found:,}",
        )

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read some thousand messages at a time."""
        names = [name for name in wanted.names if name != TIME]
        take = [attrgetter(self._ways[name]) for name in names]
        clock = wanted.stamps.get(TIME) or Stamps("iso")
        row, most = 1, max(self._messages, 1)
        with _bag(self._path) as bag, closing(self._read(bag)) as messages:
            while part := list(islice(messages, CHUNK_ROWS)):
                rows = len(part)
                table = {
                    name: np.fromiter((get(each) for _, each in part), np.float64, rows)
                    for name, get in zip(names, take, strict=True)
                }
                times = np.fromiter((_time(each, logged) for logged, each in part), np.int64, rows)
                table[TIME] = clock.of_nanoseconds(times, np.ones(rows, np.bool_))
                yield _Messages(
                    numbers={name: table[name] for name in wanted.numbers},
                    carried={name: table[name] for name in wanted.carried},
                    rows=rows,
                    first_row=row,
                    progress=min(1.0, (row - 1 + rows) / most),
                    topic=self._topic,
                )
                row += rows
        self._found = row - 1

    def _read(self, bag: Any) -> Generator[tuple[int, Any], None, None]:
        """When messages were recorded [ns], and what they say."""
        wanted = [each for each in bag.connections if each.topic == self._topic]
        _forget_others(bag, wanted)
        with closing(bag.messages(connections=wanted)) as messages:  # before the bag is
            for connection, logged, raw in messages:
                place = f"{self._path}"
                self._limits.require("row_bytes", len(raw), place, "leave out what is large")
                yield logged, bag.deserialize(raw, connection.msgtype)


def topics(path: Path, limits: Limits) -> list[str]:
    """Topics whose messages have numbers."""
    with _bag(path, limits) as bag:
        return list(_topics(bag))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Messages(Chunk):
    """Messages of a topic."""

    topic: str

    def place(self, row: int) -> str:
        return f"message {self.first_row + row} of {self.topic}"


@contextmanager
def _bag(path: Path, limits: Limits | None = None) -> Iterator[Any]:
    """An open bag, which is checked where ``limits`` are given."""
    missing = MissingExtra("reading ROS bags", "ros")
    with parsing(path, "a whole ROS bag", "record or convert it again", missing=missing):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore

        if limits is not None and path.is_dir():
            require_whole(path, limits)
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as bag:
            if limits is not None:
                remedy = "record it in smaller chunks"
                limits.require("block_bytes", _largest(bag), f"{path}", remedy)
            yield bag


def _topics(bag: Any) -> dict[str, dict[str, str]]:
    """Topic → column → way to it, of all topics that have numbers."""
    found: dict[str, dict[str, str]] = {}
    for connection in bag.connections:
        if connection.topic in found or not connection.msgcount:
            continue
        first = next(bag.messages(connections=[connection]), None)
        if first is None:
            continue
        message = bag.deserialize(first[2], connection.msgtype)
        ways = {way.replace(".", "/"): way for way in _numbers(message, "")}
        if any(isinstance(attrgetter(way)(message), float) for way in ways.values()):
            found[connection.topic] = ways
    return found


def _numbers(message: Any, prefix: str, depth: int = 0) -> Iterator[str]:
    """Ways to the numbers of a message, but for its header."""
    if not is_dataclass(message) or depth > DEEPEST:
        return
    for entry in fields(message):
        value = getattr(message, entry.name)
        if isinstance(value, float | int | np.number) and not isinstance(value, bool):
            yield prefix + entry.name
        elif not (entry.name == "header" and not prefix):
            yield from _numbers(value, f"{prefix}{entry.name}.", depth + 1)


def _forget_others(bag: Any, wanted: list[Any]) -> None:
    """Drop the places of other topics' messages, all of which a reader of a ROS 1 bag holds."""
    kept = {each.id for each in wanted}
    for reader in bag.readers:
        places = getattr(reader, "indexes", {})
        places.update({number: [] for number in places if number not in kept})


def _time(message: Any, logged: int) -> int:
    """When it is of [ns]: its stamp, or that of the recording where it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        return logged
    return (stamp.sec * SECOND + stamp.nanosec) or logged


def _largest(bag: Any) -> int:
    """The most that a piece of the bag inflates to, as far as it says [bytes]."""
    stores = [getattr(reader, "storage", reader) for reader in bag.readers]
    stores = [each for store in stores for each in (getattr(store, "storages", None) or [store])]
    pieces = [piece for store in stores for piece in _pieces(getattr(store, "chunks", ()))]
    return max((int(getattr(piece, "uncompressed_size", 0)) for piece in pieces), default=0)


def _pieces(chunks: Any) -> list[Any]:
    return list(chunks.values() if isinstance(chunks, dict) else chunks)
