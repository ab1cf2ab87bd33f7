"""Missing values between the samples of slower devices, filled by a declared rule up to a gap."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.errors import InvalidInput
from coopenv.logs.formats.chunks import Chunk, Roles, Source, Wanted
from coopenv.logs.joining.between import interpolated, slerped
from coopenv.logs.layout import Layout

HELD = 64  # pieces of a file that wait for the end of a gap


class FilledSource(Source):
    """A source whose missing values are filled; those that are no numbers stay what they are.

    Parameters
    ----------
    source
        Of which values are missing.
    layout
        Says how, up to which gap.
    """

    def __init__(self, source: Source, layout: Layout):
        self._source, self._method, self._gap = source, layout.fill, layout.longest_gap
        self._roles = Roles()
        self._filled = 0
        self._take()

    def _take(self) -> None:
        source = self._source
        self.columns, self.left_out, self.grips = source.columns, source.left_out, source.grips
        self.units, self.repeated, self.made = source.units, source.repeated, source.made
        self.owners = source.owners

    @property
    def num_fields(self) -> int:
        """See `Source`."""
        return self._source.num_fields

    def offer(self, names: Iterable[str]) -> None:
        """See `Source`."""
        self._source.offer(names)
        self._take()

    def assign(self, roles: Roles) -> None:
        """See `Source`."""
        self._source.assign(roles)
        self._roles = roles
        if not roles.time:
            raise InvalidInput("fill must have times, got no column of them; say --sample-rate")

    @property
    def notes(self) -> Sequence[str]:
        """How many values were filled."""
        rule = f"{self._method}, in gaps of at most {self._gap:g} s"
        return [*self._source.notes, f"{self._filled:,} missing values filled: {rule}"]

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Pieces of the source, each once it is known what comes after its gaps."""
        samples = _Samples([name for name in wanted.numbers if name != self._roles.time], self._gap)
        waiting: deque[tuple[Chunk, FloatArray]] = deque()
        for chunk in self._source.chunks(wanted):
            waiting.append((chunk, samples.add(chunk, self._roles)))
            while waiting and samples.settled(waiting[0][1]):
                done, time = waiting.popleft()
                yield self._complete(done, time, samples)
                samples.forget(waiting[0][1] if waiting else np.fmax.reduce(time, keepdims=True))
            if len(waiting) > HELD:
                raise InvalidInput(
                    f"longest_gap must be shorter than {HELD} pieces of a file of some thousand "
                    f"rows, got {self._gap:g} s; lower it"
                )
        for chunk, time in waiting:
            yield self._complete(chunk, time, samples)

    def _complete(self, chunk: Chunk, time: FloatArray, samples: "_Samples") -> Chunk:
        """A piece with what is missing."""
        made = dict(chunk.numbers)
        quaternion = self._roles.quaternion
        if quaternion and all(name in samples.values for name in quaternion):
            missing = np.any([_missing(chunk, name) for name in quaternion], axis=0)
            if missing.any():
                values = np.stack([samples.values[name] for name in quaternion], axis=1)
                turned = slerped(samples.time, values, time[missing], self._method, self._gap)
                for j, name in enumerate(quaternion):
                    made[name] = self._with(made[name], missing, turned[:, j])
        for name in samples.values:
            missing = _missing(chunk, name)
            if name not in quaternion and missing.any():
                period = self._roles.period if name == self._roles.angle else 0.0
                found = interpolated(
                    samples.time, samples.values[name], time[missing], self._method, self._gap,
                    period,
                )  # fmt: skip
                made[name] = self._with(made[name], missing, found)
        return replace(chunk, numbers=made)

    def _with(self, values: FloatArray, missing: BoolArray, found: FloatArray) -> FloatArray:
        self._filled += int(np.isfinite(found).sum())
        values = values.copy()
        values[missing] = found
        return values


class _Samples:
    """What columns say, for as long as it may be needed."""

    def __init__(self, names: Sequence[str], gap: float):
        self._gap = gap
        self.time: FloatArray = np.zeros(0)
        self.values: dict[str, FloatArray] = {name: np.zeros(0) for name in names}
        self._last, self._shift = np.nan, 0.0

    def add(self, chunk: Chunk, roles: Roles) -> FloatArray:
        """Append rows; returns their times ``(T,)`` [s], as if trials followed each other."""
        time = chunk.numbers[roles.time] * roles.factor
        known = np.isfinite(time) & chunk.whole
        there = time[known]
        if len(there):
            step = np.diff(there, prepend=there[0] if np.isnan(self._last) else self._last)
            shift = self._shift + np.cumsum(np.where(step < 0, 4 * self._gap - step, 0.0))
            self._last, self._shift = float(there[-1]), float(shift[-1])
            time = np.full(chunk.rows, np.nan)
            time[known] = there + shift
            self.time = np.concatenate([self.time, time[known]])
            for name, values in self.values.items():
                self.values[name] = np.concatenate([values, chunk.numbers[name][known]])
        return time

    def settled(self, time: FloatArray) -> bool:
        """Whether nothing that comes can be of use for these times."""
        last = np.nanmax(time) if np.isfinite(time).any() else -np.inf
        if len(self.time) and self.time[-1] > last + self._gap:
            return True
        later = self.time >= last
        return all(np.isfinite(values[later]).any() for values in self.values.values())

    def forget(self, time: FloatArray) -> None:
        """Drop what is of no use for these times and later ones."""
        if np.isfinite(time).any():
            first = np.nanmin(time) - 2 * self._gap
            kept = slice(int(np.searchsorted(self.time, first)), None)
            self.time = self.time[kept]
            self.values = {name: values[kept] for name, values in self.values.items()}


def _missing(chunk: Chunk, name: str) -> BoolArray:
    """Where a column ``(T,)`` says nothing, rather than something that is no number."""
    bad = chunk.bad.get(name)
    missing = np.isnan(chunk.numbers[name]) & chunk.whole
    return missing if bad is None else missing & ~bad
