"""Documented columns among those of a file, and what is said where one is not there."""

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from coopenv.errors import InvalidInput
from coopenv.logs.columns import EFFECTOR, is_documented
from coopenv.logs.layout import Layout
from coopenv.logs.limits import shown

LISTED = 30  # columns that a message lists


def find(
    path: str, columns: Sequence[str], layout: Layout, repeated: Collection[str]
) -> dict[str, str]:
    """Documented name → column, of all that are there."""
    there = set(columns)
    for name in repeated:
        if name not in layout.columns:
            raise InvalidInput(
                f"{path}: columns must differ, got {name!r} twice; rename one, or say which is "
                f"meant, --map {name}={name} or {name}={name}.1"
            )
    if len(there) < len(columns):
        twice = next(name for name, number in Counter(columns).items() if number > 1)
        raise InvalidInput(f"{path}: columns must differ, got {twice!r} twice; rename one")
    found = {name: name for name in columns if is_documented(name)}
    for name, said in layout.columns.items():
        found.pop(name, None)
        if not said:
            continue
        theirs = said[1:] if negated(said, there) else said
        if theirs not in there and _makes_the_pose(theirs.removeprefix("-"), layout):
            raise InvalidInput(
                f"{path}: {name} must be mapped to a column that [pose] columns do not name, got "
                f"{theirs!r}, of which the orientation is made; name it in one of the two"
            )
        if theirs not in there:
            hint = _hint(name, columns, theirs.removeprefix("-"))
            raise InvalidInput(
                f"{path}: {name} must be mapped to one of its columns, got {theirs!r}; {hint}"
            )
        found[name] = theirs
        if found.get(theirs) == theirs and theirs not in layout.columns and theirs != name:
            del found[theirs]  # its own name would mean something else
    zero = [name for name in columns if re.fullmatch(r"[ft]0[xyz]", name)]
    if zero and not set(zero) & set(found.values()):  # the first effector would be overlooked
        raise InvalidInput(
            f"{path}: effectors are numbered from 1, got column {zero[0]!r}; rename the columns or "
            f"map all of them, --map f1x=f0x f2x=f1x …; has: {_listed(columns)}"
        )
    return found


def _makes_the_pose(column: str, layout: Layout) -> bool:
    """Whether it is one of those that ``[pose]`` names, which may say whose it is."""
    named = [each.removeprefix("-") for each in layout.pose.columns]
    same = (each == column or each.endswith(f"/{column}") for each in named)
    return any(same) or any(column.endswith(f"/{each}") for each in named)


def negated(said: str, columns: Collection[str]) -> bool:
    """Whether a mapping turns the sign of a column: "-Fx", unless a column is called so."""
    return said.startswith("-") and said not in columns and said[1:] in columns


def require_no_other_case(
    path: str, rest: Sequence[str], found: dict[str, str], layout: Layout
) -> None:
    """Raise where a column that would be carried differs from a documented name in case alone."""
    for column in rest:
        name = column.strip().lower()
        known = is_documented(name) and name != column and column not in found
        if not known or name in layout.columns or (name == "time" and layout.joins):
            continue
        if name in found:
            raise InvalidInput(
                f"{path}: columns must differ by more than capitals, got {name!r} and "
                f"{shown(column)!r}; say which is meant, --map {name}={name} or "
                f"{name}={shown(column)}"
            )
        raise InvalidInput(
            f"{path}: column {shown(column)!r} must be called {name} if it is that, got "
            f"another spelling; say --map {name}={shown(column)}, or --map {name}= if it is not"
        )


@dataclass(frozen=True, slots=True)
class Need:
    """Insists on columns, and helps to find the one that is missing."""

    path: str
    columns: Sequence[str]
    found: dict[str, str]

    def __call__(self, *names: str, remedy: str = "") -> list[str]:
        """The names, if all are there; ``remedy`` is said where nothing better is known."""
        for name in names:
            if name not in self.found:
                advice = [_hint(name, self.columns), self._remedy(name) or remedy]
                raise InvalidInput(
                    f"{self.path}: column {name} must be there, got none of that name; "
                    f"{'; '.join(filter(None, advice))}"
                )
        return list(names)

    def _remedy(self, name: str) -> str:
        """An option that does without the column, if nothing of its kind is there."""
        effector = EFFECTOR.fullmatch(name)
        kind = "" if effector is None else effector[1]
        if kind == "t" and not some(self.found, "t"):
            return "say --forces-only if the effectors apply no torque"
        if kind == "r" and not some(self.found, "r"):
            return "or give the grips once with --grips"
        return ""


def some(found: dict[str, str], kind: str) -> str:
    """The columns of effectors of ``kind`` f, t or r that are there."""
    matches = [EFFECTOR.fullmatch(name) for name in found]
    return ", ".join(match[0] for match in matches if match is not None and match[1] == kind)


def _hint(name: str, columns: Sequence[str], like: str = "") -> str:
    """The column nearest to the name, or to ``like``, and all there are."""
    lower = {column.lower(): column for column in columns if like or not _taken(name, column)}
    nearest = get_close_matches((like or name).lower(), lower, n=1, cutoff=0.5)
    if nearest:
        theirs = lower[nearest[0]]
        return (
            f"did you mean {theirs!r}? rename it or map it, --map {name}={shown(theirs)}; has: "
            f"{_listed(columns)}"
        )
    return f"rename a column or map it, --map {name}=COLUMN; has: {_listed(columns)}"


def _taken(name: str, column: str) -> bool:
    """Whether a column's own name says that it is something other than ``name``."""
    if is_documented(column):
        return True
    other, own = EFFECTOR.fullmatch(column.lower()), EFFECTOR.fullmatch(name)
    return other is not None and own is not None and other[1] != own[1]


def _listed(columns: Sequence[str]) -> str:
    named = ", ".join(shown(column) for column in columns[:LISTED])
    return named + (" …" if len(columns) > LISTED else "")
