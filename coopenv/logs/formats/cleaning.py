"""Cleaning of text tables: plain CSV of what laboratories write, and names by position."""

import csv
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from coopenv.errors import InvalidInput

BLANKS = "blanks"


def split(path: Path, line: str, separator: str, place: str) -> list[str]:
    """Fields of a line, without quotation marks."""
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error as error:
        raise InvalidInput(
            f"{path}, {place} must be a line of a text table, got one that is none ({error}); "
            "export it as CSV"
        ) from error


def cleaner(
    separator: str, comment: str, *, columns: int, empty: int
) -> Callable[[bytes], bytes] | None:
    """What makes plain CSV of whole lines of a file, if anything is to be made; lines stay lines.

    Parameters
    ----------
    separator
        One character, or ``"blanks"``, of which tabs are made.
    comment
        What lines begin with that are emptied; none if empty.
    columns, empty
        How many fields a line has, and how many empty ones beyond may end it.
    """
    steps: list[Callable[[bytes], bytes]] = []
    if comment:
        commented = re.compile(rb"(?m)^[ \t]*" + re.escape(comment.encode()) + rb"[^\n]*")
        steps.append(lambda block: commented.sub(b"", block))
    if separator == BLANKS:
        steps.append(blanks_as_tabs)
    elif empty:
        field = rb'(?:"[^"\n]*"|[^' + re.escape(separator.encode()) + rb'"\n])*'
        mark = re.escape(separator.encode())
        kept = field + (rb"(?:" + mark + field + rb"){%d}" % (columns - 1))
        line = re.compile(rb"(?m)^(" + kept + rb")(?:" + mark + rb"[ \t]*){1,%d}(\r?)$" % empty)
        steps.append(lambda block: line.sub(rb"\1\2", block))
    if not steps:
        return None

    def clean(block: bytes) -> bytes:
        for step in steps:
            block = step(block)
        return block

    return clean


def blanks_as_tabs(block: bytes) -> bytes:
    """One tab where blanks are, outside quotation marks, and none at the ends of lines."""
    block = re.sub(rb"(?m)^[ \t]+|[ \t]+(?=\r?$)", b"", block)
    if b'"' not in block:
        return re.sub(rb"[ \t]+", b"\t", block)
    return re.sub(rb'("[^"\n]*")|[ \t]+', lambda found: found[1] or b"\t", block)


def numbered(names: Sequence[str]) -> tuple[list[str], set[str]]:
    """Names with numbers where they are there again, counted as pandas does: Fx, Fx.1, Fx.2."""
    there, made, repeated = set(names), [], set()
    seen: dict[str, int] = {}
    for name in names:
        if name not in seen:
            seen[name] = 0
            made.append(name)
            continue
        repeated.add(name)
        called = name
        while called in there:
            seen[name] += 1
            called = f"{name}.{seen[name]}"
        there.add(called)
        made.append(called)
    return made, repeated
