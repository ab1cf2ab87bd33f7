"""The registry of definitions of internal wrench."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from coopenv.arrays import FloatArray
from coopenv.wrench import optimal, point_mass, pseudoinverse, virtual_linkage

if TYPE_CHECKING:
    from coopenv.wrench.settings import Settings

Solve: TypeAlias = Callable[[FloatArray], tuple[FloatArray, FloatArray | None]]
"""Applied wrenches to manipulation wrenches and the gap ``(...)`` [N] of their cost, or None."""

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
