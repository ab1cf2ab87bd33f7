"""A layout file to begin with, from what is in recorded files."""

import json
from collections.abc import Sequence
from pathlib import Path

from coopenv.logs.columns import quantity
from coopenv.logs.inspected.contents import Contents, names_of
from coopenv.logs.inspected.guesses import KINDS, Guess, guesses
from coopenv.logs.inspected.words import words_of
from coopenv.logs.limits import legible, shown

UNSAID = "# a guess: nothing in the file says so"


def first_layout(contents: Sequence[Contents]) -> str:
    """Text of a TOML layout that names what the columns could be; what is a guess says so.

    Parameters
    ----------
    contents
        Of the recording, and of the files of other devices beside it.
    """
    found = guesses(contents)
    first = contents[0]
    several = len(contents) > 1
    lines = [f"# {shown(legible(Path(first.path).name))}"]
    lines += ["# Guessed from names and numbers: read it, correct it, then delete this line."]
    names = {guess.name for each in found for guess in each.values()}
    if not any(name.startswith("r") for name in names):
        grips = (
            "[[-0.9, 0.0, 0.0], [0.9, 0.0, 0.0]]" if "f1z" in names else "[[-0.9, 0.0], [0.9, 0.0]]"
        )
        lines.append(f"# grips = {grips}  # where the effectors hold, object frame")
    lines += ['# frame = "world"  # if forces and torques are in the world frame']
    lines += _clock(contents)
    lines += _units(found)
    lines += _numbered_quaternion(contents, found)
    named = names_of(contents)
    mapped = _columns(contents, found, named)
    if not several and first.clock is not None and first.clock.column != "time":
        mapped.insert(0, f"time = {quoted(first.clock.column)}")
    if mapped:
        lines += ["", "[columns]", *mapped]
    if several:
        for name, each in zip(named, contents, strict=True):
            lines += ["", *_device(name, each, first)]
    return "\n".join([*lines, ""])


def _numbered_quaternion(
    contents: Sequence[Contents], found: Sequence[dict[str, Guess]]
) -> list[str]:
    """Four columns such as q0 to q3, whose order nothing tells."""
    if any(guess.name == "qw" for each in found for guess in each.values()):
        return []
    names = [seen.name for each in contents for seen in each.columns if seen.is_number]
    for name in names:
        four = [f"{name[:-1]}{number}" for number in range(4)]
        if name == four[0] and set(words_of(name)) & KINDS["q"] and set(four) <= set(names):
            listed = ", ".join(map(quoted, four))
            return [f'# pose = {{ columns = [{listed}], order = "xyzw" }}  # or "wxyz"']
    return []


def _clock(contents: Sequence[Contents]) -> list[str]:
    first, several = contents[0], len(contents) > 1
    if several:
        rates = [0.0 if each.clock is None else each.clock.rate for each in contents]
        fastest = names_of(contents)[max(range(len(rates)), key=rates.__getitem__)]
        return [f"clock = {quoted(fastest)}  # whose rows are kept: the fastest"]
    if first.clock is None:
        return ["# sample_rate = 1000.0  # [Hz], as no column looks like time"]
    if first.clock.unit == "s":
        return []
    note = "" if first.clock.said else f"  {UNSAID}"
    return [f"time = {quoted(first.clock.unit)}{note}"]


def _units(found: Sequence[dict[str, Guess]]) -> list[str]:
    """Fields on units: those that names and numbers tell; the file's own need none."""
    told: dict[str, Guess] = {}
    for guess in (each for columns in found for each in columns.values()):
        kind = quantity(guess.name)
        if kind is not None and guess.unit and kind not in told:
            told[kind] = guess
    return [
        f"{kind} = {quoted(guess.unit)}" + ("" if guess.said else f"  {UNSAID}")
        for kind, guess in told.items()
    ]


def _columns(
    contents: Sequence[Contents], found: Sequence[dict[str, Guess]], named: Sequence[str]
) -> list[str]:
    """Lines of ``[columns]``, in the order of the files."""
    names = [seen.name for each in contents for seen in each.columns]
    made = []
    for device, columns in zip(named, found, strict=True):
        for theirs, guess in columns.items():
            full = theirs if names.count(theirs) == 1 else f"{device}/{theirs}"
            if full != guess.name:
                made.append(f"{guess.name} = {quoted(full)}")
    return made


def _device(name: str, each: Contents, first: Contents) -> list[str]:
    lines = [f"[files.{quoted(name)}]"]
    if each.path != first.path:
        here = Path(first.path).resolve().parent
        there = Path(each.path).resolve()
        beside = there.name if there.parent == here else str(there)
        lines.append(f"path = {quoted(beside)}")
    if each.part:
        lines.append(f"part = {quoted(each.part)}")
    if each.clock is None:
        return [*lines, "# rate = 1000.0  # [Hz], as no column looks like time"]
    lines.append(f"time = {quoted(each.clock.column)}")
    note = "" if each.clock.said else f"  {UNSAID}"
    return [*lines, f"unit = {quoted(each.clock.unit)}{note}", "# delay = 0.0  # [s]"]


def quoted(text: str) -> str:
    """A text in quotation marks, as TOML has it; no name breaks out of it."""
    text = text.encode("utf-8", "backslashreplace").decode()
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
