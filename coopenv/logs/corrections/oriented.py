"""A source whose orientation is written otherwise than documented, with documented columns.

It stands next to the file, before devices are joined and gaps filled: only a quaternion can be
turned evenly from one sample to the next.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np

from coopenv.arrays import BoolArray
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.orientation import heading, quaternions
from coopenv.logs.columns import ORIENTATION
from coopenv.logs.declared.units import factor_of
from coopenv.logs.formats.chunks import Chunk, Roles, Source, Wanted
from coopenv.logs.layout import Layout

MADE = (*ORIENTATION[3], *ORIENTATION[2])


def written_in(layout: Layout) -> tuple[str, ...]:
    """Columns in which ``[pose]`` says that the orientation is; none where it is as documented."""
    pose = layout.pose
    if not pose.columns and pose.order in (None, "wxyz"):
        return ()
    return pose.columns or tuple(ORIENTATION[3])


def oriented(
    source: Source, path: str, layout: Layout, used: tuple[str, ...] | None = None
) -> Source:
    """The source as it is, or with the columns qw … qz and theta made from those of ``[pose]``.

    Parameters
    ----------
    source
        Of a file.
    path
        Of it, for messages.
    layout
        As declared.
    used
        What the columns of ``[pose]`` are called in this source, if otherwise.

    Raises
    ------
    InvalidInput
        If a column that the layout names is not there.
    """
    used = written_in(layout) if used is None else used
    if not used:
        return source
    source.offer(used)
    for name in used:
        if name not in source.columns:
            raise InvalidInput(
                f"{path}: pose.columns must be columns of the file, got {name!r}; has: "
                f"{', '.join(source.columns[:30])}"
            )
    return _Oriented(source, path, layout, used)


class _Oriented(Source):
    """Another source, read with more columns than it has."""

    def __init__(self, source: Source, path: str, layout: Layout, used: tuple[str, ...]):
        self._source, self._used, self._pose = source, used, layout.pose
        self._angle = layout.factor("angle")
        angles = layout.pose.orientation == "euler"
        self._factors = [
            factor_of(path, name, "angle", source.units[name], layout.angle)
            if angles and name in source.units
            else self._angle * angles or 1.0
            for name in used
        ]
        self.stamped = source.stamped
        self._take()

    def _take(self) -> None:
        source = self._source
        own = [name for name in source.columns if name not in self._used]
        self.made = tuple(name for name in MADE if name not in own)
        self.columns = [*own, *self.made]
        self.units = {name: unit for name, unit in source.units.items() if name in own}
        self.repeated = [name for name in source.repeated if name not in self._pose.columns]
        self.left_out, self.grips = source.left_out, source.grips

    @property
    def num_fields(self) -> int:
        """As the file has them."""
        return self._source.num_fields

    @property
    def notes(self) -> Sequence[str]:
        """See `Source`."""
        return self._source.notes

    def offer(self, names: Iterable[str]) -> None:
        """See `Source`."""
        self._source.offer([name for name in names if name not in self.made])
        self._take()

    def assign(self, roles: Roles) -> None:
        """See `Source`; what is made of others is nothing to it."""
        self._source.assign(roles._replace(quaternion=(), angle=""))

    def chunks(self, wanted: Wanted) -> Iterator[Chunk]:
        """Read the source's, and make the others of them."""
        made = [name for name in wanted.numbers if name in self.made]
        rest = [name for name in wanted.numbers if name not in made]
        read = list(dict.fromkeys([*rest, *self._used])) if made else rest
        for chunk in self._source.chunks(wanted._replace(numbers=read)):
            yield self._with(chunk, rest, made) if made else chunk

    def _with(self, chunk: Chunk, rest: list[str], made: list[str]) -> Chunk:
        values = np.stack([chunk.numbers[name] for name in self._used], axis=-1)
        quaternion = quaternions(values * self._factors, self._pose.orientation, self._pose.order)
        columns = dict(zip(ORIENTATION[3], quaternion.T, strict=True))
        columns["theta"] = heading(quaternion) / self._angle
        numbers = {name: chunk.numbers[name] for name in rest}
        numbers |= {name: columns[name] for name in made}
        bad = {name: each for name, each in chunk.bad.items() if name in rest}
        wrong = [chunk.bad[name] for name in self._used if name in chunk.bad]
        if wrong:
            any_wrong: BoolArray = np.logical_or.reduce(wrong)
            bad |= dict.fromkeys(made, any_wrong)
        same = {each.name: getattr(chunk, each.name) for each in fields(Chunk)}
        same |= {"numbers": numbers, "bad": bad}
        return _OrientedChunk(**same, read=chunk, made=tuple(made), used=self._used)


@dataclass(frozen=True, slots=True, kw_only=True)
class _OrientedChunk(Chunk):
    """Rows that are named as in the chunk from which they are made."""

    read: Chunk
    made: tuple[str, ...]
    used: tuple[str, ...]

    def place(self, row: int) -> str:
        return self.read.place(row)

    def called(self, column: str) -> str:
        if column not in self.made:
            return self.read.called(column)
        return f"columns {', '.join(self.used)}, which make {column!r},"

    def text(self, row: int, column: str) -> str:
        if column not in self.made:
            return self.read.text(row, column)
        return ", ".join(self.read.text(row, each) for each in self.used)
