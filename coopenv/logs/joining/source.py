"""Files of several devices as one source, at the times of one of them or at a rate."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.logs.formats.chunks import CHUNK_ROWS, Chunk, Column, Roles, Source, Wanted
from coopenv.logs.joining.names import TIME, Names
from coopenv.logs.joining.rows import JoinedChunk
from coopenv.logs.joining.stream import Stream
from coopenv.logs.limits import Limits


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
    limits
        On the rows that are made at a rate.
    by_rows
        Whether rows are put beside each other whatever their times are.
    """

    def __init__(
        self,
        streams: Sequence[Stream],
        clock: Stream | None,
        rate: float | None,
        limits: Limits,
        *,
        by_rows: bool = False,
    ):
        self._streams, self._clock, self._rate = tuple(streams), clock, rate
        self._limits, self._by_rows = limits, by_rows
        self._roles = Roles()
        self._names = Names(streams)
        self._kept = self._made = 0
        self._span = [np.inf, -np.inf]
        self._list()

    @property
    def _others(self) -> list[Stream]:
        return [stream for stream in self._streams if stream is not self._clock]

    def _list(self) -> None:
        timed = not self._by_rows or (self._clock is not None and self._clock.time_column)
        self.columns = [TIME] * bool(timed) + list(self._names)
        self.units, self.made = self._names.units, self._names.made
        self.repeated = {
            name for stream in self._streams for name in stream.source.repeated
        } - {TIME}  # fmt: skip
        self.left_out = [
            name if len(self._streams) == 1 else f"{stream.name}/{name}"
            for stream in self._streams
            for name in stream.source.left_out
        ]
        several = len(self._streams) > 1 and not self._by_rows
        self.owners = {name: c.stream.owner for name, c in self._names.items() if several}
        grips = [each.source.grips for each in self._streams if each.source.grips is not None]
        self.grips = grips[0] if grips else None

    def offer(self, names: Iterable[str]) -> None:
        """Make columns of what names say by device, and of parts of arrays."""
        self._names.offer(names)
        self._list()

    def assign(self, roles: Roles) -> None:
        """Say what columns are, of which an orientation must be of one device."""
        owners = {self._names[name].stream for name in roles.quaternion}
        if len(owners) > 1:
            names = ", ".join(roles.quaternion)
            raise InvalidInput(f"a quaternion must be of one device, got {names}; map one device's")
        self._roles = roles

    @property
    def num_fields(self) -> int:
        """Of the file whose rows are kept."""
        return len(self.columns) if self._clock is None else self._clock.source.num_fields

    @property
    def notes(self) -> Sequence[str]:
        """How many rows there are, and what was passed over."""
        said = []
        clock = "made" if self._clock is None else f"of {self._clock.name}"
        if self._others:
            said.append(
                f"{self._kept:,} of {self._made:,} rows {clock} where all devices have samples: "
                f"{self._span[0]:.6g} s to {self._span[1]:.6g} s; between samples "
                + ", ".join(f"{each.name} {each.method}" for each in self._others)
            )
        said += [
            f"delay: times of {each.name} taken {each.delay:g} s earlier"
            for each in self._streams
            if each.delay
        ]
        said += [note for each in self._streams for note in each.source.notes]
        for stream in self._others:
            if stream.equal:
                said.append(
                    f"warning: {stream.equal:,} samples of {stream.name} had the time before's"
                )
            if stream.dropped:
                said.append(f"{stream.dropped:,} bad samples of {stream.name} were passed over")
        return said

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read all devices side by side."""
        names = self._names
        for stream in self._others:
            asked, roles = names.wanted_of(stream, wanted), names.roles_of(stream, self._roles)
            stream.begin(asked, roles)
        row = 1
        for rows in self._rows(wanted):
            kept = self._common(rows.time)
            self._made, self._kept = self._made + len(kept), self._kept + int(kept.sum())
            if kept.any():
                chunk = self._chunk(rows, np.flatnonzero(kept), wanted, row)
                yield chunk
                row += chunk.rows
        self._require_rows()

    def _rows(self, wanted: Wanted) -> Iterator[_Rows]:
        """Times of rows, with all other devices read so far."""
        if self._clock is None:
            yield from self._at_rate()
            return
        last = -np.inf
        for chunk, time in self._clock.chunks(self._names.wanted_of(self._clock, wanted)):
            known = time[np.isfinite(time)]
            if len(known):
                self._require_order(chunk, time, last)
                last = float(known.max())
                self._read(float(known.min()), float(known.max()))
            yield _Rows(time, chunk, chunk.progress)
        for stream in self._others if self._by_rows else ():
            stream.read(np.inf, np.inf)

    def _require_order(self, chunk: Chunk, time: FloatArray, last: float) -> None:
        """Raise where the clock begins again, unless bad rows are passed over."""
        before = np.fmax.accumulate(np.concatenate([[last], time]))[:-1]
        falls = np.flatnonzero(time < before)
        if len(falls) and self._others and self._streams[0].strict:
            assert self._clock is not None
            row = int(falls[0])
            raise InvalidInput(
                f"{self._clock.place(chunk, row)}: time of a clock must increase, got "
                f"{time[row]:.12g} s after {before[row]:.12g} s; join one trial at a time, or pass "
                "over bad rows with --bad-rows skip"
            )

    def _at_rate(self) -> Iterator[_Rows]:
        assert self._rate is not None
        begin = max(stream.span()[0] for stream in self._streams)
        if not np.isfinite(begin):
            return
        first, k = float(np.ceil(begin * self._rate - 1e-6)), 0
        while True:
            time: FloatArray = (first + np.arange(k, k + CHUNK_ROWS, dtype=float)) / self._rate
            self._read(float(time[0]), float(time[-1]))
            end = min(stream.span()[1] for stream in self._streams)
            time = time[time <= end]
            if not len(time):
                return
            place = f"{self._streams[0].path} at join_rate"
            self._limits.require("rows", k + len(time), place, "lower it")
            yield _Rows(time, None, min(stream.progress for stream in self._streams))
            if len(time) < CHUNK_ROWS:
                return
            k += CHUNK_ROWS

    def _read(self, first: float, last: float) -> None:
        for stream in self._others:
            stream.read(first, last)

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

    def _chunk(self, rows: _Rows, index: IntArray, wanted: Wanted, first_row: int) -> Chunk:
        at, clock = rows.time[index], rows.chunk
        place = {name: self._names[name] for name in wanted.names if name != TIME}
        read: dict[Stream | None, Mapping[str, FloatArray]] = {}
        held: dict[Stream | None, Mapping[str, Column]] = {}
        for stream in self._others:
            read[stream], held[stream] = stream.numbers_at(at), stream.carried_at(at)
        own: dict[str, str] = {}
        if self._clock is not None and clock is not None:
            own = {name: c.name for name, c in place.items() if c.stream is self._clock}
            read[self._clock] = {name: each[index] for name, each in clock.numbers.items()}
            held[self._clock] = {name: each[index] for name, each in clock.carried.items()}
            if self._clock.time_column:
                own[TIME] = self._clock.time_column
        made = {n: read[place[n].stream][place[n].name] for n in wanted.numbers if n != TIME}
        if TIME in wanted.numbers:
            made[TIME] = self._time(rows, index)
        first = self._clock is self._streams[0]
        return JoinedChunk(
            numbers=made,
            carried={n: held[place[n].stream][place[n].name] for n in wanted.carried},
            rows=len(index),
            first_row=first_row,
            progress=rows.progress,
            rules={n: clock.rules.get(c, clock.rule) for n, c in own.items()} if clock else {},
            bad={n: clock.bad[c][index] for n, c in own.items() if clock and c in clock.bad},
            fields=None if clock is None or clock.fields is None else clock.fields[index],
            clock=clock,
            whose="" if first or self._clock is None else f" of {self._clock.path}",
            index=index,
            own=own,
            owner={name: c.stream.name for name, c in place.items()},
        )

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
            none = "" if self._clock is None else f" and no row of {self._clock.name} there"
            raise InvalidInput(
                f"{self._streams[0].path}: devices must have samples at the same time, got {spans}"
                f"{none}; look at their units of time and delays"
            )
