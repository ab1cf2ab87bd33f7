"""Units of what is measured: those that are known, and how laboratories spell them."""

import re
import unicodedata
from math import pi

from coopenv.errors import InvalidInput, UnknownName

POUND, KILOPOND = 4.4482216152605, 9.80665  # [N]
INCH, FOOT = 0.0254, 0.3048  # [m]

UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": INCH, "ft": FOOT},
    "angle": {"rad": 1.0, "deg": pi / 180, "mrad": 1e-3},
    "velocity": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3, "in/s": INCH, "ft/s": FOOT},
    "angular_velocity": {"rad/s": 1.0, "deg/s": pi / 180, "rpm": pi / 30},
    "force": {
        "N": 1.0,
        "mN": 1e-3,
        "kN": 1e3,
        "lbf": POUND,
        "ozf": POUND / 16,
        "kgf": KILOPOND,
        "gf": KILOPOND / 1000,
    },
    "torque": {
        "N*m": 1.0,
        "N*cm": 1e-2,
        "N*mm": 1e-3,
        "mN*m": 1e-3,
        "kN*m": 1e3,
        "lbf*in": POUND * INCH,
        "lbf*ft": POUND * FOOT,
        "ozf*in": POUND / 16 * INCH,
        "kgf*m": KILOPOND,
        "kgf*cm": KILOPOND / 100,
        "gf*cm": KILOPOND / 1e5,
    },
}
"""What may be declared for each quantity, and its factor to SI; the first is the default."""

TIMES = re.compile(r"\s*[*·⋅∙•×.\-−_]\s*|\s+")  # between the parts of a product, NFKC
EXPONENT = re.compile(r"\*?([a-z]+)(?:\^?\*|\^-)1$")  # of m s^-1, once its blanks are "*"
ANY_CASE = ("rpm", "deg", "rad", "min", "lbf", "kgf")
SPELLINGS: dict[str, dict[str, str]] = {
    "time": {
        "s": "sec secs second seconds",
        "ms": "msec msecs millisecond milliseconds",
        "us": "usec μs μsec microsecond microseconds",
        "ns": "nsec nanosecond nanoseconds",
        "min": "mins minute minutes",
        "h": "hr hour hours",
    },
    "length": {
        "m": "meter meters metre metres",
        "cm": "centimeter centimeters centimetre centimetres",
        "mm": "millimeter millimeters millimetre millimetres",
        "um": "μm",
        "in": 'inch inches "',
        "ft": "foot feet",
    },
    "angle": {"rad": "radian radians", "deg": "degree degrees °"},
    "velocity": {"m/s": "m/sec", "cm/s": "cm/sec", "mm/s": "mm/sec"},
    "angular_velocity": {
        "rad/s": "rad/sec radians/s radian/s radians/sec",
        "deg/s": "deg/sec degrees/s degree/s degrees/sec °/s °/sec",
        "rpm": "r/min rev/min 1/min",
    },
    "force": {"N": "newton newtons", "kgf": "kp", "gf": "p"},
    "torque": {
        "N*m": "Nm newton*meter newton*meters newton*metre newtonmeter",
        "N*cm": "Ncm",
        "N*mm": "Nmm",
        "mN*m": "mNm",
        "kN*m": "kNm",
        "lbf*in": "lbfin in*lbf inlbf lb*in lbin in*lb inlb in*lbs",
        "lbf*ft": "lbfft ft*lbf ftlbf lb*ft lbft ft*lb ftlb ft*lbs",
        "ozf*in": "ozfin in*ozf oz*in ozin in*oz inoz",
        "kgf*m": "kgfm m*kgf kp*m kg*m",
        "kgf*cm": "kgfcm cm*kgf kp*cm kg*cm",
        "gf*cm": "gfcm cm*gf p*cm",
    },
}
"""Other ways to write a unit, with ``*`` for whatever stands between the parts of a product."""


def known_unit(quantity: str, said: str) -> str:
    """The unit of ``UNITS`` that is meant: ``N*m`` for ``Nm``, ``N-m``, ``N.m`` or ``[N·m]``.

    Raises
    ------
    UnknownName
        If there is none; the message names the known ones.
    """
    found = _found(quantity, said)
    if found is None:
        raise UnknownName(f"unit of {quantity}", said, UNITS[quantity])
    return found


def is_unit(said: str) -> bool:
    """Whether it is how somebody writes a unit of any quantity, or that there is none."""
    if said.strip().strip("[]()- ") in ("", "1"):
        return True
    return any(_found(quantity, said) is not None for quantity in UNITS)


def factor_of(path: str, column: str, quantity: str, said: str, declared: str) -> float:
    """Factor to SI of a column of which the file itself says the unit.

    Raises
    ------
    InvalidInput
        If another unit than the default is declared.
    UnknownName
        If it is no unit of that quantity.
    """
    try:
        unit = known_unit(quantity, said)
    except UnknownName as error:
        error.args = (f"{path}, column {column!r}: {error}; correct it in the file",)
        raise
    if declared not in (unit, next(iter(UNITS[quantity]))):
        raise InvalidInput(
            f"{path}, column {column!r} must be in the unit that is declared, got {unit} in the "
            f"file and {declared} declared; leave out --{quantity.replace('_', '-')}"
        )
    return UNITS[quantity][unit]


def _found(quantity: str, said: str) -> str | None:
    known = UNITS[quantity]
    if said in known:
        return said
    text = unicodedata.normalize("NFKC", said).strip().strip("[](){}").strip()
    text = TIMES.sub("*", text)
    text = EXPONENT.sub(r"/\1", text)
    if text in known:
        return text
    spelled = SPELLINGS[quantity].items()
    words = {other: unit for unit, others in spelled for other in others.split()}
    if text in words:
        return words[text]
    lower = text.lower()  # of words alone: in mN and MN the case says how much it is
    if lower in ANY_CASE and lower in UNITS[quantity]:
        return lower
    if len(lower.strip("/*°")) <= 3:
        return None
    return lower if lower in known else words.get(lower)
