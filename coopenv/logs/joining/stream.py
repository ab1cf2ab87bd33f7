"""Samples of one device, read as far as somebody asks for and forgotten when they are over."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.files import reading
from coopenv.logs.declared.devices import Device
from coopenv.logs.declared.stamps import ISO, Origin, Stamps, is_form
from coopenv.logs.declared.units import UNITS, known_unit
from coopenv.logs.formats import open_source
from coopenv.logs.formats.chunks import Chunk, Column, Owner, Roles, Wanted
from coopenv.logs.joining.between import interpolated, neighbours, slerped
from coopenv.logs.layout import Layout
from coopenv.logs.limits import shown


class Stream:
    """A device's file.

    Parameters
    ----------
    device
        As declared.
    path
        Of its file.
    layout
        Of the recording.
    origin
        Of times as text, common to all devices.
    by_rows
        Whether its time is the number of its row.
    strict
        Whether a sample that is damaged is an error, rather than none.
    """

    def __init__(
        self,
        device: Device,
        path: Path,
        layout: Layout,
        origin: Origin,
        *,
        by_rows: bool = False,
        strict: bool = True,
    ):
        self.name, self.path, self._device, self._by_rows = device.name, path, device, by_rows
        self.source = open_source(path, device.dialect, layout.limits, device.part)
        self.method = "nearest" if by_rows else device.method or layout.join_method
        self.gap = 0.5 if by_rows else layout.longest_gap
        self.time_column = self._time_column(layout)
        unit = device.unit or layout.time
        said = self.source.units.get(self.time_column, "")
        if self.time_column and self.time_column == self.source.stamped:
            unit = ISO
        elif said and not device.unit:
            unit = known_unit("time", said)
        self._stamps = Stamps(unit, origin) if is_form(unit) else None
        self._factor = 1.0 if self._stamps is not None else UNITS["time"][unit]
        self.strict = strict
        self.rows = self.equal = self.dropped = 0  # read; with the stamp before; damaged
        self.first, self.last, self.ended = np.nan, -np.inf, False
        self.progress = 0.0  # share of the file that has been read

    @property
    def delay(self) -> float:
        """By which its stamps are late [s]."""
        return self._device.delay

    @property
    def owner(self) -> Owner:
        """Who it is, for those to whom it lends columns."""
        return Owner(self.name, f"{self.path}", self._device.part, self.delay)

    @property
    def columns(self) -> list[str]:
        """All but that of time."""
        return [name for name in self.source.columns if name != self.time_column]

    def begin(self, wanted: Wanted, roles: Roles) -> None:
        """From the first sample, these columns."""
        self._wanted, self._roles = wanted, roles
        self._chunks = self.chunks(wanted)
        self._time: FloatArray = np.zeros(0)
        self._values: dict[str, FloatArray] = {name: np.zeros(0) for name in wanted.numbers}
        self._others: dict[str, Column] = {}
        self.rows, self.last, self.ended = 0, -np.inf, False
        while self._read() and not len(self._time):
            pass
        self.first = float(self._time[0]) if len(self._time) else np.nan

    def chunks(self, wanted: Wanted) -> Iterator[tuple[Chunk, FloatArray]]:
        """Pieces of the file, and the time of each row [s]; NaN where there is none."""
        column, row = self.time_column, 0
        asked = dict.fromkeys([*wanted.numbers, *[column] * bool(column)])
        stamps = {column: self._stamps} if column and self._stamps is not None else {}
        chunks = self.source.chunks(Wanted(list(asked), wanted.carried, stamps))
        while True:
            with reading(self.path):
                chunk = next(chunks, None)
            if chunk is None:
                return
            yield chunk, self._times(chunk, row)
            row += chunk.rows

    def read(self, first: float, last: float) -> None:
        """Read what is needed between two times, up to where every column has a later sample.

        What is of no use for the first of them and later ones is dropped.
        """
        self._forget(first)
        while not self.ended and self.last <= last + self.gap and not self._covers(last):
            self._read()
            self._forget(first)

    def _forget(self, time: float) -> None:
        kept = slice(int(np.searchsorted(self._time, time - 2 * self.gap)), None)
        self._time = self._time[kept]
        self._values = {name: values[kept] for name, values in self._values.items()}
        self._others = {name: values[kept] for name, values in self._others.items()}

    def span(self) -> tuple[float, float]:
        """Times between which it has something to say; later ones may come while it is read."""
        early, late = {"linear": (0, 0), "previous": (0, 1)}.get(self.method, (1, 1))
        last = self.last + late * self.gap if self.ended else np.inf
        return self.first - early * self.gap, last

    def numbers_at(self, at: FloatArray) -> dict[str, FloatArray]:
        """Values ``(T,)`` of every column at these times; NaN where no sample is near."""
        roles = self._roles
        made: dict[str, FloatArray] = {}
        quaternion = [name for name in roles.quaternion if name in self._values]
        if quaternion:
            values = np.stack([self._values[name] for name in quaternion], axis=1)
            turned = slerped(self._time, values, at, self.method, self.gap)
            made = {name: turned[:, j] for j, name in enumerate(quaternion)}
        for name, values in self._values.items():
            if name not in made:
                period = roles.period if name == roles.angle else 0.0
                made[name] = interpolated(self._time, values, at, self.method, self.gap, period)
        return made

    def carried_at(self, at: FloatArray) -> dict[str, Column]:
        """What the nearest sample carries, or the one before; nothing where none is near."""
        method = "previous" if self.method == "previous" else "nearest"
        found = neighbours(self._time, at, method, self.gap)
        made: dict[str, Column] = {}
        for name, values in self._others.items():
            text = values.dtype.kind in "OU"
            kept = values[found.before] if len(values) else np.full(len(at), "", object)
            if text or not found.near.all():
                kept = kept.astype(object if text or kept.dtype.kind not in "biuf" else np.float64)
                kept[~found.near] = "" if kept.dtype == object else np.nan
            made[name] = kept
        return made

    def place(self, chunk: Chunk, row: int) -> str:
        """File and line of a row."""
        return f"{self.path}, {chunk.place(row)}"

    def _covers(self, time: float) -> bool:
        return all(
            len(values) and np.isfinite(values[self._time >= time]).any()
            for values in self._values.values()
        ) and bool(len(self._time) and self._time[-1] >= time)

    def _read(self) -> bool:
        """The next piece; whether there was one."""
        found = next(self._chunks, None)
        if found is None:
            self.ended, self.progress = True, 1.0
            return False
        chunk, time = found
        self.progress = chunk.progress
        self.rows += chunk.rows
        usable = self._usable(chunk, time)
        kept = {name: chunk.numbers[name][usable] for name in self._wanted.numbers}
        others = {name: chunk.carried[name][usable] for name in self._wanted.carried}
        self._time = np.concatenate([self._time, time[usable]])
        self._values = {
            name: np.concatenate([self._values[name], each]) for name, each in kept.items()
        }
        if len(next(iter(self._others.values()), ())):
            others = {k: np.concatenate([self._others[k], each]) for k, each in others.items()}
        self._others = others
        if len(self._time):
            self.last = float(self._time[-1])
        return True

    def _usable(self, chunk: Chunk, time: FloatArray) -> np.ndarray:
        """Which rows ``(T,)`` are samples; raises at damaged ones, unless they are passed over."""
        column = self.time_column or "time"
        whole = chunk.whole & np.isfinite(time)
        known = np.concatenate([[self.last], np.where(whole, time, -np.inf)])
        before = np.maximum.accumulate(known)[:-1]
        equal = whole & (time == before)
        falls = whole & (time < before)
        faults = [
            (~chunk.whole, lambda row: " must have as many fields as the header, got another line"),
            (
                chunk.whole & ~np.isfinite(time),
                lambda row: (
                    f", column {column!r} must be {chunk.rules.get(column, 'a finite number')}, "
                    f"got {shown(chunk.text(row, column))!r}"
                ),
            ),
            (falls, lambda row: f", column {column!r} must increase, got {time[row]:.12g} s later"),
        ]
        for name in self._wanted.numbers:
            bad = np.isinf(chunk.numbers[name]) | chunk.bad.get(name, False)
            faults.append(
                (
                    whole & bad,
                    lambda row, name=name: (
                        f", {chunk.called(name)} must be {chunk.rules.get(name, chunk.rule)}, got "
                        f"{shown(chunk.text(row, name))!r}"
                    ),
                )
            )
        wrong = np.zeros(chunk.rows, np.bool_)
        for rows, describe in faults:
            if rows.any() and self.strict:
                row = int(np.flatnonzero(rows)[0])
                raise InvalidInput(
                    f"{self.place(chunk, row)}{describe(row)}; repair it, or pass over bad rows "
                    "with --bad-rows skip"
                )
            wrong |= rows
        self.dropped += int(wrong.sum())
        self.equal += int(equal.sum())
        return ~wrong & ~equal

    def seconds(self, chunk: Chunk) -> FloatArray:
        """What its column of time says ``(T,)`` [s]."""
        with np.errstate(over="ignore", invalid="ignore"):
            return chunk.numbers[self.time_column] * self._factor - self._device.delay

    def _times(self, chunk: Chunk, row: int) -> FloatArray:
        """By which the rows are joined."""
        device = self._device
        if self._by_rows:
            return np.arange(row, row + chunk.rows, dtype=np.float64)
        if device.rate is not None:
            return device.start - device.delay + np.arange(row, row + chunk.rows) / device.rate
        return self.seconds(chunk)

    def _time_column(self, layout: Layout) -> str:
        """Its column of time; none if empty."""
        device, source = self._device, self.source
        mapped = layout.columns.get("time", "time")
        wanted = device.time or mapped or "time"
        source.offer([wanted])
        there = wanted if wanted in source.columns else "time" * ("time" in source.columns)
        if device.rate is not None:
            there = there or next((c for c in source.columns if c.strip().lower() == "time"), "")
            if there and mapped and not device.time:
                raise InvalidInput(
                    f"{self.path}: sample_rate must be left out where there is a column of time, "
                    f"got column {there!r}; leave it out, or say --map time="
                )
            return ""
        if device.time and there != device.time:
            raise InvalidInput(
                f"{self.path}: time of {self.name} must be one of its columns, got "
                f"{shown(device.time)!r}; has: {', '.join(map(shown, source.columns[:30]))}"
            )
        if not there and not self._by_rows:
            raise InvalidInput(
                f"{self.path}: column {wanted} must be there to join it, got none of that name; "
                f"say time or rate under [files.{self.name}], or --join-method rows; has: "
                f"{', '.join(map(shown, source.columns[:30]))}"
            )
        return there
