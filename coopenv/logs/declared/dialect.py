"""Form of a text table: encoding, what separates, preamble, header, units, times as text."""

import codecs
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from coopenv.arrays import whole
from coopenv.errors import InvalidInput, UnknownName
from coopenv.logs.limits import shown

ENCODINGS = (
    "ascii", "utf-8", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1250", "cp1251", "cp1252",
    "cp437", "cp850", "cp932", "latin-1", "iso8859-2", "iso8859-15", "mac-roman", "shift_jis",
    "euc_jp", "euc_kr", "gb18030", "big5",
)  # fmt: skip
SEPARATORS: Mapping[str, str] = {
    ",": ",", "comma": ",", ";": ";", "semicolon": ";", "\t": "\t", "tab": "\t", "\\t": "\t",
    "|": "|", " ": "blanks", "blanks": "blanks", "auto": "auto",
}  # fmt: skip
LONGEST_COMMENT = 8  # [characters] of a mark


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """How a table is written as text; other formats have no use for it.

    Raises
    ------
    InvalidInput
        If a field is of another type or beyond its rule.
    UnknownName
        If an encoding or a separator is none of those there are.
    """

    decimal: str = "."  # of the numbers
    encoding: str = "auto"  # UTF-8, or UTF-16 and 32 where the file begins like it
    separator: str = "auto"  # "," ";" "tab" "|" or "blanks"; what the header has most of
    comment: str = ""  # lines that begin with it are passed over
    skip_lines: int = 0  # before the header
    no_header: bool = False  # columns are called 0, 1, 2 and so on
    units_row: bool = False  # the line below the header says the unit of each column

    def __post_init__(self):
        for name in ("decimal", "encoding", "separator", "comment"):
            if not isinstance(getattr(self, name), str):
                raise InvalidInput(
                    f"{name} must be a word, got {shown(getattr(self, name))}; see "
                    "docs/recordings.md for those that are known"
                )
        if self.decimal not in (".", ","):
            raise UnknownName("decimal", self.decimal, (".", ","))
        if self.separator not in SEPARATORS:
            raise UnknownName("separator", self.separator, SEPARATORS)
        object.__setattr__(self, "separator", SEPARATORS[self.separator])
        object.__setattr__(self, "encoding", _encoding(self.encoding))
        object.__setattr__(self, "skip_lines", whole(self.skip_lines, "skip_lines", at_least=0))
        for name in ("no_header", "units_row"):
            require_flag(name, getattr(self, name))
        if len(self.comment) > LONGEST_COMMENT or self.comment != self.comment.strip():
            raise InvalidInput(
                f"comment must be a mark of at most {LONGEST_COMMENT} characters without blanks, "
                f"got {shown(self.comment)!r}; give what such lines begin with, as #"
            )


def require_flag(name: str, value: Any) -> None:
    """Raise `InvalidInput` unless a value is a truth value."""
    if not isinstance(value, bool):
        raise InvalidInput(
            f"{name} must be true or false, got {shown(repr(value))}; write it without quotation "
            "marks"
        )


def _encoding(said: str) -> str:
    """The encoding as `ENCODINGS` spells it, or ``auto``."""
    if said == "auto":
        return said
    try:
        name = codecs.lookup(said).name if said.isascii() and "\0" not in said else ""
    except LookupError:
        name = ""
    for known in ENCODINGS:
        if codecs.lookup(known).name == name:
            return known
    raise UnknownName("encoding", said, ("auto", *ENCODINGS))
