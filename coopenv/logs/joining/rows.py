"""Rows of joined devices, named by the lines of the clock's file."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from coopenv.arrays import IntArray
from coopenv.logs.formats.chunks import Chunk


@dataclass(frozen=True, slots=True, kw_only=True)
class JoinedChunk(Chunk):
    """Rows of a clock, with what others say at their times."""

    clock: Chunk | None
    whose: str  # whose rows they are, if not of the recording itself
    index: IntArray  # (T,) rows of the clock
    own: Mapping[str, str]  # column -> its name in the file of the clock
    owner: Mapping[str, str]  # column -> device

    def place(self, row: int) -> str:
        """As the clock calls it."""
        if self.clock is None:
            return f"row {self.first_row + row}"
        return self.clock.place(int(self.index[row])) + self.whose

    def called(self, column: str) -> str:
        """As the clock calls what it has under the same name."""
        if self.clock is not None and self.own.get(column) == column:
            return self.clock.called(column)
        return f"column {column!r}"

    def text(self, row: int, column: str) -> str:
        """What the clock's file says; of other devices, that they say nothing."""
        if self.clock is not None and column in self.own:
            return self.clock.text(int(self.index[row]), self.own[column])
        if not np.isnan(self.numbers[column][row]):
            return str(self.numbers[column][row])
        return f"no sample of {self.owner.get(column, column)} that is near enough"
