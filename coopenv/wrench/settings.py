"""Settings of a decomposition: definition of internal wrench, weights of the cost, solver."""

from dataclasses import dataclass, replace
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

WITH_SURROUNDINGS: tuple[Method, ...] = ("optimal", "point_mass")
"""Methods for any number of effectors that let one which gives nothing have no part: so what
touches the object ever so little is no other case than what does not touch it."""

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
    surroundings
        In an environment: whether contacts and wheels are one effector more
        (`coopenv.physics.surroundings`), so that what they cancel counts as internal. For the
        methods in `WITH_SURROUNDINGS`.

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
    surroundings: bool = False

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
        for name in ("include_induced", "surroundings"):
            value = getattr(self, name)
            if not isinstance(value, bool | np.bool_):
                raise InvalidInput(f"{name} must be True or False, got {value!r}; pass a bool")
            object.__setattr__(self, name, bool(value))
        if self.surroundings:
            self._check_surroundings()
        for name in ("virtual_masses", "virtual_inertias"):
            self._freeze(name)

    @property
    def plausible(self) -> bool:
        """Whether the method never claims that an effector did what it did not (eqs. 9-11)."""
        return self.method in PLAUSIBLE

    @property
    def of_agents(self) -> "Settings":
        """The same without surroundings."""
        return replace(self, surroundings=False) if self.surroundings else self

    def _check_surroundings(self) -> None:
        if self.method not in WITH_SURROUNDINGS:
            raise InvalidInput(
                f"surroundings must be False for method={self.method!r}, got True; only "
                f"{' and '.join(map(repr, WITH_SURROUNDINGS))} take an effector that may give "
                "nothing, anywhere on the body"
            )
        if self.solver == "pair":
            raise InvalidInput(
                "solver must not be 'pair' with surroundings=True, which are one effector more, "
                "got 'pair'; leave it out: 'auto' takes 'pair' where nothing is touched"
            )

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
