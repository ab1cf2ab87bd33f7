"""Files of several devices that record one trial: their clocks, and how they are joined."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

from coopenv.arrays import number
from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.stamps import is_form, require_form
from coopenv.logs.declared.units import known_unit
from coopenv.logs.limits import shown

METHODS = ("linear", "nearest", "previous")
JOINS = (*METHODS, "rows")
FILLS = ("none", *METHODS)
MOST = 64  # devices


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """One of the files that are joined."""

    name: str
    path: str = ""  # the recording itself if empty; else beside it, if relative
    part: str = ""  # topic of a bag, group of HDF5, structure of MATLAB: a stream of its own
    time: str = ""  # its column of time, "time" unless said
    unit: str = ""  # of its time, or its form; as the layout says if empty
    rate: float | None = None  # [Hz] of its rows where it has no column of time
    start: float = 0.0  # [s] time of its first row then
    delay: float = 0.0  # [s] what happened is stamped so much later
    method: str = ""  # of `METHODS`; as the layout says if empty
    dialect: Dialect = field(default_factory=Dialect)


@dataclass(frozen=True, slots=True, kw_only=True)
class Joining(Dialect):
    """How files of several devices become one recording, and gaps in it are filled.

    Raises
    ------
    InvalidInput
        If a field is of another type or beyond its rule.
    UnknownName
        If a name is none of those there are.
    """

    sample_rate: float | None = None  # [Hz] of rows, where the recording has no column of time
    join: tuple[str, ...] = ()  # files beside it, NAME=PATH or PATH
    files: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # name -> fields of it
    clock: str = ""  # the device whose rows are kept; the recording itself if empty
    join_rate: float | None = None  # [Hz] rows are made at this rate instead
    join_method: str = "linear"  # or "nearest", "previous", or "rows": one beside the other
    fill: str = "none"  # gaps: "linear", "nearest", "previous"
    longest_gap: float = 0.1  # [s] between samples that is bridged, in joining and filling

    def __post_init__(self):
        Dialect.__post_init__(self)
        for name in ("sample_rate", "join_rate", "longest_gap"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _positive(value, name))
        for name, known in (("join_method", JOINS), ("fill", FILLS)):
            if getattr(self, name) not in known:
                raise UnknownName(name, getattr(self, name), known)
        if not isinstance(self.clock, str):
            raise InvalidInput(f"clock must be a device, got {shown(self.clock)}; give its name")
        said = (self.join,) if isinstance(self.join, str) else self.join
        if not isinstance(said, tuple | list) or not all(isinstance(each, str) for each in said):
            raise InvalidInput(f"join must be files, got {shown(said)}; list them as NAME=PATH")
        object.__setattr__(self, "join", tuple(said))
        if not isinstance(self.files, Mapping) or not all(
            isinstance(each, Mapping) for each in self.files.values()
        ):
            raise InvalidInput(
                f"files must be tables of fields by the names of devices, got {shown(self.files)}; "
                "write [files.left]"
            )
        self.devices("recording")  # raises where one is wrong

    @property
    def dialect(self) -> Dialect:
        """How texts are written."""
        return Dialect(**{each.name: getattr(self, each.name) for each in fields(Dialect)})

    @property
    def joins(self) -> bool:
        """Whether times are those of devices, which the layout names."""
        return bool(self.files or self.join or self.join_rate or self.sample_rate)

    def devices(self, itself: str) -> tuple[Device, ...]:
        """All that are joined, the recording itself first; alone where nothing is joined.

        Parameters
        ----------
        itself
            Name of the recording, if the layout gives it none.
        """
        made = [_device(name, said, self.dialect) for name, said in self.files.items()]
        own = [each for each in made if not each.path and not each.part]
        if len(own) > 1:
            raise InvalidInput(
                f"files must name the recording itself once, got {own[0].name!r} and "
                f"{own[1].name!r} without a path; add their paths"
            )
        streams = any(not each.path and each.part for each in made)
        first = own or [Device(name=itself, dialect=self.dialect)] * (not streams)
        if first and first[0].rate is None and self.sample_rate is not None:
            first = [replace(first[0], rate=self.sample_rate)]
        made = [*first, *(each for each in made if each not in own)]
        for said in self.join:
            name, equals, path = said.partition("=")
            if not equals:
                name, path = Path(said).name.split(".")[0], said
            if not path or not name:
                raise InvalidInput(
                    f"join must be files, got {shown(said)!r}; write NAME=PATH, as left=left.csv"
                )
            made.append(Device(name=name, path=str(Path(path).absolute()), dialect=self.dialect))
        names = [each.name for each in made]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise InvalidInput(
                f"devices must have different names, got {twice!r} twice; write NAME=PATH"
            )
        if len(made) > MOST:
            raise InvalidInput(f"join must be at most {MOST} files, got {len(made)}; join fewer")
        return tuple(made)


def _device(name: str, said: Mapping[str, Any], dialect: Dialect) -> Device:
    """A device as a layout describes it."""
    own = [each.name for each in fields(Device) if each.name not in ("name", "dialect")]
    written = [each.name for each in fields(Dialect)]
    for key in said:
        if key not in (*own, *written):
            raise UnknownName(f"field of files.{name}", key, (*own, *written))
    try:
        given = {key: said[key] for key in own if key in said}
        for key in ("path", "part", "time", "unit", "method"):
            if not isinstance(given.get(key, ""), str):
                raise InvalidInput(f"{key} must be a word, got {shown(given[key])}; quote it")
        if "rate" in given:
            given["rate"] = _positive(given["rate"], "rate")
        for key in ("start", "delay"):
            if key in given:
                given[key] = number(given[key], key)
        if given.get("method", "linear") not in METHODS:
            raise UnknownName("method", given["method"], METHODS)
        unit = given.get("unit", "")
        if is_form(unit):
            require_form(unit)
        elif unit:
            given["unit"] = known_unit("time", unit)
        forms = {key: said[key] for key in written if key in said}
        return Device(name=name, dialect=replace(dialect, **forms), **given)
    except CoopenvError as error:
        error.args = (f"files.{name}: {error}",)
        raise


def _positive(value: Any, name: str) -> float:
    given = number(value, name)
    if given <= 0 or not math.isfinite(1 / given):
        raise InvalidInput(f"{name} must be positive, got {value!r}; change it")
    return given
