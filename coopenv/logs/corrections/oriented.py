"""A source whose orientation is written otherwise than documented, with documented columns.

It stands next to the file, before devices are joined and gaps filled: only a quaternion can be
turned evenly from one sample to the next.
"""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from coopenv.arrays import BoolArray
from coopenv.errors import InvalidInput
from coopenv.logs.calibration.declared import ORIENTED
from coopenv.logs.calibration.orientation import IN_ANGLES, heading, quaternions, tilt
from coopenv.logs.columns import ORIENTATION
from coopenv.logs.declared.units import factor_of
from coopenv.logs.faults import QUATERNION_TOLERANCE
from coopenv.logs.formats.chunks import Chunk, Roles, Source, Wanted
from coopenv.logs.layout import Layout
from coopenv.logs.limits import shown

MADE = ORIENTED
MOST_TILT = 30.0  # [degrees] of the object's z axis against the world's in the plane
WHOLE = "a quaternion of unit length, or a rotation"
FLAT = (
    f"a turn about z that tilts it by at most {MOST_TILT:g}°, as the recording is in the plane "
    '(where y is up, exchange axes: pose.columns = ["qx", "-qz", "qy", "qw"])'
)


def written_in(layout: Layout) -> tuple[str, ...]:
    """Columns that hold the orientation, where it is not written as documented; else none.

    Those of ``[pose]``, or those that ``[columns]`` calls qw, qx, qy and qz, which by ``order`` are
    something else; a minus in front turns the sign.
    """
    pose = layout.pose
    if not pose.columns and pose.order in (None, "wxyz"):
        return ()
    return pose.columns or tuple(layout.columns.get(name, name) for name in ORIENTATION[3])


def as_made(layout: Layout) -> Layout:
    """The layout of a source that `oriented` made: its orientation is called as documented."""
    if not written_in(layout):
        return layout
    kept = {name: theirs for name, theirs in layout.columns.items() if name not in MADE}
    if not layout.pose.columns and layout.columns.get("theta") is not None:
        kept["theta"] = layout.columns["theta"]  # of its own
    return replace(layout, columns=kept)


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
    source.offer(name for each in used for name in (each, each.removeprefix("-")))
    plain = unsigned(used, source.columns)
    for name in plain:
        if name not in source.columns:
            raise InvalidInput(
                f"{path}: {key_of(layout)} must be columns of the file, got {name!r}; has: "
                f"{', '.join(map(shown, source.columns[:30]))}"
            )
    signs = [1.0 if name == each else -1.0 for name, each in zip(plain, used, strict=True)]
    return _Oriented(source, path, layout, plain, signs)


def key_of(layout: Layout) -> str:
    """What of the layout names the columns of the orientation, for messages."""
    return "pose.columns" if layout.pose.columns else "qw, qx, qy and qz, of which pose.order is,"


def unsigned(used: tuple[str, ...], columns: Collection[str]) -> tuple[str, ...]:
    """Columns without the minus that turns their sign; one may be called so."""
    return tuple(name if name in columns else name.removeprefix("-") for name in used)


class _Oriented(Source):
    """Another source, read with more columns than it has."""

    def __init__(
        self,
        source: Source,
        path: str,
        layout: Layout,
        used: tuple[str, ...],
        signs: Sequence[float],
    ):
        self._source, self._used, self._pose = source, used, layout.pose
        self._angle = layout.factor("angle")
        angles = layout.pose.orientation in IN_ANGLES
        self._factors = [
            sign * factor_of(path, name, "angle", source.units[name], layout.angle)
            if angles and name in source.units
            else sign * (self._angle * angles or 1.0)
            for name, sign in zip(used, signs, strict=True)
        ]
        self.stamped = source.stamped
        self._take()

    def _take(self) -> None:
        source = self._source
        own = [name for name in source.columns if name not in self._used]
        made = MADE if self._pose.columns else ORIENTATION[3]
        instead = [name for name in own if name in made]
        own = [name for name in own if name not in instead]
        self.made = tuple(name for name in MADE if name not in own)
        self.columns = [*own, *self.made]
        self.units = {name: unit for name, unit in source.units.items() if name in own}
        taken = (*self._used, *instead)
        self.repeated = [name for name in source.repeated if name not in taken]
        self.left_out, self.grips = (*source.left_out, *instead), source.grips

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
        tilted = tilt(quaternion) > np.radians(MOST_TILT)
        torn = abs(np.linalg.norm(quaternion, axis=-1) - 1) > QUATERNION_TOLERANCE
        numbers = {name: chunk.numbers[name] for name in rest}
        numbers |= {name: columns[name] for name in made}
        bad = {name: each for name, each in chunk.bad.items() if name in rest}
        wrong = [chunk.bad[name] for name in self._used if name in chunk.bad]
        if wrong:
            any_wrong: BoolArray = np.logical_or.reduce(wrong)
            bad |= dict.fromkeys(made, any_wrong)
        rules = dict(chunk.rules)
        for no_angle, rule in ((tilted, FLAT), (torn, WHOLE)):
            if "theta" in made and no_angle.any():
                numbers["theta"] = np.where(no_angle, np.nan, numbers["theta"])
                bad["theta"] = no_angle | bad.get("theta", False)
                rules["theta"] = rule
        same = {each.name: getattr(chunk, each.name) for each in fields(Chunk)}
        same |= {"numbers": numbers, "bad": bad, "rules": rules}
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
        return f"columns {', '.join(map(shown, self.used))}, which make {column!r},"

    def text(self, row: int, column: str) -> str:
        if column not in self.made:
            return self.read.text(row, column)
        return ", ".join(self.read.text(row, each) for each in self.used)
