"""Plausibility: by how much a split breaks balance, the balls of eqs. 9-11, bounds of power."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, finite_array, positive
from coopenv.errors import InvalidInput
from coopenv.wrench.grasp import checked_applied, checked_grips, moment, sum_at_centre
from coopenv.wrench.shares import checked_twist


class Residuals(NamedTuple):
    """By how much a decomposition breaks its constraints, per sample ``(...)``; 0 is perfect."""

    balance: FloatArray  # largest component of |G h_M − G h| [N or N·m]
    force: FloatArray  # largest excess of a force over its ball (19) [N]
    induced_torque: FloatArray  # of an induced torque (20) [N·m]
    torque: FloatArray  # of a pure torque (21) [N·m]


class WorkResiduals(NamedTuple):
    """By how much a split breaks the work constraints, per sample ``(...)``; 0 is perfect."""

    linear: FloatArray  # largest excess of an effector's linear power (35) [W]
    angular: FloatArray  # of its angular power (36) [W]


def residuals(applied: npt.ArrayLike, internal: npt.ArrayLike, grips: npt.ArrayLike) -> Residuals:
    """By how much a split of one's own breaks balance (6) and plausibility (9)-(11).

    For an internal wrench from a paper's figure or from another method; what `decompose` returns
    has its own ``residuals()``.

    Parameters
    ----------
    applied
        ``(..., n, 3)`` planar or ``(..., n, 6)`` spatial [N, N·m].
    internal
        h_I, of the shape of ``applied`` or broadcast against it [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].

    Returns
    -------
    The largest over the effectors, per sample ``(...)``: ``.balance`` |G h_I| [N or N·m], and
    ``.force`` [N], ``.induced_torque``, ``.torque`` [N·m], the distance from the ball whose
    diameter goes from 0 to what was applied: max(0, ‖x_I − x/2‖ − ‖x‖/2).

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.

    Source: Donner, Endo & Buss 2018, eqs. 6, 9-11. A ball holds x_I where it holds x − x_I.
    """
    applied, internal, grips = checked_split(applied, internal, grips)
    return residuals_of(applied, applied - internal, grips)


def is_plausible(
    applied: npt.ArrayLike,
    internal: npt.ArrayLike,
    grips: npt.ArrayLike,
    *,
    tolerance: float = 1e-9,
) -> BoolArray:
    """Whether a split balances (6) and claims of nobody what he did not apply (9)-(11).

    Parameters
    ----------
    applied, internal, grips
        As of `residuals`.
    tolerance
        Of each residual, relative to the largest force or torque of the sample; torques that forces
        induce count as torques. Take some 1e-3 for numbers read off a figure.

    Returns
    -------
    ``(...)`` bool. `residuals` says what is broken where it is not.

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.
    """
    tolerance = positive(tolerance, "tolerance", or_zero=True, at_most=1.0)
    applied, internal, grips = checked_split(applied, internal, grips)
    size = np.maximum(np.abs(applied), np.abs(internal)).max(axis=(-2, -1), keepdims=True)
    size = np.where(size > 0.0, size, 1.0)
    applied, internal = applied / size, internal / size  # squares of any size are numbers then
    dimension = grips.shape[-1]
    left = residuals_of(applied, applied - internal, grips)
    force = _largest(applied[..., :dimension])
    torque = np.maximum(_largest(applied[..., dimension:]), _largest(moment(grips, applied)))
    missing = np.abs(sum_at_centre(internal, grips))
    return (
        (missing[..., :dimension].max(axis=-1) <= tolerance * force)
        & (missing[..., dimension:].max(axis=-1) <= tolerance * torque)
        & (left.force <= tolerance * force)
        & (left.induced_torque <= tolerance * torque)
        & (left.torque <= tolerance * torque)
    )


def work_residuals(
    applied: npt.ArrayLike, internal: npt.ArrayLike, grips: npt.ArrayLike, twist: npt.ArrayLike
) -> WorkResiduals:
    """By how much a split claims power of an effector that it did not give.

    The power of an effector's manipulation wrench lies between 0 and that of what it applied:
    Ė_M² ≤ Ė Ė_M, for Ė_lin,i = f_iᵀ ṗ_o (35) and Ė_rot,i = t_o,iᵀ ω_o (36). Splits that keep the
    balls (9)-(11) may break it, so energy shares are taken of what was applied.

    Parameters
    ----------
    applied, internal, grips
        As of `residuals`.
    twist
        ``(..., 3)`` [vx, vy, ω] or ``(..., 6)`` [v, ω] of the centre of mass, in the frame of the
        wrench [m/s, rad/s].

    Returns
    -------
    ``.linear`` and ``.angular`` ``(...)`` [W]: the largest over the effectors of
    max(0, |Ė_M − Ė/2| − |Ė|/2).

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.

    Source: Donner, Endo & Buss 2018, Appendix A.
    """
    applied, internal, grips = checked_split(applied, internal, grips)
    twist = checked_twist(twist, applied, grips)[..., None, :]
    dimension = grips.shape[-1]

    def power(wrench: FloatArray) -> tuple[FloatArray, FloatArray]:
        torque = moment(grips, wrench) + wrench[..., dimension:]
        linear = (wrench[..., :dimension] * twist[..., :dimension]).sum(axis=-1)
        return linear[..., None], (torque * twist[..., dimension:]).sum(axis=-1)[..., None]

    pairs = zip(power(applied - internal), power(applied), strict=True)
    return WorkResiduals(*(_ball_excess(part, whole) for part, whole in pairs))


def checked_split(
    applied: npt.ArrayLike, internal: npt.ArrayLike, grips: npt.ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Convert to float64, broadcast the wrenches, raise `InvalidInput` unless they go together."""
    grips = checked_grips(grips)
    applied = checked_applied(applied, grips)
    internal = finite_array(internal, "internal")
    try:
        if internal.shape[-2:] != applied.shape[-2:]:
            raise ValueError
        batch = np.broadcast_shapes(internal.shape[:-2], applied.shape[:-2], grips.shape[:-2])
    except ValueError as error:
        raise InvalidInput(
            f"internal must be of the shape of applied {applied.shape} or broadcast against it, "
            f"got {internal.shape}; give h_I of every effector in the same frame"
        ) from error
    shape = (*batch, *applied.shape[-2:])
    return np.broadcast_to(applied, shape), np.broadcast_to(internal, shape), grips


def residuals_of(applied: FloatArray, manipulation: FloatArray, grips: FloatArray) -> Residuals:
    """Return by how much a manipulation wrench breaks balance (18) and the balls (19)-(21).

    The ball form is max(0, ‖x_M − x/2‖ − ‖x‖/2), the largest over the effectors. Methods that are
    not plausible have large ones; the virtual linkage need not even balance.
    """
    dimension = grips.shape[-1]
    balance = sum_at_centre(manipulation, grips) - sum_at_centre(applied, grips)
    parts = [
        _ball_excess(part(manipulation), part(applied))
        for part in (
            lambda wrench: wrench[..., :dimension],
            lambda wrench: moment(grips, wrench),
            lambda wrench: wrench[..., dimension:],
        )
    ]
    return Residuals(np.abs(balance).max(axis=-1), *parts)


def _ball_excess(manipulation: FloatArray, applied: FloatArray) -> FloatArray:
    distance = np.linalg.norm(manipulation - 0.5 * applied, axis=-1)
    excess = distance - 0.5 * np.linalg.norm(applied, axis=-1)
    return np.maximum(excess, 0.0).max(axis=-1)


def _largest(vectors: FloatArray) -> FloatArray:
    return np.linalg.norm(vectors, axis=-1).max(axis=-1)
