"""Files of several devices as one source: their samples at the times of one of them, or at a rate."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.logs.declared.stamps import Stamps
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Column, Roles, Source
from coopenv.logs.joining.stream import Stream

TIME = "time"


class _Column(NamedTuple):
    """A column, and whose it is."""

    stream: Stream
    name: str  # in its file


class _Rows(NamedTuple):
    """Rows that are to be made."""

    time: FloatArray  # (T,) [s]
    chunk: Chunk | None  # of the device whose rows they are
    progress: float


class JoinedSource(Source):
    """Several devices as one.

    A column is called as in its file if no other file has one of that name, else ``left/Fx``, which
    a layout may always say. The rows are those of ``clock``, where all other devices have samples,
    or at ``rate`` as long as all have.

    Parameters
    ----------
    streams
        Of the devices, the recording itself first.
    clock
        Whose rows are kept; ``None`` to make them at a rate.
    rate
        [Hz], if no device is the clock.
    by_rows
        Whether rows are put beside each other whatever their times are.
    """

    def __init__(
        self,
        streams: Sequence[Stream],
        clock: Stream | None,
        rate: float | None,
        *,
        by_rows: bool = False,
    ):
        self._streams, self._clock, self._rate = tuple(streams), clock, rate
        self._by_rows = by_rows
        self._roles = Roles()
        self._place: dict[str, _Column] = {}
        count = Counter(name for stream in streams for name in stream.columns)
        for stream in streams:
            for name in stream.columns:
                alone = count[name] == 1 and name != TIME
                self._place[name if alone else f"{stream.name}/{name}"] = _Column(stream, name)
        self._kept = self._made = 0
        self._span = [np.inf, -np.inf]
        self._list()

    @property
    def _others(self) -> list[Stream]:
        return [stream for stream in self._streams if stream is not self._clock]

    def _list(self) -> None:
        timed = not self._by_rows or (self._clock is not None and self._clock.time_column)
        self.columns = [TIME] * bool(timed) + list(self._place)
        self.units = {
            name: unit
            for name, (stream, theirs) in self._place.items()
            if (unit := stream.source.units.get(theirs))
        }
        self.repeated = {
            name for stream in self._streams for name in stream.source.repeated
        } - {TIME}  # fmt: skip
        self.left_out = [
            name if len(self._streams) == 1 else f"{stream.name}/{name}"
            for stream in self._streams
            for name in stream.source.left_out
        ]
        grips = [each.source.grips for each in self._streams if each.source.grips is not None]
        self.grips = grips[0] if grips else None

    def offer(self, names: Iterable[str]) -> None:
        """Make columns of what names say by device, and of parts of arrays."""
        for name in names:
            if name in self._place:
                continue
            for stream in self._streams:
                own = name.removeprefix(f"{stream.name}/")
                if own != name or len(self._streams) == 1 or not self._found(name):
                    self._offer(name, stream, own)
        self._list()

    def _found(self, name: str) -> bool:
        return name in self._place

    def _offer(self, name: str, stream: Stream, own: str) -> None:
        if own not in stream.source.columns:
            stream.source.offer([own])
        if own not in stream.columns:
            return
        for other, there in list(self._place.items()):
            if there == (stream, own):  # under its name alone
                del self._place[other]
        self._place[name] = _Column(stream, own)

    def assign(self, roles: Roles) -> None:
        """Say what columns are, of which an orientation must be of one device."""
        owners = {self._place[name].stream for name in roles.quaternion}
        if len(owners) > 1:
            names = ", ".join(roles.quaternion)
            raise InvalidInput(f"a quaternion must be of one device, got {names}; map one device's")
        self._roles = roles

    @property
    def notes(self) -> Sequence[str]:
        """How many rows there are, and what was passed over."""
        said = []
        clock = "made" if self._clock is None else f"of {self._clock.name}"
        if self._others:
            said.append(
                f"{self._kept:,} of {self._made:,} rows {clock} are where all devices have samples, "
                f"{self._span[0]:.6g} s to {self._span[1]:.6g} s; between samples "
                + ", ".join(f"{each.name} {each.method}" for each in self._others)
            )
        for stream in self._others:
            if stream.equal:
                said.append(f"{stream.equal:,} samples of {stream.name} had the time before's")
            if stream.dropped:
                said.append(f"{stream.dropped:,} bad samples of {stream.name} were passed over")
        return said

    def chunks(
        self,
        numbers: Sequence[str],
        carried: Sequence[str],
        stamps: Mapping[str, Stamps] | None = None,
    ) -> Iterator[Chunk]:
        """Read all devices side by side."""
        place = {name: self._place[name] for name in (*numbers, *carried) if name != TIME}
        for stream in self._others:
            theirs = [
                {name: c.name for name in names if (c := place.get(name)) and c.stream is stream}
                for names in (numbers, carried)
            ]
            asked = [list(dict.fromkeys(each.values())) for each in theirs]
            roles = Roles(
                quaternion=tuple(filter(None, map(theirs[0].get, self._roles.quaternion))),
                angle=theirs[0].get(self._roles.angle, ""),
                period=self._roles.period,
            )
            stream.begin(*asked, roles)
        row = 1
        for rows in self._rows(numbers, carried, place):
            kept = self._common(rows.time)
            self._made, self._kept = self._made + len(kept), self._kept + int(kept.sum())
            if kept.any():
                chunk = self._chunk(rows, np.flatnonzero(kept), numbers, carried, place, row)
                yield chunk
                row += chunk.rows
        self._require_rows()

    def _rows(
        self, numbers: Sequence[str], carried: Sequence[str], place: Mapping[str, _Column]
    ) -> Iterator[_Rows]:
        """Times of rows, with all other devices read so far."""
        if self._clock is None:
            yield from self._at_rate()
            return
        own = [
            [place[n].name for n in names if n in place and place[n].stream is self._clock]
            for names in (numbers, carried)
        ]
        for chunk, time in self._clock.chunks(*own):
            known = time[np.isfinite(time)]
            if len(known):
                self._read(float(known.min()), float(known.max()))
            yield _Rows(time, chunk, chunk.progress)
        for stream in self._others if self._by_rows else ():
            stream.read_to(np.inf)

    def _at_rate(self) -> Iterator[_Rows]:
        assert self._rate is not None
        begin = max(stream.span()[0] for stream in self._streams)
        if not np.isfinite(begin):
            return
        first, k = float(np.ceil(begin * self._rate - 1e-6)), 0
        while True:
            time = (first + np.arange(k, k + CHUNK_ROWS)) / self._rate
            self._read(float(time[0]), float(time[-1]))
            end = min(stream.span()[1] for stream in self._streams)
            time = time[time <= end]
            if not len(time):
                return
            yield _Rows(time, None, 0.0)
            if len(time) < CHUNK_ROWS:
                return
            k += CHUNK_ROWS

    def _read(self, first: float, last: float) -> None:
        for stream in self._others:
            stream.forget(first)
            stream.read_to(last)

    def _common(self, time: FloatArray) -> BoolArray:
        """Which rows ``(T,)`` all devices have samples for; those without a time are kept."""
        spans = [stream.span() for stream in self._others]
        kept = np.ones(len(time), np.bool_)
        for first, last in spans:
            kept &= ~((time < first) | (time > last))
        if kept.any() and np.isfinite(time[kept]).any():
            known = time[kept][np.isfinite(time[kept])]
            self._span = [min(self._span[0], known.min()), max(self._span[1], known.max())]
        return kept

    def _chunk(
        self,
        rows: _Rows,
        index: IntArray,
        numbers: Sequence[str],
        carried: Sequence[str],
        place: Mapping[str, _Column],
        first_row: int,
    ) -> Chunk:
        at, clock = rows.time[index], rows.chunk
        made = {stream: stream.numbers_at(at) for stream in self._others}
        others = {stream: stream.carried_at(at) for stream in self._others}
        read: dict[str, FloatArray] = {}
        for name in numbers:
            if name == TIME:
                read[name] = self._time(rows, index)
            else:
                stream, own = place[name]
                values = made[stream][own] if stream in made else clock.numbers[own][index]  # pyright: ignore
                read[name] = values
        held: dict[str, Column] = {}
        for name in carried:
            stream, own = place[name]
            held[name] = others[stream][own] if stream in others else clock.carried[own][index]  # pyright: ignore
        bad = {} if clock is None else clock.bad
        own = {name: c.name for name, c in place.items() if c.stream is self._clock}
        if self._clock is not None and self._clock.time_column:
            own[TIME] = self._clock.time_column
        return _JoinedChunk(
            numbers=read,
            carried=held,
            rows=len(index),
            first_row=first_row,
            progress=rows.progress,
            rules={
                name: clock.rules.get(theirs, clock.rule) for name, theirs in own.items()
            } if clock is not None else {},
            bad={name: bad[theirs][index] for name, theirs in own.items() if theirs in bad},
            fields=None if clock is None or clock.fields is None else clock.fields[index],
            clock=clock,
            called="" if self._clock is self._streams[0] or clock is None else self._clock_name(),
            index=index,
            own=own,
            owner={name: c.stream.name for name, c in place.items()},
        )  # fmt: skip

    def _clock_name(self) -> str:
        assert self._clock is not None
        return f" of {self._clock.path}"

    def _time(self, rows: _Rows, index: IntArray) -> FloatArray:
        """Time of the rows [s]."""
        if self._by_rows and self._clock is not None and rows.chunk is not None:
            return self._clock.seconds(rows.chunk)[index]
        return rows.time[index]

    def _require_rows(self) -> None:
        """Raise where nothing is in common, or rows have no neighbours."""
        if self._by_rows and self._clock is not None:
            for stream in self._others:
                if stream.rows != self._made:
                    raise InvalidInput(
                        f"{stream.path} must have as many rows as {self._clock.path}, got "
                        f"{stream.rows:,} and {self._made:,}; join them on time"
                    )
        if not self._kept and (self._made or self._clock is None):
            spans = ", ".join(
                f"{each.name} {each.first:.6g} s to {each.last:.6g} s" for each in self._others
            )
            raise InvalidInput(
                f"{self._streams[0].path}: devices must have samples at the same time, got {spans}"
                f"{self._clock_span()}; look at their units of time and delays"
            )

    def _clock_span(self) -> str:
        if self._clock is None:
            return ""
        return f" and no row of {self._clock.name} there"


@dataclass(frozen=True, slots=True, kw_only=True)
class _JoinedChunk(Chunk):
    """Rows of a clock, with what others say at their times."""

    clock: Chunk | None
    called: str  # whose rows they are, if not of the recording itself
    index: IntArray  # (T,) rows of the clock
    own: Mapping[str, str] = field(default_factory=dict)  # column -> its name in the clock's file
    owner: Mapping[str, str] = field(default_factory=dict)  # column -> device

    def place(self, row: int) -> str:
        if self.clock is None:
            return f"row {self.first_row + row}"
        return self.clock.place(int(self.index[row])) + self.called

    def text(self, row: int, column: str) -> str:
        if self.clock is not None and column in self.own:
            return self.clock.text(int(self.index[row]), self.own[column])
        return f"no sample of {self.owner.get(column, column)} that is near enough"
