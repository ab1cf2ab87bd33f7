"""Decomposition of applied wrenches into manipulation wrenches and internal wrenches."""

from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, finite_array
from coopenv.errors import InvalidInput
from coopenv.wrench import measures, shares
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.grasp import (
    checked_grips,
    require_wrench_per_grip,
    sum_at_centre,
    wrench_size,
)
from coopenv.wrench.measures import (
    APPLIED_COST,
    COST,
    FORCE_LEVEL,
    RELATIVE_COST,
    TORQUE_LEVEL,
    WASTED_COST,
    level_kernel,
)
from coopenv.wrench.methods import METHODS
from coopenv.wrench.plausibility import Residuals, residuals_of
from coopenv.wrench.rehearsal import rehearse
from coopenv.wrench.settings import Settings
from coopenv.wrench.shares import EnergyShare, LoadShare, ShareOrEven

Value = TypeVar("Value")


def decompose(
    applied: npt.ArrayLike,
    grips: npt.ArrayLike,
    *,
    method: str = "optimal",
    solver: str = "auto",
    torque_weight: float = 0.5,
    include_induced: bool = False,
    virtual_masses: npt.ArrayLike | None = None,
    virtual_inertias: npt.ArrayLike | None = None,
    surroundings: bool = False,
) -> "Decomposition":
    """Split applied wrenches into manipulation and internal wrenches, h = h_M + h_I (eq. 5).

    Parameters
    ----------
    applied
        ``(..., n, 3)`` planar [fx, fy, tz] or ``(..., n, 6)`` spatial [f, t], object frame
        [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it, object frame [m].
    method, solver, torque_weight, include_induced, virtual_masses, virtual_inertias
        See `Settings`.
    surroundings
        Refused unless false: arrays know of no surroundings but those that are given as effectors.

    Returns
    -------
    A `Decomposition` of the batch shape of ``applied`` and ``grips`` together.

    Raises
    ------
    UnknownName
        If the method or the solver does not exist.
    InvalidInput
        If a shape or a number is wrong, or method, solver and grips do not go together.
    """
    settings = Settings(
        method=method,
        solver=solver,
        torque_weight=torque_weight,
        include_induced=include_induced,
        virtual_masses=virtual_masses,  # pyright: ignore[reportArgumentType]  # made a tuple there
        virtual_inertias=virtual_inertias,  # pyright: ignore[reportArgumentType]
        surroundings=surroundings,
    )
    return Decomposer(grips, settings)(finite_array(applied, "applied").copy())


class Decomposer:
    """Grips and settings checked once, then called on applied wrenches as often as you like.

    Parameters
    ----------
    grips
        ``(..., n, 2)`` planar or ``(..., n, 3)`` spatial, object frame [m]; with a batch shape, one
        set per sample.
    settings
        Which definition of internal wrench, which cost, which solver; without surroundings.

    Raises
    ------
    InvalidInput
        If the grips have a wrong shape or number or do not go with method or solver.
    """

    __slots__ = ("_core_shape", "_solve", "grips", "level_parameters", "settings", "solver")

    @property
    def solve(self) -> Solve:
        """What answers, without a check of shapes."""
        return self._solve

    def __init__(self, grips: npt.ArrayLike, settings: Settings | None = None):
        settings = Settings() if settings is None else settings
        if settings.surroundings:
            raise InvalidInput(
                "surroundings must be False for wrenches in arrays, got True; only environments "
                "know their surroundings: give what they apply as one more effector, with the "
                "place where it acts as its grip"
            )
        self.grips = checked_grips(grips).copy()
        self.grips.flags.writeable = False
        self.settings = settings
        self._core_shape = (self.grips.shape[-2], wrench_size(self.grips.shape[-1]))
        self.solver, self._solve = METHODS[settings.method](self.grips, settings)
        self.level_parameters = measures.level_parameters(
            settings.torque_weight, settings.include_induced, settings.plausible
        )

    def __reduce__(self):
        return Decomposer, (self.grips, self.settings)

    def compile(self) -> "Decomposer":
        """Compile all that a call needs, and all that can be asked of its answer.

        For control loops, whose first call then takes no longer than the others. What is in the
        cache is read from there.

        Returns
        -------
        Itself.
        """
        rehearse(self)
        return self

    def answer(self, applied: FloatArray) -> Answer:
        """What the method answers to wrenches as a call takes them, without a `Decomposition`."""
        if applied.shape[-2:] != self._core_shape or self.grips.ndim > 2:
            require_wrench_per_grip(applied, self.grips)
        return self._solve(applied)

    def of_worlds(self, worlds: BoolArray) -> "Decomposer":
        """That of some worlds ``(world,)``: itself, if all have the same grips."""
        return self if self.grips.ndim == 2 else Decomposer(self.grips[worlds], self.settings)

    def __call__(self, applied: FloatArray) -> "Decomposition":
        """Decompose wrenches whose numbers were checked before.

        Parameters
        ----------
        applied
            float64 ``(..., n, 3)`` or ``(..., n, 6)``, finite [N, N·m]. Only its shape is checked.
            Kept, not copied.

        Raises
        ------
        InvalidInput
            If the shape does not go with the grips.
        """
        answer = self.answer(applied)
        if answer.manipulation.shape != applied.shape:
            applied = np.broadcast_to(applied, answer.manipulation.shape)
        return Decomposition(applied, answer, self)


class Surrounded(NamedTuple):
    """Agents and what surrounds the object as effectors, in the place of a `Decomposer`."""

    grips: FloatArray  # (world, n + 1, 2) [m]
    settings: Settings
    solver: str
    level_parameters: FloatArray


class _once(Generic[Value]):  # noqa: N801  # a decorator
    """A property that is computed when first asked for.

    `functools.cached_property` takes a lock in Python 3.11 and before, which costs as much as
    the measures of one world, and which all decompositions share.
    """

    def __init__(self, compute: Callable[[Any], Value]):
        self._compute, self._name = compute, compute.__name__
        self.__doc__ = compute.__doc__

    def __get__(self, instance: Any, owner: type | None = None) -> Value:
        if instance is None:
            return self  # pyright: ignore[reportReturnType]  # as a property of the class
        value = instance.__dict__[self._name] = self._compute(instance)
        return value


class Decomposition:
    """Applied wrenches and their split; everything beyond the split is computed when asked for.

    Attributes
    ----------
    applied, manipulation
        h and h_M, ``(..., n, 3)`` or ``(..., n, 6)`` [N, N·m].
    """

    def __init__(self, applied: FloatArray, answer: Answer, decomposer: "Decomposer | Surrounded"):
        self.applied = applied
        self.manipulation = answer.manipulation
        self._answer = answer
        self._decomposer = decomposer

    def __repr__(self) -> str:
        num_effectors, size = self.applied.shape[-2:]
        space = "plane" if size == 3 else "space"
        return (
            f"<Decomposition of {self.applied.shape[:-2]} wrenches of {num_effectors} effectors in "
            f"the {space}, method={self.settings.method!r}, solver={self.solver!r}>"
        )

    @property
    def grips(self) -> FloatArray:
        """Where the effectors hold, as given, ``(..., n, 2)`` or ``(..., n, 3)`` [m]."""
        return self._decomposer.grips

    @property
    def settings(self) -> Settings:
        """Method, cost and solver that were asked for."""
        return self._decomposer.settings

    @property
    def solver(self) -> str:
        """Who answered, whatever was asked for; ``"closed_form"`` where no solver is needed."""
        return self._decomposer.solver

    @_once
    def gap(self) -> FloatArray:
        """Bound ``(...)`` on how far the cost is from the optimum [N]; 0 for closed forms.

        For ``method="optimal"`` the least cost J* of eqs. 17-21 lies within ``cost`` ± ``gap``. A
        gap is at most the cost, and where it is the cost, J* may be any. Bounded is the cost, not
        the wrench, which need not be unique. J* is that of the grips as they count: on a line
        through the centre of mass within 1e-12 of the longest lever, and at one place within 1e-15
        of it.

        That the cost is no further above J* is proved: of two planar effectors off an axis by the
        bracket of the optimum, otherwise by the dual program, whatever the solver believes. That it
        is no further below, as constraints are met to rounding only, is for ``"structured"`` and
        ``"conic"`` an estimate: residuals times multipliers. Where two grips, or their line and the
        centre of mass, nearly coincide, that is the multiplier of the tiny lever in between.
        `docs/decomposition.md` says how large gaps are and how often estimates failed.

        For ``method="max_internal"``, by how much √Σ‖f_I,i‖² may fall short of the largest [N].
        """
        gap = self._answer.gap
        if gap is None:
            return np.zeros(self.applied.shape[:-2])
        return np.minimum(gap, self.cost) if self.settings.method == "optimal" else gap

    @_once
    def fell_back(self) -> BoolArray:
        """Where ``(...)`` ``"structured"`` took the answer of another solver.

        That is ``"pair"`` for two planar effectors whose grips nearly coincide, and ``"conic"``
        where its own answer could not be certified.
        """
        fell_back = self._answer.fell_back
        shape = self.applied.shape[:-2]
        return np.zeros(shape, dtype=np.bool_) if fell_back is None else fell_back

    @_once
    def internal(self) -> FloatArray:
        """h_I = h − h_M, of the shape of ``applied`` [N, N·m]."""
        return self.applied - self.manipulation

    @_once
    def object_wrench(self) -> FloatArray:
        """h_o = G h, ``(..., 3)`` or ``(..., 6)`` [N, N·m] (eq. 1)."""
        return sum_at_centre(self.applied, self.grips)

    @_once
    def _levels(self) -> FloatArray:
        """All that `level_kernel` writes, ``(NUM_LEVELS, ...)`` with the batch axes reversed."""
        decomposer = self._decomposer
        parameters = decomposer.level_parameters
        return level_kernel(self.applied, self.manipulation, decomposer.grips, parameters).T

    @property
    def level_parameters(self) -> FloatArray:
        """What `level_kernel` is told of the cost."""
        return self._decomposer.level_parameters

    def take_levels(self, levels: FloatArray) -> None:
        """Have ``(..., NUM_LEVELS)``, to the bits of `level_kernel`, computed elsewhere."""
        self.__dict__["_levels"] = levels.T

    @property
    def cost(self) -> FloatArray:
        """J(h_M), ``(...)`` [N, torques per metre] (eq. 17)."""
        return self._levels[COST].T

    @property
    def applied_cost(self) -> FloatArray:
        """J(h), ``(...)`` [N, torques per metre] (eq. 17)."""
        return self._levels[APPLIED_COST].T

    @property
    def wasted_cost(self) -> FloatArray:
        """Part of the applied wrench's cost that was compensated, J(h) − J(h_M) (eqs. 17, 29).

        ``(...)`` [N, torques per metre]. Unique and continuous in the wrench, as the relative cost
        is, but with a scale: next to nothing for idle hands, whose noise cancels as any fight does.
        Never negative for plausible methods.
        """
        return self._levels[WASTED_COST].T

    @property
    def relative_cost(self) -> FloatArray:
        """Fraction of the applied wrench's cost that was compensated, γ = 1 − J(h_M)/J(h) (eq. 29).

        ``(...)`` in [0, 1] for plausible methods, 0 where no wrench was applied; others may leave
        the interval.
        """
        return self._levels[RELATIVE_COST].T

    @property
    def internal_force_level(self) -> FloatArray:
        """F_I = ½ Σ‖f_I,i‖, ``(...)`` [N] (eq. 28).

        As the optimum need not be unique, it can jump where costs tie; γ cannot.
        """
        return self._levels[FORCE_LEVEL].T

    @property
    def internal_torque_level(self) -> FloatArray:
        """T_I = ½ Σ‖r_i × f_I,i + t_I,i‖, ``(...)`` [N·m] (eq. 28).

        As the optimum need not be unique, it can jump where costs tie; γ cannot.
        """
        return self._levels[TORQUE_LEVEL].T

    @_once
    def load_share(self) -> LoadShare:
        """Each effector's share of the resultant; see `coopenv.wrench.load_share`."""
        return shares.share_of_load(self.applied, self._decomposer.grips)

    @_once
    def share_or_even(self) -> ShareOrEven:
        """Load shares with 1/n in place of NaN, and whether they are defined."""
        return shares.share_or_even(self.applied, self._decomposer.grips)

    def energy_share(self, twist: npt.ArrayLike) -> EnergyShare:
        """Each effector's share of the object's power; see `coopenv.wrench.energy_share`."""
        twist = shares.checked_twist(twist, self.applied, self.grips)
        return shares.share_of_energy(self.applied, self.grips, twist)

    def residuals(self) -> Residuals:
        """By how much the manipulation wrench breaks balance (18) and the balls (19)-(21)."""
        return residuals_of(self.applied, self.manipulation, self.grips)
