"""Words in the names of columns, and the units among them."""

import re

from coopenv.logs.declared.units import UNITS, known_unit

BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
PARTS = re.compile(r"[A-Z]+(?![a-z])\d*|[A-Z]?[a-z]+|\d+")


def words_of(name: str) -> list[str]:
    """``["force", "left", "x"]`` of ``Force_left.x``, without a unit in brackets."""
    return [each.lower() for each in PARTS.findall(BRACKETS.sub(" ", name))]


def unit_in(name: str, quantity: str) -> str:
    """The unit that a name ends in, as ``Fx [lbf]`` and ``time_ms`` do; empty if it has none."""
    found = BRACKETS.findall(name)
    text = found[-1] if found else name.rpartition("_")[2]
    if not found and (text == name or (len(text) < 2 and text.lower() not in ("n", "s", "m"))):
        return ""
    try:
        return known_unit(quantity, text)
    except ValueError:
        return ""


def any_unit_in(name: str) -> bool:
    """Whether a name ends in a unit of any quantity."""
    return any(unit_in(name, quantity) for quantity in UNITS)
