"""Matching of a file's columns to the documented ones, as a layout asks."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from coopenv.errors import InvalidInput
from coopenv.logs.calibration.declared import needed
from coopenv.logs.columns import (
    EFFECTOR,
    ORIENTATION,
    POSITION,
    TWIST,
    effector_names,
    is_documented,
    out_of_plane_names,
    quantity,
)
from coopenv.logs.declared.stamps import is_form
from coopenv.logs.declared.units import factor_of
from coopenv.logs.layout import Layout
from coopenv.logs.limits import Limits, shown
from coopenv.logs.plan.matching import Need, find, negated, require_no_other_case, some

NUMBERED = re.compile(r"[ftr]\d+[xyz]")  # from any number
SPATIAL = re.compile(r"[fr]\d+z|t\d+[xy]")  # out of the plane
DIGITS = 9  # of the number of an effector


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Which columns of a file are read, under which documented names, and what is carried."""

    num_effectors: int
    dimension: int  # 2 or 3
    source: dict[str, str]  # documented name -> column of the file
    factor: dict[str, float]  # documented name -> factor to SI units, sign included
    units: dict[str, str]  # documented name -> unit, where the file says it
    required: frozenset[str]  # documented names that must be finite in a good row
    carried: tuple[str, ...]  # columns of the file
    unused: tuple[str, ...]  # columns with a documented name that mean nothing here
    grips_vary: bool  # whether they are columns
    six_axes: tuple[int, ...] = ()  # effectors of which they are read though it is the plane

    def has(self, names: Sequence[str]) -> bool:
        """Whether all of these documented columns are there."""
        return all(name in self.source for name in names)

    def without(self, made: Collection[str]) -> "Plan":
        """The same where columns that were made for it, and are in no file, are of no use."""
        return replace(
            self,
            carried=tuple(name for name in self.carried if name not in made),
            unused=tuple(name for name in self.unused if name not in made),
        )

    def effector_names(self, kind: str) -> list[list[str]]:
        """Names of the columns of ``kind`` f, t or r: one list an effector."""
        return effector_names(kind, self.num_effectors, self.dimension)


def make_plan(
    path: str,
    columns: Sequence[str],
    layout: Layout,
    *,
    grips_in_file: bool = False,
    units: Mapping[str, str] | None = None,
    repeated: Collection[str] = (),
) -> Plan:
    """Find the documented columns among those of a file.

    Parameters
    ----------
    path
        Named in errors.
    columns
        Of the file.
    layout
        How its columns are called, their frames and units.
    grips_in_file
        Whether the file says the grips otherwise, once for all rows.
    units
        Column → unit, where the file says it.
    repeated
        Documented names that several columns had, of which the layout must say which is meant.

    Raises
    ------
    InvalidInput
        If a column is missing or said twice; the message names the nearest there is.
    """
    units = units or {}
    found = find(path, columns, layout, repeated)
    count = _count(path, found, layout.limits)
    need = Need(path, columns, found)
    need("f1x", "f1y")
    dimension = _dimension(found, layout, count)
    if layout.grips is not None and grips_in_file:
        raise InvalidInput(f"grips must be said once, got them in {path} too; leave them out")
    grips_vary = layout.grips is None and not grips_in_file
    kinds = "f" + "t" * (not layout.forces_only) + "r" * grips_vary
    groups = [group for kind in kinds for group in effector_names(kind, count, dimension)]
    required = ["time"] if "time" in found else []
    required += need(*(name for group in groups for name in group))
    if not grips_vary and some(found, "r"):
        raise InvalidInput(
            f"grips must be said once, got columns {some(found, 'r')} in {path} as well; leave "
            "out --grips or the columns (--map r1x=)"
        )
    twist = _twist(need, dimension)
    in_world = "what the file has in the world frame needs it; if nothing is, say --frame object"
    required += [*twist, *need(*_pose(layout, dimension, grips_vary, bool(twist)), remedy=in_world)]
    required += [name for name in _corrected(need, layout, dimension) if name not in required]
    six_axes = _six_axes(layout, count, dimension)
    required += _out_of_plane(need, layout, six_axes)
    pose = (*POSITION[dimension], *ORIENTATION[dimension])
    optional = [name for name in pose if name in found and name not in required]
    source = {name: found[name] for name in required + optional}
    taken = set(source.values())
    rest = [name for name in columns if name not in taken]
    require_no_other_case(path, rest, found, layout)
    # carried, they would mean something where the table is read again
    unused = dict.fromkeys(name for name in rest if is_documented(name) or NUMBERED.fullmatch(name))
    return Plan(
        num_effectors=count,
        dimension=dimension,
        source=source,
        factor={name: _factor(path, name, found, columns, layout, units) for name in source},
        units={name: units[theirs] for name, theirs in source.items() if theirs in units},
        required=frozenset(required),
        carried=tuple(name for name in rest if name not in unused),
        unused=tuple(unused),
        grips_vary=grips_vary,
        six_axes=six_axes,
    )


def _count(path: str, found: dict[str, str], limits: Limits) -> int:
    """Number of effectors: the largest in a name of a column, if it is not beyond the limit."""
    count = 0
    for name in found:
        match = EFFECTOR.fullmatch(name)
        if match is not None:
            few = len(match[2]) <= DIGITS
            number = int(match[2]) if few else f"number {shown(match[2], DIGITS)}"
            limits.require("effectors", number, f"{path}, column {shown(name)!r}", "rename it")
            count = max(count, int(match[2]))
    return count


def _dimension(found: dict[str, str], layout: Layout, count: int) -> int:
    """2 or 3: of the grips, as the layout says, or as the columns are."""
    grips = layout.grips_of(count)
    said = {"plane": 2, "space": 3, "auto": None}[layout.space]
    if grips is not None and said not in (None, grips.shape[1]):
        raise InvalidInput(
            f"grips must be of {said} numbers each in the {layout.space}, got {grips.shape[1]}; "
            "change them or leave out --space"
        )
    if grips is not None:
        return grips.shape[1]
    if said is not None:
        return said
    return 3 if any(SPATIAL.fullmatch(name) for name in found) else 2


def _twist(need: "Need", dimension: int) -> list[str]:
    """Columns of the twist: all of them, or none."""
    there = [name for name in TWIST[dimension] if name in need.found]
    if not there:
        return []
    left_out = " ".join(f"{name}=" for name in there)
    return need(*TWIST[dimension], remedy=f"a twist is whole or left out (--map {left_out})")


def _pose(layout: Layout, dimension: int, grips_vary: bool, twist: bool) -> list[str]:
    """Columns of the pose that are needed to turn what the world frame holds to the object's."""
    if layout.y == "down" and dimension == 3:
        raise InvalidInput(
            "y must be 'up' in space, got 'down'; there, every right-handed frame will do as it is"
        )
    if layout.grip_frame == "world" and not grips_vary:
        raise InvalidInput(
            "grip_frame must be 'object' where the grips are given once, got 'world'; record them "
            "in columns r1x, r1y …"
        )
    names: list[str] = []
    if "world" in (layout.frame, layout.grip_frame) or (twist and layout.twist_frame == "world"):
        names += ORIENTATION[dimension]
    if layout.grip_frame == "world":
        names += POSITION[dimension]
    return names


def _corrected(need: "Need", layout: Layout, dimension: int) -> list[str]:
    """Columns that corrections need, and all of the pose that they move."""
    wanted = needed(layout, dimension)
    position, orientation = POSITION[dimension], ORIENTATION[dimension]
    moves = bool(layout.pose.com or layout.pose.delay)
    names = ["time"] if "time" in wanted else []
    for name, columns in (("position", position), ("orientation", orientation)):
        if name in wanted or (moves and all(each in need.found for each in columns)):
            names += columns
    tables = "[sensors], [pose] and [filters] of the layout"
    return need(*names, remedy=f"a correction needs it; see {tables}")


def _six_axes(layout: Layout, count: int, dimension: int) -> tuple[int, ...]:
    """Effectors whose sensors are corrected as all six axes are, in the plane."""
    angle = layout.factor("angle")
    asked = (i for i, each in layout.sensors.items() if each.asks_for_six_axes(angle))
    return tuple(sorted(i for i in asked if i <= count)) if dimension == 2 else ()


def _out_of_plane(need: "Need", layout: Layout, six_axes: Sequence[int]) -> list[str]:
    """Columns that these sensors need too."""
    made: list[str] = []
    for number in six_axes:
        names = out_of_plane_names(number)
        key = layout.sensors[number].asks_for_six_axes(layout.factor("angle"))
        remedy = f"sensors.{number}.{key} is of all six axes, which are read in the plane too"
        made += need(*names[: 1 if layout.forces_only else 3], remedy=remedy)
    return made


def _factor(
    path: str,
    name: str,
    found: dict[str, str],
    columns: Sequence[str],
    layout: Layout,
    units: Mapping[str, str],
) -> float:
    """What the numbers of a documented column are multiplied with: unit and sign."""
    kind = quantity(name)
    scale = 1.0 if kind is None else layout.factor(kind)
    said = units.get(found[name], "")
    if kind is not None and said and not (kind == "time" and is_form(layout.time)):
        scale = factor_of(path, found[name], kind, said, getattr(layout, kind))
    return -scale if negated(layout.columns.get(name, ""), columns) else scale
