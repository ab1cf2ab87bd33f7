"""Documented columns of a recording: their names, axes and quantities."""

import re

AXES = {2: ("x", "y"), 3: ("x", "y", "z")}
TORQUES = {2: ("z",), 3: ("x", "y", "z")}
POSITION = {2: ("x", "y"), 3: ("x", "y", "z")}
ORIENTATION = {2: ("theta",), 3: ("qw", "qx", "qy", "qz")}
TWIST = {
    2: ("vx", "vy", "omega"),
    3: ("vx", "vy", "vz", "omega_x", "omega_y", "omega_z"),
}
WHOLE = {"time", "theta", *POSITION[3], *ORIENTATION[3], *TWIST[2], *TWIST[3]}
EFFECTOR = re.compile(r"([ftr])([1-9][0-9]*)([xyz])")
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


def quantity(name: str) -> str | None:
    """What a documented column measures, as `coopenv.logs.layout.UNITS` names it.

    ``None`` for components of a quaternion, which have no unit.
    """
    effector = EFFECTOR.fullmatch(name)
    if effector is not None:
        return QUANTITY[effector[1]]
    if name == "time":
        return "time"
    if name.startswith("omega"):
        return "angular_velocity"
    if name.startswith("v"):
        return "velocity"
    if name == "theta":
        return "angle"
    return "length" if name in POSITION[3] else None


def effector_names(kind: str, num_effectors: int, dimension: int) -> list[list[str]]:
    """Names of the columns of ``kind`` f, t or r: one list an effector, one name an axis.

    >>> effector_names("f", 2, dimension=2)
    [['f1x', 'f1y'], ['f2x', 'f2y']]
    """
    axes = (TORQUES if kind == "t" else AXES)[dimension]
    return [[f"{kind}{i + 1}{axis}" for axis in axes] for i in range(num_effectors)]


def wrench_names(num_effectors: int, dimension: int) -> list[str]:
    """Names of a wrench's components, effector by effector: f1x, f1y, t1z, f2x and so on."""
    forces = effector_names("f", num_effectors, dimension)
    torques = effector_names("t", num_effectors, dimension)
    return [name for force, torque in zip(forces, torques, strict=True) for name in force + torque]


def out_of_plane_names(number: int) -> tuple[str, str, str]:
    """What an effector has out of the plane: force along z, torques about x and y."""
    return f"f{number}z", f"t{number}x", f"t{number}y"
