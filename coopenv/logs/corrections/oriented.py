"""A source whose orientation is written otherwise than documented, with documented columns."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from coopenv.errors import InvalidInput
from coopenv.logs.calibration.orientation import heading, quaternions
from coopenv.logs.columns import ORIENTATION
from coopenv.logs.formats.chunks import Chunk, Source
from coopenv.logs.layout import Layout

MADE = (*ORIENTATION[3], *ORIENTATION[2])


def oriented(source: Source, path: str, layout: Layout) -> Source:
    """The source as it is, or with the columns qw … qz and theta made from those of ``[pose]``.

    Raises
    ------
    InvalidInput
        If a column that the layout names is not there, or one of the made ones is there already.
    """
    pose = layout.pose
    if not pose.columns and pose.order in (None, "wxyz"):
        return source
    columns = pose.columns or ORIENTATION[3]
    for name in columns:
        if name not in source.columns:
            raise InvalidInput(
                f"{path}: pose.columns must be columns of the file, got {name!r}; has: "
                f"{', '.join(source.columns[:30])}"
            )
    return _Oriented(source, layout, tuple(columns))


class _Oriented(Source):
    """Another source, read with more columns than it has."""

    def __init__(self, source: Source, layout: Layout, used: tuple[str, ...]):
        self._source, self._used = source, used
        self._pose, self._angle = layout.pose, layout.factor("angle")
        own = [name for name in source.columns if name not in used]
        self._made = [name for name in MADE if name not in own]
        self.columns = [*own, *self._made]
        self.left_out, self.grips = source.left_out, source.grips

    def chunks(self, numbers: Sequence[str], carried: Sequence[str]) -> Iterator[Chunk]:
        """Read the source's, and make the others of them."""
        made = [name for name in numbers if name in self._made]
        rest = [name for name in numbers if name not in made]
        read = list(dict.fromkeys([*rest, *self._used])) if made else rest
        wanted = [name for name in carried if name not in self._made]
        for chunk in self._source.chunks(read, wanted):
            if made:
                yield self._with(chunk, rest, made)
            else:
                yield chunk

    def _with(self, chunk: Chunk, rest: list[str], made: list[str]) -> Chunk:
        values = np.stack([chunk.numbers[name] for name in self._used], axis=-1)
        if self._pose.orientation == "euler":
            values = values * self._angle
        quaternion = quaternions(values, self._pose.orientation, self._pose.order)
        columns = dict(zip(ORIENTATION[3], quaternion.T, strict=True))
        columns["theta"] = heading(quaternion) / self._angle
        numbers = {name: chunk.numbers[name] for name in rest}
        numbers |= {name: columns[name] for name in made}
        return _OrientedChunk(
            numbers=numbers,
            carried=chunk.carried,
            rows=chunk.rows,
            first_row=chunk.first_row,
            progress=chunk.progress,
            rule=chunk.rule,
            fields=chunk.fields,
            read=chunk,
            made=tuple(made),
            used=self._used,
        )


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
