"""Registry of decomposition methods, that is of definitions of internal wrench, by their names."""

from collections.abc import Callable

from coopenv.arrays import FloatArray
from coopenv.wrench.answer import Prepared
from coopenv.wrench.methods import (
    max_internal,
    net_force,
    one_dimensional,
    optimal,
    point_mass,
    prioritized_torque,
    pseudoinverse,
    virtual_linkage,
)
from coopenv.wrench.settings import Settings

METHODS: dict[str, Callable[[FloatArray, Settings], Prepared]] = {
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
