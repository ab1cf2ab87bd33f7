"""Settings of a decomposition: definition of internal wrench, weights of the cost, solver."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from coopenv.arrays import finite_array, positive
from coopenv.errors import InvalidInput, UnknownName

Method: TypeAlias = Literal[
    "optimal",
    "prioritized_torque",
    "point_mass",
    "moore_penrose",
    "nonsqueezing",
    "parametrized",
    "virtual_linkage",
    "max_internal",
    "one_dimensional",
    "net_force",
]
"""Definitions of internal wrench; `METHODS` has the function of each."""

Solver: TypeAlias = Literal["auto", "pair", "structured", "conic"]
"""What solves ``method="optimal"``; `SOLVERS` has the function of each but ``"auto"``."""

PLAUSIBLE: frozenset[Method] = frozenset({"optimal", "prioritized_torque", "one_dimensional"})
"""Methods that satisfy eqs. 9-11 for every input, so that the relative cost lies in [0, 1]."""

Nested = float | tuple["Nested", ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Which definition of internal wrench, which cost, which solver.

    Hashable, so that decompositions can be cached by their settings.

    Parameters
    ----------
    method
        A name in `METHODS`.
    torque_weight
        w of the cost (eq. 17), in ]0, 1[; also for the relative cost of the other methods.
    include_induced
        Whether the cost counts induced torques: s = 1.
    solver
        For ``method="optimal"``: a name in `SOLVERS`, or ``"auto"``, which takes ``"pair"`` for two
        planar effectors and ``"structured"`` for all others.
    virtual_masses, virtual_inertias
        For ``method="parametrized"``: m_i* ``(n,)`` [kg] and J_i* ``(n,)``, in space also
        ``(n, 3, 3)`` [kg m²]; all 1 by default. Any nesting of sequences; kept as tuples.

    Raises
    ------
    UnknownName
        If the method or the solver does not exist.
    InvalidInput
        If a value breaks its rule or does not go with the method.
    """

    method: str = "optimal"
    torque_weight: float = 0.5  # dimensionless
    include_induced: bool = False
    solver: str = "auto"
    virtual_masses: tuple[float, ...] | None = None  # [kg]
    virtual_inertias: tuple[Nested, ...] | None = None  # [kg m²]

    def __post_init__(self):
        for name, known in (("method", get_args(Method)), ("solver", get_args(Solver))):
            value = getattr(self, name)
            if not isinstance(value, str) or value not in known:
                raise UnknownName(name, value, known)
        if self.solver != "auto" and self.method != "optimal":
            raise InvalidInput(
                f"solver must be 'auto' for method={self.method!r}, which has one solver, got "
                f"{self.solver!r}; leave it out"
            )
        weight = positive(self.torque_weight, "torque_weight", or_zero=True)
        if not 0.0 < weight < 1.0:
            raise InvalidInput(
                f"torque_weight must be in ]0, 1[, got {self.torque_weight!r}; at 0 and 1 part of "
                "the wrench has no cost: take a value close to it, or 0.5"
            )
        object.__setattr__(self, "torque_weight", weight)
        if not isinstance(self.include_induced, bool | int | np.bool_) or (
            self.include_induced not in (0, 1)
        ):
            raise InvalidInput(
                f"include_induced must be True or False, got {self.include_induced!r}; pass a bool"
            )
        object.__setattr__(self, "include_induced", bool(self.include_induced))
        for name in ("virtual_masses", "virtual_inertias"):
            self._freeze(name)

    @property
    def plausible(self) -> bool:
        """Whether the method never claims that an effector did what it did not (eqs. 9-11)."""
        return self.method in PLAUSIBLE

    def _freeze(self, name: str) -> None:
        value = getattr(self, name)
        if value is None:
            return
        if self.method != "parametrized":
            raise InvalidInput(
                f"{name} must be left out for method={self.method!r}, got {value!r}; "
                "it belongs to method='parametrized'"
            )
        object.__setattr__(self, name, _nested_tuple(finite_array(value, name)))


def _nested_tuple(array: npt.NDArray[np.float64]) -> object:
    return tuple(map(_nested_tuple, array)) if array.ndim else float(array)
