"""Contents of a recorded file: columns with their ranges, arrays, its clock with rate and gaps."""

import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.files import reading
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.stamps import Stamps
from coopenv.logs.formats import open_source, parts_of
from coopenv.logs.formats.chunks import Column as Values
from coopenv.logs.formats.chunks import Source, Wanted
from coopenv.logs.inspected.clock import Clock, Ticks, form_of, time_column
from coopenv.logs.limits import Limits

WIDEST = 32  # columns of an array that are looked at one by one


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """A column, and what is in it."""

    name: str
    is_number: bool
    unit: str  # that the file says
    first: str  # value
    missing: int  # rows without a number
    low: float  # NaN where there is no number
    high: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Contents:
    """Result of `inspect_file`: of a file, or of one of the streams that it keeps apart."""

    path: str
    part: str  # topic or such; empty for the whole file
    rows: int
    columns: tuple[Seen, ...]
    shapes: dict[str, tuple[int, ...]]  # of arrays that have several columns
    left_out: tuple[str, ...]  # what is no column
    clock: Clock | None  # none where no column looks like time


def inspect_file(
    path: str | os.PathLike,
    dialect: Dialect | None = None,
    limits: Limits | None = None,
) -> list[Contents]:
    """Look through a file some thousand rows at a time; nothing is assumed of what it means.

    Parameters
    ----------
    path
        Of any format that `coopenv.logs.read` reads.
    dialect
        How it is written, if it is text.
    limits
        On what it may cost.

    Returns
    -------
    One, or one for each stream of a file that keeps several apart, such as topics of a bag.

    Raises
    ------
    InvalidInput
        If it cannot be read; the message says what would have to be declared.
    MissingExtra
        If reading it needs an extra.
    """
    given = (dialect or Dialect(), limits or Limits())
    return [_inspected(Path(path), part, *given) for part in parts_of(Path(path), limits) or [""]]


def _inspected(path: Path, part: str, dialect: Dialect, limits: Limits) -> Contents:
    source = open_source(path, dialect, limits, part)
    shapes = {name: shape for name, shape in source.shapes.items() if len(shape) > 1}
    source.offer(  # at once, as what is offered decides how many rows there are
        f"{name}:{':'.join(map(str, at))}"
        for name, shape in shapes.items()
        if name in source.left_out and math.prod(shape[1:]) <= WIDEST
        for at in np.ndindex(shape[1:])
    )
    with reading(path):
        first = _first_values(path, source)
        numbers = [name for name in first if _is_number(first[name], dialect.decimal)]
        time = time_column(source.columns, numbers, first)
        form = "" if time is None or time in numbers else form_of(first[time])
        stamps = {time: Stamps(form)} if time is not None and form else {}
        asked = [*numbers, *stamps]
        ticks, tallies, rows = Ticks(), {name: _Tally() for name in numbers}, 0
        for chunk in source.chunks(Wanted(asked, stamps=stamps)):
            rows += chunk.rows
            for name, tally in tallies.items():
                tally.add(chunk.numbers[name])
            if time in asked:
                ticks.add(chunk.numbers[time])
    columns = tuple(_seen(name, source, first[name], tallies.get(name)) for name in source.columns)
    clock = None
    if time is not None and time in asked:
        clock = ticks.clock(time, form, source.units.get(time, ""))
    return Contents(
        path=os.fspath(path),
        part=part,
        rows=rows,
        columns=columns,
        shapes=shapes,
        left_out=tuple(source.left_out),
        clock=clock,
    )


def _seen(name: str, source: Source, first: Values, tally: "_Tally | None") -> Seen:
    return Seen(
        name=name,
        is_number=tally is not None,
        unit=source.units.get(name, ""),
        first=str(first[0])[:40] if len(first) else "",
        missing=0 if tally is None else tally.missing,
        low=math.nan if tally is None else tally.low,
        high=math.nan if tally is None else tally.high,
    )


class _Tally:
    """Range of a column that comes chunk by chunk."""

    def __init__(self):
        self.missing, self.low, self.high = 0, math.nan, math.nan

    def add(self, values: FloatArray) -> None:
        """Append rows."""
        there = values[np.isfinite(values)]
        self.missing += len(values) - len(there)
        if len(there):
            self.low = float(np.fmin(self.low, there.min()))
            self.high = float(np.fmax(self.high, there.max()))


def _first_values(path: Path, source: Source) -> dict[str, Values]:
    """What the first rows have in every column, as the file has it."""
    chunk = next(iter(source.chunks(Wanted([], source.columns))), None)
    if chunk is None:
        raise InvalidInput(f"{path} must have rows of data, got none; record some")
    return {name: chunk.carried[name][:1000] for name in source.columns}


def _is_number(values: Values, decimal: str) -> bool:
    """Whether most of what is said is a number."""
    if values.dtype.kind in "fiu":
        return True
    if values.dtype.kind not in "OUS":
        return False
    said = [text for each in values.tolist() if (text := str(each).strip()) not in ("", "None")]
    return bool(said) and sum(_reads(text, decimal) for text in said) > 0.9 * len(said)


def _reads(text: str, decimal: str) -> bool:
    try:
        float(text.replace(decimal, "."))
    except ValueError:
        return False
    return True


def names_of(contents: Iterable[Contents]) -> list[str]:
    """Short names of files and streams that differ, as ``[files]`` of a layout calls them."""
    made: list[str] = []
    for each in contents:
        name = each.part or Path(each.path).name.split(".")[0] or "recording"
        made.append(name if name not in made else f"{name}_{len(made) + 1}")
    return made
