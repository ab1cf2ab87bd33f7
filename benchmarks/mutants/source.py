"""Source text with the places of its syntax, and a change of one span of it."""

import ast
import io
import tokenize
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Change:
    """A mutant: one span of bytes of a file, and what stands there instead."""

    file: str
    line: int  # of the span's beginning
    start: int  # [byte]
    end: int
    new: str
    operator: str
    owner: str  # function or class of the module it stands in, or the constant; "" for neither
    at_import: bool  # outside of functions' bodies

    @property
    def key(self) -> str:
        """A name for it in results."""
        return f"{self.file}:{self.start}-{self.end}:{self.new}"

    def applied(self, text: bytes) -> bytes:
        """The changed text."""
        return text[: self.start] + self.new.encode() + text[self.end :]

    def lines(self, text: bytes) -> tuple[str, str]:
        """Whole lines around the span, before and after the change, in one line each."""
        first = text.rfind(b"\n", 0, self.start) + 1
        last = text.find(b"\n", self.end)
        last = len(text) if last < 0 else last
        after = text[first : self.start] + self.new.encode() + text[self.end : last]
        return _in_one_line(text[first:last]), _in_one_line(after)

    def as_json(self) -> dict[str, Any]:
        """Its fields by name."""
        return asdict(self)


def _in_one_line(text: bytes) -> str:
    return " ".join(text.decode().split())


@dataclass(frozen=True)
class Token:
    """A word or sign of the text, between two byte offsets."""

    text: str
    start: int
    end: int


class Source:
    """A file's text, syntax and tokens."""

    def __init__(self, file: str, text: bytes) -> None:
        self.file = file
        self.text = text
        self.tree = ast.parse(text)
        self._starts = [0]
        for line in text.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Where a node begins and ends [byte], without brackets around it."""
        found: Any = node
        start = self._starts[found.lineno - 1] + found.col_offset
        return start, self._starts[found.end_lineno - 1] + found.end_col_offset

    def of(self, node: ast.AST) -> str:
        """The text of a node."""
        start, end = self.span(node)
        return self.text[start:end].decode()

    def line(self, offset: int) -> int:
        """The number of the line, from 1, in which a byte stands."""
        return bisect_right(self._starts, offset)

    @cached_property
    def tokens(self) -> list[Token]:
        """All tokens but comments and ends of lines."""
        lines = self.text.decode().splitlines(keepends=True)
        found = []
        for token in tokenize.generate_tokens(io.StringIO(self.text.decode()).readline):
            if token.type in (tokenize.OP, tokenize.NAME, tokenize.NUMBER, tokenize.STRING):
                start, end = (
                    self._starts[row - 1] + len(lines[row - 1][:column].encode())
                    for row, column in (token.start, token.end)
                )
                found.append(Token(token.string, start, end))
        return found

    def token_at(self, offset: int) -> int:
        """The index of the first token that begins at a byte or behind it."""
        return bisect_left(self.tokens, offset, key=lambda token: token.start)

    def between(self, left: ast.AST, right: ast.AST, words: Iterable[str]) -> tuple[int, int]:
        """The span of an operator, of one word or two, between two operands."""
        words = tuple(words)
        first, last = self.span(left)[1], self.span(right)[0]
        found = self.tokens[self.token_at(first) : self.token_at(last)]
        for index in range(len(found)):
            run = found[index : index + len(words)]
            if tuple(token.text for token in run) == words:
                return run[0].start, run[-1].end
        raise ValueError(f"{self.file} must have {' '.join(words)} in {first}-{last}; report it")
