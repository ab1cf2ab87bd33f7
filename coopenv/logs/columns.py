"""The documented columns, and where each of them is in a file."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from coopenv.errors import InvalidInput
from coopenv.logs.layout import Layout

AXES = {2: ("x", "y"), 3: ("x", "y", "z")}
TORQUES = {2: ("z",), 3: ("x", "y", "z")}
POSITION = {2: ("x", "y"), 3: ("x", "y", "z")}
ORIENTATION = {2: ("theta",), 3: ("qw", "qx", "qy", "qz")}
TWIST = {
    2: ("vx", "vy", "omega"),
    3: ("vx", "vy", "vz", "omega_x", "omega_y", "omega_z"),
}
WHOLE = {"time", "theta", *POSITION[3], *ORIENTATION[3], *TWIST[2], *TWIST[3]}
EFFECTOR = re.compile(r"([ftr])([1-9]\d*)([xyz])")
NUMBERED = re.compile(r"[ftr]\d+[xyz]")  # from any number
QUANTITY = {"f": "force", "t": "torque", "r": "length"}

INPUT = (  # name in the plane, in space, unit, meaning
    ("`time`", "`time`", "s", "optional; increases within a trial"),
    ("`f1x` `f1y`", "`f1x` `f1y` `f1z`", "N", "force that effector 1 applies to the object"),
    ("`t1z`", "`t1x` `t1y` `t1z`", "N·m", "torque it applies; none with `--forces-only`"),
    ("`r1x` `r1y`", "`r1x` `r1y` `r1z`", "m", "where it holds, unless `--grips` says; may vary"),
    ("`f2x` …", "`f2x` …", "", "effectors 2, 3, … alike, as many as there are"),
    ("`x` `y`", "`x` `y` `z`", "m", "centre of mass in the world; for `--grip-frame world`"),
    ("`theta`", "`qw` `qx` `qy` `qz`", "rad", "orientation in the world; for data in its frame"),
    (
        "`vx` `vy` `omega`",
        "`vx` `vy` `vz` `omega_x` `omega_y` `omega_z`",
        "m/s, rad/s",
        "optional: velocity of the centre of mass, for energy shares and internal power",
    ),
    ("`pair` `condition` `trial`", "the same", "", "optional: a new value starts a new trial"),
    ("any other", "any other", "", "carried to the table as it is"),
)
"""What a file may hold, for the page on recordings."""


def is_documented(name: str) -> bool:
    """Whether a column of that name has a meaning."""
    return name in WHOLE or EFFECTOR.fullmatch(name) is not None


def quantity(name: str) -> str:
    """What a documented column measures, as `coopenv.logs.layout.UNITS` names it."""
    effector = EFFECTOR.fullmatch(name)
    if effector is not None:
        return QUANTITY[effector[1]]
    if name == "time":
        return "time"
    if name.startswith("omega"):
        return "angular_velocity"
    if name.startswith("v"):
        return "velocity"
    return "angle" if name == "theta" else "length" if name in POSITION[3] else "none"


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Which columns of a file are read, under which documented names, and what is carried."""

    num_effectors: int
    dimension: int  # 2 or 3
    source: dict[str, str]  # documented name -> column of the file
    factor: dict[str, float]  # documented name -> factor to SI units, sign included
    required: frozenset[str]  # documented names that must be finite in a good row
    carried: tuple[str, ...]  # columns of the file
    unused: tuple[str, ...]  # columns with a documented name that mean nothing here
    grips_vary: bool  # whether they are columns

    def has(self, names: Sequence[str]) -> bool:
        """Whether all of these documented columns are there."""
        return all(name in self.source for name in names)

    def effector_names(self, kind: str) -> list[list[str]]:
        """Names of the columns of ``kind`` f, t or r: one list an effector."""
        axes = (TORQUES if kind == "t" else AXES)[self.dimension]
        return [[f"{kind}{i + 1}{axis}" for axis in axes] for i in range(self.num_effectors)]


def plan(path: str, columns: Sequence[str], layout: Layout, grips: bool = False) -> Plan:
    """Find the documented columns among those of a file.

    Parameters
    ----------
    path
        Named in errors.
    columns
        Of the file.
    layout
        How its columns are called.
    grips
        Whether the file says the grips otherwise, once for all rows.

    Raises
    ------
    InvalidInput
        If a column is missing or said twice; the message names the nearest there is.
    """
    found = _find(path, columns, layout)
    _refuse_zero(path, columns, found)
    need = _Need(path, columns, found)
    for name in ("f1x", "f1y"):
        need(name)
    count = _count(found)
    dimension = _dimension(found, layout, count)
    if layout.grips is not None and grips:
        raise InvalidInput(f"grips must be said once, got them in {path} too; leave them out")
    made = Plan(
        num_effectors=count,
        dimension=dimension,
        source=found,
        factor={},
        required=frozenset(),
        carried=(),
        unused=(),
        grips_vary=layout.grips is None and not grips,
    )
    groups = [*made.effector_names("f")]
    if not layout.forces_only:
        groups += made.effector_names("t")
    if made.grips_vary:
        groups += made.effector_names("r")
    required = [need(name) for group in groups for name in group]
    if not made.grips_vary and any(name.startswith("r") for name in found):
        raise InvalidInput(
            f"grips must be said once, got columns {_some(found, 'r')} in {path} as well; leave "
            "out --grips or the columns (--map r1x=)"
        )
    twist = TWIST[dimension] if any(name in found for name in TWIST[dimension]) else ()
    left_out = " ".join(f"{name}=" for name in twist if name in found)
    remedy = f"a twist is whole or left out (--map {left_out})"
    required += [need(name, remedy) for name in twist]
    required += [need(name) for name in _poses(made, layout, bool(twist))]
    optional = [*POSITION[dimension], *ORIENTATION[dimension]]
    read: list[str] = [*dict.fromkeys([*(["time"] if "time" in found else []), *required])]
    used = [*read, *(name for name in optional if name in found and name not in read)]
    return _filled(made, columns, layout, read, used)


def _filled(
    made: Plan, columns: Sequence[str], layout: Layout, required: list[str], used: list[str]
) -> Plan:
    """The plan with its factors, and with the columns that have no part in it."""
    source = {name: made.source[name] for name in used}
    factor = {}
    for name in used:
        negated = layout.columns.get(name, "").startswith("-") and (
            layout.columns[name] not in columns
        )
        kind = quantity(name)
        scale = 1.0 if kind == "none" else layout.factor(kind)
        factor[name] = -scale if negated else scale
    taken = set(source.values())
    rest = [name for name in columns if name not in taken]
    unused = [name for name in rest if is_documented(name) or NUMBERED.fullmatch(name)]
    return Plan(
        num_effectors=made.num_effectors,
        dimension=made.dimension,
        source=source,
        factor=factor,
        required=frozenset(required),
        carried=tuple(name for name in rest if name not in unused),
        unused=tuple(unused),  # carried, they would mean something where the table is read again
        grips_vary=made.grips_vary,
    )


def _find(path: str, columns: Sequence[str], layout: Layout) -> dict[str, str]:
    """Documented name → column, of all that are there."""
    if len(set(columns)) < len(columns):
        twice = next(name for name in columns if list(columns).count(name) > 1)
        raise InvalidInput(f"{path}: columns must differ, got {twice!r} twice; rename one")
    found = {name: name for name in columns if is_documented(name)}
    for name, theirs in layout.columns.items():
        found.pop(name, None)
        if not theirs:
            continue
        if theirs not in columns and theirs.removeprefix("-") in columns:
            theirs = theirs[1:]
        if theirs not in columns:
            hint = _hint(name, columns, theirs.removeprefix("-"))
            raise InvalidInput(
                f"{path}: {name} must be mapped to one of its columns, got {theirs!r}; {hint}"
            )
        found[name] = theirs
        if found.get(theirs) == theirs and theirs not in layout.columns and theirs != name:
            del found[theirs]  # its own name would mean something else
    return found


def _refuse_zero(path: str, columns: Sequence[str], found: dict[str, str]) -> None:
    """Raise where effectors count from 0; the first would be overlooked."""
    zero = [name for name in columns if re.fullmatch(r"[ft]0[xyz]", name)]
    if zero and not set(zero) & set(found.values()):
        raise InvalidInput(
            f"{path}: effectors are numbered from 1, got column {zero[0]!r}; rename the columns or "
            f"map all of them, --map f1x=f0x f2x=f1x …; has: {_listed(columns)}"
        )


def _dimension(found: dict[str, str], layout: Layout, count: int) -> int:
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
    spatial = re.compile(r"[fr]\d+z|t\d+[xy]")
    return 3 if any(spatial.fullmatch(name) for name in found) else 2


def _count(found: dict[str, str]) -> int:
    """Number of effectors."""
    return max(int(name[1:-1]) for name in found if EFFECTOR.fullmatch(name) is not None)


def _poses(made: Plan, layout: Layout, twist: bool) -> list[str]:
    """Columns of the pose without which the declared frames make no sense."""
    if layout.y == "down" and made.dimension == 3:
        raise InvalidInput(
            "y must be 'up' in space, got 'down'; there, every right-handed frame will do as it is"
        )
    if layout.grip_frame == "world" and not made.grips_vary:
        raise InvalidInput(
            "grip_frame must be 'object' where the grips are given once, got 'world'; record them "
            "in columns r1x, r1y …"
        )
    names: list[str] = []
    if "world" in (layout.frame, layout.grip_frame) or (twist and layout.twist_frame == "world"):
        names += ORIENTATION[made.dimension]
    if layout.grip_frame == "world":
        names += POSITION[made.dimension]
    return names


@dataclass(frozen=True, slots=True)
class _Need:
    """Insists on a column, and helps to find it."""

    path: str
    columns: Sequence[str]
    found: dict[str, str]

    def __call__(self, name: str, remedy: str = "") -> str:
        if name in self.found:
            return name
        if name[0] == "t" and name != "time" and not _some(self.found, "t"):
            remedy = "say --forces-only if the effectors apply no torque"
        if name[0] == "r" and not _some(self.found, "r"):
            remedy = "or give the grips once with --grips"
        raise InvalidInput(
            f"{self.path}: column {name} must be there, got none of that name; "
            f"{_hint(name, self.columns)}{'; ' * bool(remedy)}{remedy}"
        )


def _some(found: dict[str, str], kind: str) -> str:
    matches = [EFFECTOR.fullmatch(name) for name in found]
    return ", ".join(match[0] for match in matches if match is not None and match[1] == kind)


def _hint(name: str, columns: Sequence[str], like: str = "") -> str:
    """The column nearest to the name or to what is like it, and all there are."""
    lower = {column.lower(): column for column in columns if like or not _taken(name, column)}
    nearest = get_close_matches((like or name).lower(), lower, n=1, cutoff=0.5)
    if nearest:
        theirs = lower[nearest[0]]
        return (
            f"did you mean {theirs!r}? rename it or map it, --map {name}={theirs}; has: "
            f"{_listed(columns)}"
        )
    return f"rename a column or map it, --map {name}=COLUMN; has: {_listed(columns)}"


def _taken(name: str, column: str) -> bool:
    """Whether a column is something else than ``name`` by its own name."""
    if is_documented(column):
        return True
    other, own = EFFECTOR.fullmatch(column.lower()), EFFECTOR.fullmatch(name)
    return other is not None and own is not None and other[1] != own[1]


def _listed(columns: Sequence[str]) -> str:
    return ", ".join(columns[:30]) + (" …" if len(columns) > 30 else "")
