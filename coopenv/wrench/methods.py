"""The registry of definitions of internal wrench."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench import (
    max_internal,
    net_force,
    one_dimensional,
    optimal,
    point_mass,
    prioritized_torque,
    pseudoinverse,
    virtual_linkage,
)

if TYPE_CHECKING:
    from coopenv.wrench.settings import Settings

Answer: TypeAlias = tuple[FloatArray, FloatArray | None] | tuple[FloatArray, FloatArray, BoolArray]
"""Manipulation wrenches; the gap ``(...)`` [N] of their cost, or None; where `conic` stepped in."""

Solve: TypeAlias = Callable[[FloatArray], Answer]
"""Applied wrenches to their answer."""

Prepared: TypeAlias = tuple[str, Solve]
"""The solver's name, and the solver with grips and settings checked and worked in."""

METHODS: dict[str, "Callable[[FloatArray, Settings], Prepared]"] = {
    "optimal": optimal.prepare,
    "prioritized_torque": prioritized_torque.prepare,
    "point_mass": point_mass.prepare,
    "moore_penrose": pseudoinverse.prepare,
    "nonsqueezing": pseudoinverse.prepare,
    "parametrized": pseudoinverse.prepare,
    "virtual_linkage": virtual_linkage.prepare,
    "max_internal": max_internal.prepare,
    "one_dimensional": one_dimensional.prepare,
    "net_force": net_force.prepare,
}

GENERAL_METHODS = (
    "optimal",
    "point_mass",
    "moore_penrose",
    "nonsqueezing",
    "parametrized",
    "virtual_linkage",
)
"""Methods for any number of effectors, in plane and space, with forces and torques."""

PLAUSIBLE = frozenset({"optimal", "prioritized_torque", "one_dimensional"})
"""Methods that satisfy eqs. 9-11 for every input, so that the relative cost lies in [0, 1]."""
