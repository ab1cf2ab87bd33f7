"""Work that is done piece by piece, within a budget of the processor's time."""

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

Piece = TypeVar("Piece")


def lacking(
    planned: Iterable[Piece],
    is_done: Callable[[Piece], bool],
    minutes: float,
    tell: Callable[[str], None],
) -> Iterator[Piece]:
    """Pieces that are not done when they are asked for, until so many minutes are spent.

    Parameters
    ----------
    planned
        All pieces, in order.
    is_done
        Whether one needs no work, asked just before it would begin.
    minutes
        Of the processor, from the first piece on, after which no other begins.
    tell
        Is told when the budget is spent and some piece is lacking.
    """
    began = time.process_time()
    for piece in planned:
        if is_done(piece):
            continue
        if time.process_time() - began >= 60 * minutes:
            tell("the budget is spent; the same command goes on")
            return
        yield piece
