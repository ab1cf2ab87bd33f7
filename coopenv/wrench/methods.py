"""The registry of definitions of internal wrench."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench import optimal, point_mass, pseudoinverse, virtual_linkage

if TYPE_CHECKING:
    from coopenv.wrench.settings import Settings

Answer: TypeAlias = (
    tuple[FloatArray, FloatArray | None] | tuple[FloatArray, FloatArray, BoolArray]
)
"""Manipulation wrenches; the gap ``(...)`` [N] of their cost, or None; where `conic` stepped in."""

Solve: TypeAlias = Callable[[FloatArray], Answer]
"""Applied wrenches to their answer."""

Prepared: TypeAlias = tuple[str, Solve]
"""The solver's name, and the solver with grips and settings checked and worked in."""

METHODS: dict[str, "Callable[[FloatArray, Settings], Prepared]"] = {
    "optimal": optimal.prepare,
    "point_mass": point_mass.prepare,
    "moore_penrose": pseudoinverse.prepare,
    "nonsqueezing": pseudoinverse.prepare,
    "parametrized": pseudoinverse.prepare,
    "virtual_linkage": virtual_linkage.prepare,
}

PLAUSIBLE = frozenset({"optimal"})
"""Methods that satisfy eqs. 9-11 for every input, so that the relative cost lies in [0, 1]."""
