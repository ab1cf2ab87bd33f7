"""Which documented column a column of a file could be, by its name; guesses, never assumptions."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from coopenv.logs.columns import EFFECTOR, is_documented, quantity
from coopenv.logs.declared.units import is_unit, known_unit
from coopenv.logs.inspected.contents import Contents, Seen
from coopenv.logs.inspected.words import any_unit_in, unit_in, words_of

SIDES = {"left": 1, "l": 1, "right": 2, "r": 2}
KINDS = {  # a word -> what stands for its axis
    "f": {"f", "force", "forces"},
    "t": {"t", "torque", "torques", "moment", "moments", "m", "tau"},
    "r": {"grip", "grips"},
    "v": {"v", "vel", "velocity", "linear"},
    "omega": {"omega", "w", "angular", "gyro"},
    "q": {"q", "quat", "quaternion", "orientation", "rotation", "rot"},
    "p": {"p", "pos", "position", "translation"},
}
JOINED = re.compile(r"([a-z]+)([xyzw])(\d?)|([a-z]+)(\d)([xyz])")
ANGLES = {"theta", "yaw", "heading"}
LONG = 50.0  # [m] nobody carries anything so far: millimetres
TURN = 7.0  # [rad] just more than a full turn: degrees


@dataclass(frozen=True, slots=True)
class Guess:
    """What a column could be."""

    name: str  # documented
    unit: str  # empty where nothing tells it; else as `UNITS` names it
    said: bool  # whether file or name say the unit; else its numbers do


def guess(seen: Seen, device: int | None = None) -> Guess | None:
    """The documented name that a column of numbers seems to have; ``None`` if it has no such.

    ``device`` is the number of the effector whose file it is, where there is a file a device.
    """
    if not seen.is_number:
        return None
    name = seen.name if is_documented(seen.name) else _named(seen.name, device)
    return None if name is None else Guess(name, *_unit(seen, name))


def guesses(contents: Sequence[Contents]) -> list[dict[str, Guess]]:
    """Of every file: column → what it could be, each documented name once."""
    devices = _devices(contents)
    taken: set[str] = set()
    made: list[dict[str, Guess]] = []
    for each, device in zip(contents, devices, strict=True):
        found: dict[str, Guess] = {}
        for seen in each.columns:
            is_time = each.clock is not None and seen.name == each.clock.column
            could = None if is_time else guess(seen, device)
            if could is not None and could.name != "time" and could.name not in taken:
                taken.add(could.name)
                found[seen.name] = could
        made.append(found)
    return made


def _devices(contents: Sequence[Contents]) -> list[int | None]:
    """Number of the effector of each file of several: by its side, else in their order."""
    made: list[int | None] = []
    forces = 0
    for each in contents:
        words = words_of(each.part or each.path.replace("\\", "/").rpartition("/")[2])
        side = next((SIDES[word] for word in words if word in SIDES and len(word) > 1), None)
        named = [_named(seen.name, 0) for seen in each.columns]
        alone = any(name in ("f0x", "f0y") for name in named)
        forces += alone
        made.append(None if not alone else side or forces)
    return made


def _named(name: str, device: int | None) -> str | None:
    """Documented name that the words of another name mean."""
    words = words_of(name)
    if any_unit_in(name) and len(words) > 1 and "[" not in name and "(" not in name:
        words = words_of(name.rpartition("_")[0])
    if ANGLES & set(words):
        return "theta"
    found = _kind_and_axis(words)
    if found is None:
        return words[0] if len(words) == 1 and words[0] in ("x", "y", "z") else None
    kind, axis, number = found
    if kind in ("f", "t", "r"):
        side = number or next((SIDES[word] for word in words if word in SIDES), 0)
        side = side or next((int(word) for word in words if word in ("1", "2", "3", "4")), 0)
        effector = side or (1 if device is None else device)
        return f"{kind}{effector}{axis}" if axis in "xyz" else None
    if kind == "p":
        return axis if axis in "xyz" else None
    if kind == "q":
        return f"q{axis}"
    if axis == "w":
        return None
    return f"omega_{axis}" if kind == "omega" else f"v{axis}"


def _kind_and_axis(words: list[str]) -> tuple[str, str, int] | None:
    """``("f", "x", 1)`` of ``["fx", "1"]``, ``["f", "1", "x"]``, ``["force", "left", "x"]``."""
    for word in words:
        joined = JOINED.fullmatch(word)
        if joined is not None:
            stem, axis = joined[1] or joined[4], joined[2] or joined[6]
            kind = next((k for k, stems in KINDS.items() if stem in stems), None)
            if kind is not None:
                return kind, axis, int(joined[3] or joined[5] or 0)
    axis = next((word for word in reversed(words) if word in ("x", "y", "z", "w")), None)
    for word in words if axis is not None else ():
        kind = next((k for k, stems in KINDS.items() if word in stems and word != axis), None)
        if kind is not None:
            return kind, str(axis), 0
    return None


def _unit(seen: Seen, name: str) -> tuple[str, bool]:
    """Unit of a column that has a documented name."""
    kind = quantity(name)
    if kind is None:
        return "", True
    if seen.unit and is_unit(seen.unit):
        try:
            return known_unit(kind, seen.unit), True
        except ValueError:
            return "", False
    said = "" if is_documented(seen.name) else unit_in(seen.name, kind)
    if said:
        return said, True
    largest = max(abs(seen.low), abs(seen.high))
    if kind == "angle" and largest > TURN:
        return "deg", False
    if kind == "length" and EFFECTOR.fullmatch(name) is None and largest > LONG:
        return "mm", False
    return "", False
