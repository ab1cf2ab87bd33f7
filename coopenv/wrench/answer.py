"""Types of what methods and solvers return and how they are prepared: Answer, Solve, Prepare."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.settings import Settings


class Answer(NamedTuple):
    """Manipulation wrenches, and how good they are where that is a question."""

    manipulation: FloatArray  # h_M, (..., n, 3) or (..., n, 6) [N, N·m]
    gap: FloatArray | None = None  # bound (...) on how far the cost is from the best [N]; None: 0
    fell_back: BoolArray | None = None  # where (...) another solver's answer was taken; None: none


Solve: TypeAlias = Callable[[FloatArray], Answer]
"""Applied wrenches to their answer, at grips and with settings that were worked in before."""

Prepare: TypeAlias = Callable[[FloatArray, Settings], Solve]
"""A solver: works in grips and settings once."""


class Prepared(NamedTuple):
    """A method with grips and settings checked and worked in."""

    solver: str  # name of what will answer
    solve: Solve
