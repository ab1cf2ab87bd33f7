"""Elements of MATLAB files of version 5 to 7, checked before SciPy reads them.

SciPy follows them in machine code and trusts the kind that each says it has: one that is none, or a
matrix that goes on past its end, may end the interpreter. What is looked at is what SciPy goes by.

Source: MAT-File Format, The MathWorks; `scipy.io.matlab`.
"""

import math
from typing import Literal

MATRIX = 14
NUMBERS = frozenset((1, 2, 3, 4, 5, 6, 7, 9, 12, 13, 16, 17, 18))  # kinds of data, text among them
CELL, STRUCTURE, OBJECT, TEXT, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 4, 5, 16, 17  # classes
ARRAYS = frozenset((TEXT, *range(6, 16)))  # classes of one block of data
COMPLEX = 0x0800  # flag of a second block
HEADER = 16  # [bytes] tag and flags
DEEPEST = 32  # matrices within one another
MOST_AXES = 32


class Elements:
    """A matrix as the elements that it is made of.

    Parameters
    ----------
    data
        From its tag on.
    order
        Of bytes.
    """

    def __init__(self, data: bytes, order: Literal["little", "big"]):
        self._data, self._at = memoryview(data), 0
        self._order: Literal["little", "big"] = order

    def require_matrix(self, depth: int = 0) -> None:
        """Go through a matrix; raise `ValueError` where SciPy could not."""
        if depth > DEEPEST:
            raise ValueError(f"matrices nested more than {DEEPEST} deep")
        kind, size = self._word(), self._word()
        if kind != MATRIX:
            raise ValueError(f"kind {kind} at byte {self._at - 8}, where a matrix should be")
        if not size:
            return
        flags = int.from_bytes(self._take(HEADER)[8:12], self._order)
        group = flags & 0xFF
        if group == OPAQUE:
            for _ in range(3):
                self._element()
            self.require_matrix(depth + 1)
            return
        axes = self._whole_numbers()
        if len(axes) > MOST_AXES or min(axes, default=0) < 0:
            raise ValueError(f"a shape that is none, before byte {self._at}")
        self._element()  # name
        self._content(group, bool(flags & COMPLEX), math.prod(axes), depth)

    def _content(self, group: int, is_complex: bool, size: int, depth: int) -> None:
        """Go through what follows the name."""
        if group in ARRAYS or group == SPARSE:
            blocks = (3 if group == SPARSE else 1) + is_complex
            for _ in range(blocks):
                self._element()
        elif group == FUNCTION:
            self.require_matrix(depth + 1)
        elif group in (CELL, STRUCTURE, OBJECT):
            self._matrices(size * (1 if group == CELL else self._fields(group)), depth)
        else:
            raise ValueError(f"class {group} before byte {self._at}, which is none")

    def _fields(self, group: int) -> int:
        """How many fields a structure has, whose names come next."""
        if group == OBJECT:
            self._element()  # its class
        length = self._whole_numbers()
        if len(length) != 1 or length[0] < 1:
            raise ValueError(f"no length of the names of fields before byte {self._at}")
        return len(self._element()) // length[0]

    def _matrices(self, count: int, depth: int) -> None:
        """Go through so many."""
        if count > len(self._data) - self._at:
            raise ValueError(f"{count:,} matrices from byte {self._at} on, more than there is")
        for _ in range(count):
            self.require_matrix(depth + 1)

    def _element(self) -> memoryview:
        """Data of the next element, whose kind must be one of numbers."""
        first = self._word()
        kind, size = first & 0xFFFF, first >> 16
        if size:  # as small as its tag
            data = self._take(4)[:size]
            fits = size <= 4
        else:
            kind, size = first, self._word()
            data, fits = self._take(size), True
            self._at += -size % 8
        if kind not in NUMBERS or not fits:
            raise ValueError(f"an element of kind {kind} before byte {self._at}, which is none")
        return data

    def _whole_numbers(self) -> list[int]:
        data = self._element()
        return [
            int.from_bytes(data[k : k + 4], self._order, signed=True)
            for k in range(0, len(data) // 4 * 4, 4)
        ]

    def _word(self) -> int:
        return int.from_bytes(self._take(4), self._order)

    def _take(self, size: int) -> memoryview:
        data = self._data[self._at : self._at + size]
        if len(data) < size:
            raise ValueError(f"{len(data)} of {size} bytes from byte {self._at} on")
        self._at += size
        return data
