"""Layout of a recorded file: names of columns, frames, units, and where the effectors hold."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, finite_array, whole
from coopenv.errors import CoopenvError, InvalidInput, UnknownName
from coopenv.logs.calibration.body import Body
from coopenv.logs.calibration.declared import (
    checked_tables,
    located,
    require_one_orientation,
)
from coopenv.logs.calibration.processing import Filters, Pose
from coopenv.logs.calibration.sensor import Sensor
from coopenv.logs.columns import is_documented
from coopenv.logs.declared.devices import Joining
from coopenv.logs.declared.dialect import require_flag
from coopenv.logs.declared.stamps import is_form, require_form
from coopenv.logs.declared.units import UNITS, known_unit
from coopenv.logs.layoutfile import load_fields
from coopenv.logs.limits import Limits, shown

LARGEST = 1e50  # of what is measured, in SI units: products of it are numbers still

LIMITS = Limits()
TABLES = ("columns", "files", "sensors", "pose", "filters", "body")  # fields that no option says
CHOICES = {
    "frame": ("object", "world"),
    "twist_frame": ("object", "world"),
    "grip_frame": ("object", "world"),
    "y": ("up", "down"),
    "space": ("auto", "plane", "space"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout(Joining):
    """How to understand a file; the default is the documented columns in SI units.

    Raises
    ------
    UnknownName
        If a column, frame or unit is none of those there are.
    InvalidInput
        If a field is of another type, the grips are no such numbers, or a column that is mapped
        is not a documented one.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    """Documented name → name in the file. A minus in front turns the sign (``-Fx``); an empty
    name says that the file has no such column."""
    grips: tuple[tuple[float, ...], ...] | tuple[float, ...] | None = None
    """Where the effectors hold, ``(n, 2)`` or ``(n, 3)`` or its numbers one after the other, in the
    object frame and the unit of lengths."""
    frame: str = "object"  # of forces and torques: "object" or "world"
    twist_frame: str | None = None  # as frame unless said
    grip_frame: str = "object"  # of the columns of grips; "world" needs the object's position
    y: str = "up"  # "down" turns the sign of y, planar torques and angles
    space: str = "auto"  # "plane" leaves out what points out of it, "space" wants all of it
    forces_only: bool = False  # the effectors apply no torque, and the file has none
    trial_columns: tuple[str, ...] = ("pair", "condition", "trial")  # a new value: a new trial
    time: str = "s"  # or "iso", or a form as "%H:%M:%S.%f": counted from the first row then
    length: str = "m"
    angle: str = "rad"
    velocity: str = "m/s"
    angular_velocity: str = "rad/s"
    force: str = "N"
    torque: str = "N*m"
    sensors: Mapping[int, Sensor] = field(default_factory=dict)  # number of the effector -> its own
    pose: Pose = field(default_factory=Pose)  # how it is written, of which point, when
    filters: Filters = field(default_factory=Filters)
    body: Body = field(default_factory=Body)  # the object, where it is known
    # the most that a file may have, so that none costs more than it should; see Limits
    max_row_bytes: int = LIMITS.row_bytes
    max_columns: int = LIMITS.columns
    max_effectors: int = LIMITS.effectors
    max_rows: int = LIMITS.rows
    max_block_bytes: int = LIMITS.block_bytes

    def __post_init__(self):
        Joining.__post_init__(self)
        if self.twist_frame is None:
            object.__setattr__(self, "twist_frame", self.frame)
        for name in (*CHOICES, *UNITS):
            if not isinstance(getattr(self, name), str):
                raise InvalidInput(
                    f"{name} must be a word, got {shown(getattr(self, name))}; see "
                    "docs/recordings.md for those that are known"
                )
        for name, checked in checked_tables(self).items():
            object.__setattr__(self, name, checked)
        for limit in fields(Limits):
            name = f"max_{limit.name}"
            object.__setattr__(self, name, whole(getattr(self, name), name, at_least=1))
        for name, known in CHOICES.items():
            if getattr(self, name) not in known:
                raise UnknownName(name, getattr(self, name), known)
        for quantity in UNITS:
            said = getattr(self, quantity)
            if quantity == "time" and is_form(said):
                require_form(said)
            else:
                object.__setattr__(self, quantity, known_unit(quantity, said))
        require_flag("forces_only", self.forces_only)
        for number, sensor in self.sensors.items() if self.forces_only else ():
            sensor.require_forces_alone(f"sensors.{number}")
        for name, theirs in self.columns.items():
            if not isinstance(theirs, str):
                raise InvalidInput(
                    f"columns must map names to names, got {shown(name)} = {shown(theirs)}; write "
                    "the name of a column in quotation marks"
                )
            if not is_documented(name):
                raise InvalidInput(
                    f"columns must map documented names, got {name!r}; those are time, x, y, theta,"
                    " qw … qz, vx, vy, omega, and of effector 1 f1x, f1y, t1z, r1x, r1y and so on"
                )
        require_one_orientation(self.pose, self.columns)
        if self.grips is not None:
            object.__setattr__(self, "grips", _checked_grips(self.grips))
        named = self.trial_columns  # one name is no sequence of letters
        named = (named,) if isinstance(named, str) else named
        if not isinstance(named, tuple | list) or not all(isinstance(each, str) for each in named):
            raise InvalidInput(
                f"trial_columns must be names of columns, got {shown(named)}; list them"
            )
        named = tuple(named)
        object.__setattr__(self, "trial_columns", named)

    @property
    def limits(self) -> Limits:
        """On what a file may cost."""
        return Limits(**{each.name: getattr(self, f"max_{each.name}") for each in fields(Limits)})

    def factor(self, quantity: str) -> float:
        """What a number of that quantity is multiplied with to be in SI units."""
        return UNITS[quantity].get(getattr(self, quantity), 1.0)  # times as text come in seconds

    def rows_of_grips(self, num_effectors: int) -> list[tuple[float, ...]]:
        """The grips as they are said, one an effector; none where none is said."""
        if self.grips is None:
            return []
        return list(map(tuple, np.array(self.grips).reshape(num_effectors, -1).tolist()))

    def grips_of(self, num_effectors: int) -> FloatArray | None:
        """The grips ``(n, 2)`` or ``(n, 3)`` [m] of that many effectors, y as in the file."""
        if self.grips is None:
            return None
        grips = np.array(self.grips)
        if grips.size not in (2 * num_effectors, 3 * num_effectors):
            raise InvalidInput(
                f"grips must be 2 or 3 numbers for each of {num_effectors} effectors, got "
                f"{grips.size} numbers; the columns f1x, f2x … say how many effectors there are"
            )
        grips = grips.reshape(num_effectors, -1) * self.factor("length")
        if np.abs(grips).max() > LARGEST:
            raise InvalidInput(
                f"grips must be at most {LARGEST:g} m from the centre of mass, got "
                f"{np.abs(grips).max():g} m; correct them"
            )
        return grips

    @classmethod
    def load(cls, path: str | os.PathLike | None = None, **said: Any) -> "Layout":
        """A layout from a ``.toml`` or ``.json`` file, in which every field is optional.

        Parameters
        ----------
        path
            Of the file; the defaults if ``None``.
        **said
            Fields that take the place of those in the file; the mapped columns and what is said of
            the ``body`` are added to its.

        Raises
        ------
        InvalidInput
            If the file cannot be read or has another form.
        UnknownName
            If it has a field that does not exist.
        """
        content = {} if path is None else load_fields(path)
        known = [entry.name for entry in fields(cls)]
        for name in (*content, *said):
            if name not in known:
                raise UnknownName(f"field of a layout in {path}", name, known)
        columns = {**content.pop("columns", {}), **said.pop("columns", {})}
        of_file, own = content.get("body"), said.get("body")
        added = dict(said)
        if isinstance(of_file, Mapping) and isinstance(own, Mapping):
            added["body"] = {**of_file, **own}
        if path is not None:
            content = located(content, os.path.dirname(path))
        try:
            return cls(**{**content, **added, "columns": columns})
        except CoopenvError as error:
            if content:
                _blame(error, path, cls, said)
            raise


def _blame(error: CoopenvError, path: Any, layout: type[Layout], said: dict[str, Any]) -> None:
    """Name the file in an error, unless what was said beside it is wrong already."""
    without = {name: value for name, value in said.items() if name != "body"}  # which may be a part
    for alone in (said, without):
        try:
            layout(**alone)
        except CoopenvError as own:
            if str(own) == str(error):
                return
    said_of, _, remedy = str(error).rpartition(";")
    error.args = (f"{path}: {shown(said_of, 500)};{remedy}",)


def parse_mapping(pairs: Iterable[str]) -> dict[str, str]:
    """``["f1x=Fx_left", "time="]`` as a mapping of columns."""
    mapping = {}
    for pair in pairs:
        name, equals, theirs = pair.partition("=")
        if not equals:
            raise InvalidInput(
                f"map must be NAME=COLUMN, got {pair!r}; write f1x=Fx_left, or f1x=-Fx_left where "
                "the sign is the other way round"
            )
        if name in mapping:
            raise InvalidInput(f"map must name {name} once, got it twice; leave one out")
        mapping[name] = theirs
    return mapping


def _checked_grips(grips: Any) -> tuple:
    if np.ma.is_masked(grips):
        raise InvalidInput("grips must have no masked values, got some; give every position")
    array = finite_array(grips, "grips")
    nested = array.ndim == 2 and array.shape[1] in (2, 3)
    if not array.size or not (nested or array.ndim == 1):
        raise InvalidInput(
            f"grips must be of shape (n, 2) or (n, 3), got {array.shape}; give one position an "
            "effector"
        )
    return tuple(tuple(row) for row in array.tolist()) if nested else tuple(array.tolist())
