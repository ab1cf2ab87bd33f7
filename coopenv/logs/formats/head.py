"""Head of a text table: what comes before its rows, what separates fields, names and units."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice, pairwise
from pathlib import Path

from coopenv.errors import InvalidInput
from coopenv.logs.columns import is_documented
from coopenv.logs.declared.dialect import Dialect
from coopenv.logs.declared.units import is_unit
from coopenv.logs.formats.cleaning import BLANKS, blanks_as_tabs, numbered, split
from coopenv.logs.formats.encoded import Stream
from coopenv.logs.limits import Limits, shown

SEPARATORS = (",", ";", "\t", "|")
FEW = 2  # columns: no recording has fewer than three
LOOKED_AT = 32  # lines in which a header is looked for that is not where it was said to be
NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?|[+-]?(nan|inf)", re.IGNORECASE)
SHORTEN = "shorten it"


@dataclass(frozen=True, slots=True, kw_only=True)
class Head:
    """What the beginning of a text table says."""

    columns: list[str]  # names that are there twice have numbers, as pandas gives them
    repeated: frozenset[str]  # documented names that were there twice
    units: dict[str, str]  # column -> what the row of units says
    separator: str  # one character, or "blanks"
    body: int  # [bytes] of UTF-8 before the first row
    line: int  # number of the line in which the rows begin
    empty: int  # fields without a name or a value at the end of lines


@dataclass(slots=True)
class _Line:
    """A line before the rows."""

    number: int
    text: str
    begin: int  # [bytes] before it
    end: int

    @property
    def place(self) -> str:
        return f"line {self.number}"


@dataclass(slots=True)
class HeadReader:
    """Reads the head of a file.

    Parameters
    ----------
    path
        Named in errors.
    dialect, limits
        As declared.
    """

    path: Path
    dialect: Dialect
    limits: Limits
    _separator: str = field(default="", init=False)

    def read(self, file: Stream) -> Head:
        """The head of a file that is at its beginning; reads a few lines more.

        Raises
        ------
        InvalidInput
            If there is none, or it is not of the declared form.
        """
        lines = self._lines(file)
        first, comment = self._first(lines)
        self._require_text(first)
        no_header = self.dialect.no_header
        below = self._below(first, lines)
        is_row = no_header or (comment is not None and self._is_numeric(first))
        names = first if comment is None or no_header or not is_row else comment
        rows = [first] * is_row + list(islice(below, 2))
        begin, number = (first.begin, first.number) if is_row else (first.end, first.number + 1)
        self._separator = self._separator_of(names)
        called = self.fields(names.text, names.place)
        if not is_row:
            self._require_no_numbers(names)
            if len(called) <= FEW or self._is_of_other_width(called, rows):
                self._require_names(names, [*rows, *below])
        said: list[str] = []
        if self.dialect.units_row:
            said, begin, number = self._units(rows)
            rows = rows[1:]
        elif rows:
            self._require_no_units(rows[0])
        called, empty = self._without_empty(called, rows)
        if no_header:
            called = [str(k) for k in range(len(called))]
        place = f"{self.path}, {names.place}"
        self.limits.require("columns", len(called), place, "leave out what is not needed")
        columns, repeated = numbered(called)
        return Head(
            columns=columns,
            repeated=frozenset(name for name in repeated if is_documented(name)),
            units={name: unit for name, unit in zip(columns, said, strict=False) if unit},
            separator=self._separator,
            body=begin,
            line=number,
            empty=empty,
        )

    def fields(self, line: str, place: str, separator: str = "") -> list[str]:
        """Fields of a line, without quotation marks and blanks around them."""
        separator = separator or self._separator
        if separator == BLANKS:
            line, separator = blanks_as_tabs(line.encode()).decode(), "\t"
        return [each.strip() for each in split(self.path, line, separator, place)]

    def _peeked(self, line: _Line, separator: str = "") -> list[str]:
        """Fields of a row, which is read again later; none where it is damaged."""
        try:
            return self.fields(line.text, line.place, separator) or [""]
        except InvalidInput:
            return [""]

    def _lines(self, file: Stream) -> Iterator[_Line]:
        number = end = 0
        while data := file.readline(self.limits.row_bytes + 1):
            number, begin, end = number + 1, end, end + len(data)
            if len(data) > self.limits.row_bytes:
                place = f"{self.path}, line {number}"
                self.limits.require("row_bytes", "more", place, SHORTEN)
            yield _Line(number, self._decoded(data, number), begin, end)

    def _decoded(self, data: bytes, number: int) -> str:
        try:
            return data.decode().rstrip("\r\n")
        except UnicodeDecodeError as error:
            raise InvalidInput(
                f"{self.path}, line {number} must be UTF-8 text, got {data[error.start :][:8]!r}; "
                "say its --encoding, as cp1252, or save the file in UTF-8"
            ) from error

    def _first(self, lines: Iterator[_Line]) -> tuple[_Line, _Line | None]:
        """The first line of the table, and the comment before it if there is one."""
        mark, comment, number = self.dialect.comment, None, 0
        for line in lines:
            number = line.number
            if number <= self.dialect.skip_lines:
                continue
            if mark and line.text.lstrip().startswith(mark):
                text = line.text.lstrip()[len(mark) :].strip()
                comment = _Line(line.number, text, line.begin, line.end) if text else comment
                continue
            if line.text.strip():
                return line, comment
            if not mark:
                break
        if 0 < number <= self.dialect.skip_lines:
            raise InvalidInput(
                f"{self.path} must have its header below the {self.dialect.skip_lines} lines that "
                f"are skipped, got {number} lines; lower --skip-lines"
            )
        seen = "a blank line" if number else "an empty file"
        raise InvalidInput(
            f"{self.path}, line {max(number, 1)} must name the columns, got {seen}; begin the file "
            "with its header, or say --skip-lines"
        )

    def _require_text(self, line: _Line) -> None:
        if "\0" in line.text:
            raise InvalidInput(
                f"{self.path}, {line.place} must name the columns, got bytes that are no text; "
                "export the recording as CSV"
            )
        if "\r" in line.text:
            raise InvalidInput(
                f"{self.path}: lines must end with a line feed, got carriage returns alone; save "
                "the file with the line ends of Unix or Windows"
            )

    def _below(self, header: _Line, lines: Iterator[_Line]) -> Iterator[_Line]:
        """A few lines of the table after its first one, as far as they are text."""
        mark = self.dialect.comment
        try:
            for line in lines:
                if line.number > header.number + LOOKED_AT:
                    return
                if line.text.strip() and not (mark and line.text.lstrip().startswith(mark)):
                    yield line
        except InvalidInput:  # told with the rows
            return

    def _separator_of(self, line: _Line) -> str:
        said, decimal = self.dialect.separator, self.dialect.decimal
        if said == "auto":
            known = [each for each in SEPARATORS if each != decimal or not self.dialect.no_header]
            said = max(known, key=line.text.count)
            if not line.text.count(said) and len(line.text.split()) > 1:
                return BLANKS
        if decimal == said:
            raise InvalidInput(
                f"{self.path}: decimal must not be what separates the columns, got {decimal!r} for "
                "both; separate them with semicolons, or say --separator"
            )
        return said

    def _is_numeric(self, line: _Line) -> bool:
        """Whether it is a row of numbers, whatever separates them."""
        words = [each for each in re.split(r"[;\t| ]+|,(?!\d)|(?<=\d),", line.text) if each.strip()]
        return bool(words) and all(NUMBER.fullmatch(each.strip('" ')) for each in words)

    def _require_no_numbers(self, names: _Line) -> None:
        """Raise where the line that should name columns is a row of measured numbers."""
        if self._is_numeric(names) and any(each in names.text for each in ".,-+"):
            fields = self._peeked(names)
            if not all(each.strip('" ').isdecimal() for each in fields):  # as pandas names them
                raise InvalidInput(
                    f"{self.path}, {names.place} must name the columns, got numbers such as "
                    f"{shown(fields[0], 20)}; say --no-header"
                )

    def _is_of_other_width(self, called: list[str], rows: list[_Line]) -> bool:
        """Whether the line below has fewer or more fields than there are names."""
        below = self._peeked(rows[0]) if rows else called
        ends = len(below) == len(called) + 1 and not below[-1]  # with a separator
        return len(below) != len(called) and not ends

    def _require_names(self, names: _Line, rows: list[_Line]) -> None:
        """Raise where a line that should name columns is of a preamble, and a later one does."""
        for line, following in pairwise(rows):
            separator = max(SEPARATORS, key=line.text.count)
            separator = separator if line.text.count(separator) else BLANKS
            words = self._peeked(line, separator)
            called, below = len(words), len(self._peeked(following, separator))
            if FEW < called == below and not any(map(NUMBER.fullmatch, words)):
                raise InvalidInput(
                    f"{self.path}, {names.place} must name the columns, got "
                    f"{shown(names.text, 40)!r}, where {line.place} looks like names; say "
                    f"--skip-lines {line.number - 1}"
                )

    def _units(self, rows: list[_Line]) -> tuple[list[str], int, int]:
        if not rows:
            raise InvalidInput(
                f"{self.path} must have a row of units below its header, got nothing; leave out "
                "--units-row"
            )
        line = rows[0]
        return self.fields(line.text, line.place), line.end, line.number + 1

    def _require_no_units(self, line: _Line) -> None:
        """Raise where the first row is one of units, of which nothing was said."""
        named = [each for each in self._peeked(line) if each.strip("[]()- ")]
        if len(named) > 1 and all(is_unit(each) for each in named) and any(map(_has_letter, named)):
            raise InvalidInput(
                f"{self.path}, {line.place} must be a row of data, got units such as "
                f"{shown(named[0], 20)!r}; say --units-row"
            )

    def _without_empty(self, called: list[str], rows: list[_Line]) -> tuple[list[str], int]:
        """Names of columns, and how many fields without name and value end the lines."""
        if self._separator == BLANKS:
            return called, 0
        there = max((k for k, name in enumerate(called) if name), default=0) + 1
        if self.dialect.no_header:
            there = len(called) - (len(called) > 1 and not called[-1])
        first = self._peeked(rows[0]) if rows else [""]
        if there < len(called):
            if any(first[there:]) and len(first) >= len(called):  # values without a name
                return [name or str(k) for k, name in enumerate(called)], 0
            return called[:there], len(called) - there
        return called, int(len(first) == len(called) + 1 and not first[-1])


def _has_letter(text: str) -> bool:
    return any(each.isalpha() for each in text)
