"""Lines of a TOML file on which its keys stand, for errors about what a key means."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from coopenv.errors import CoopenvError, InvalidInput

Place = tuple[str | int, ...]
"""Keys from the top of a file to a value; numbers count in arrays."""


class Located(InvalidInput):
    """An error whose message already says where in a file its cause is."""


@dataclass(frozen=True, slots=True)
class Source:
    """A file, and the line of each of its keys; or nothing, of what was given from Python."""

    name: str = ""
    lines: Mapping[Place, int] = field(default_factory=dict)

    @classmethod
    def of(cls, name: str, text: str) -> "Source":
        """That of a file whose text is TOML."""
        return cls(name, dict(_Scanner(text).scan()))

    def where(self, place: Place) -> str:
        """``FILE, line N`` of a key, or of the nearest above it that has a line of its own."""
        if not self.name:
            return ".".join(map(str, place))
        for length in range(len(place), 0, -1):
            if place[:length] in self.lines:
                return f"{self.name}, line {self.lines[place[:length]]}"
        return self.name

    @contextmanager
    def at(self, place: Place) -> Iterator[None]:
        """Let an error of ours in the block say where its cause is; what says so already stays."""
        try:
            yield
        except Located:
            raise
        except CoopenvError as error:
            where = self.where(place)
            raise Located(f"{error} ({where})" if where else str(error)) from error


class _Scanner:
    """Goes once through a text that a TOML parser has accepted."""

    def __init__(self, text: str):
        self._text = text
        self._at = 0
        self._line = 1
        self._items: dict[Place, int] = {}  # of arrays of tables: the newest entry

    def scan(self) -> Iterator[tuple[Place, int]]:
        """Every key with its line, tables before what is in them; the first of a key counts."""
        seen: set[Place] = set()
        for place, line in self._keys():
            for length in range(1, len(place) + 1):
                if place[:length] not in seen:
                    seen.add(place[:length])
                    yield place[:length], line

    def _keys(self) -> Iterator[tuple[Place, int]]:
        table: Place = ()
        while self._skip():
            if self._peek() == "[":
                several = self._text.startswith("[[", self._at)
                self._go(2 if several else 1)
                line, name = self._line, self._key()
                table = self._table(name, several=several)
                self._go(2 if several else 1)
                yield table, line
            else:
                yield from self._entry(table)

    def _table(self, name: Place, *, several: bool) -> Place:
        """The place that a heading names: in arrays of tables, that of the newest."""
        place: Place = ()
        for number, key in enumerate(name):
            place = (*place, key)
            if several and number == len(name) - 1:
                self._items[place] = self._items.get(place, -1) + 1
            if place in self._items:
                place = (*place, self._items[place])
        return place

    def _entry(self, table: Place) -> Iterator[tuple[Place, int]]:
        line = self._line
        place = (*table, *self._key())
        yield place, line
        self._go(1)  # the equals sign
        yield from self._value(place)

    def _value(self, place: Place) -> Iterator[tuple[Place, int]]:
        self._skip()
        letter = self._peek()
        if letter in "\"'":
            self._string()
        elif letter == "[":
            yield from self._array(place)
        elif letter == "{":
            self._go(1)
            while self._skip() and self._peek() != "}":
                yield from self._entry(place)
                self._comma()
            self._go(1)
        else:
            while self._peek() not in ",]}#\n":
                self._go(1)

    def _array(self, place: Place) -> Iterator[tuple[Place, int]]:
        self._go(1)
        number = 0
        while self._skip() and self._peek() != "]":
            yield (*place, number), self._line
            yield from self._value((*place, number))
            self._comma()
            number += 1
        self._go(1)

    def _comma(self) -> None:
        self._skip()
        if self._peek() == ",":
            self._go(1)

    def _key(self) -> Place:
        """A dotted key, up to the sign behind it."""
        parts: list[str] = []
        while True:
            self._skip()
            parts.append(self._string() if self._peek() in "\"'" else self._bare())
            self._skip()
            if self._peek() != ".":
                return tuple(parts)
            self._go(1)

    def _bare(self) -> str:
        start = self._at
        while self._peek().isalnum() or self._peek() in "_-":
            self._go(1)
        return self._text[start : self._at]

    def _string(self) -> str:
        quote = self._peek()
        quotes = quote * 3 if self._text.startswith(quote * 3, self._at) else quote
        self._go(len(quotes))
        start = self._at
        while not self._text.startswith(quotes, self._at):
            self._go(2 if quote == '"' and self._peek() == "\\" else 1)
        found = self._text[start : self._at]
        self._go(len(quotes))
        while len(quotes) == 3 and self._peek() == quote:  # it may end in quotation marks
            self._go(1)
        return found

    def _skip(self) -> bool:
        """Pass blanks, ends of lines and comments; whether something is left."""
        while self._at < len(self._text):
            if self._peek() == "#":
                while self._peek() != "\n":
                    self._go(1)
            elif not self._peek().isspace():
                return True
            else:
                self._go(1)
        return False

    def _peek(self) -> str:
        return self._text[self._at] if self._at < len(self._text) else "\n"

    def _go(self, letters: int) -> None:
        self._line += self._text.count("\n", self._at, self._at + letters)
        self._at += letters
