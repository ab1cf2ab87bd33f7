"""Measures of a wrench and of its decomposition: costs, disagreement, load and energy shares."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.errors import InvalidInput
from coopenv.wrench.grasp import checked_applied, checked_grips, wrench_size
from coopenv.wrench.measure_kernels import energy_share_kernel, load_share_kernel


class LoadShare(NamedTuple):
    """Part of the resultant that each effector supplies; each sums to 1, NaN where undefined."""

    force: FloatArray  # (..., n) dimensionless
    torque: FloatArray  # (..., n) dimensionless


class EnergyShare(NamedTuple):
    """Part of the object's power that each effector supplies; NaN where undefined."""

    total: FloatArray  # (..., n) dimensionless
    linear: FloatArray  # (..., n) dimensionless
    angular: FloatArray  # (..., n) dimensionless
    internal_power: FloatArray  # (...) [W], passed from effector to effector


def load_share(applied: npt.ArrayLike, grips: npt.ArrayLike) -> LoadShare:
    """Part of the resultant force and torque that each effector supplies.

    α_f,i = θ max(f_iᵀf_o / ‖f_o‖², 0)    (eq. 25, θ of eq. 23), α_t,i alike with t_o,i and t_o

    Parameters
    ----------
    applied
        ``(..., n, 3)`` planar or ``(..., n, 6)`` spatial [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].

    Returns
    -------
    ``.force`` and ``.torque``, ``(..., n)``; NaN where ‖f_o‖ ≤ 1e-9 Σ‖f_i‖ (torque alike).

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.

    Source: Donner, Endo & Buss 2018, eq. 25. Deviation: the undefined case.
    """
    grips = checked_grips(grips)
    return share_of_load(checked_applied(applied, grips), grips)


def share_of_load(applied: FloatArray, grips: FloatArray) -> LoadShare:
    """Return `load_share` of arrays that were checked before."""
    return LoadShare(*load_share_kernel(applied, grips))


def energy_share(applied: npt.ArrayLike, grips: npt.ArrayLike, twist: npt.ArrayLike) -> EnergyShare:
    """Part of the object's power that each effector supplies.

    β_i = θ max(Ė_i / Ė_o, 0),  Ė_lin,i = f_iᵀ ṗ_o,  Ė_rot,i = t_o,iᵀ ω_o    (eqs. 26-27)

    Parameters
    ----------
    applied
        ``(..., n, 3)`` planar or ``(..., n, 6)`` spatial [N, N·m]. Use what was applied, not the
        manipulation wrench (the paper's Appendix A says why).
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].
    twist
        ``(..., 3)`` [vx, vy, ω] or ``(..., 6)`` [v, ω] of the centre of mass, in the frame of the
        wrench [m/s, rad/s].

    Returns
    -------
    ``.total``, ``.linear``, ``.angular`` ``(..., n)``, NaN where the power is at most 1e-9 of the
    sum of its parts' magnitudes; ``.internal_power`` ``(...)`` [W], ½(Σ|Ė_i| − |ΣĖ_i|).

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.

    Source: Donner, Endo & Buss 2018, eqs. 26-27. Deviation: the undefined case.
    """
    grips = checked_grips(grips)
    applied = checked_applied(applied, grips)
    return share_of_energy(applied, grips, checked_twist(twist, applied, grips))


def share_of_energy(applied: FloatArray, grips: FloatArray, twist: FloatArray) -> EnergyShare:
    """Return `energy_share` of arrays that were checked before."""
    return EnergyShare(*energy_share_kernel(applied, grips, twist))


def checked_twist(twist: npt.ArrayLike, applied: FloatArray, grips: FloatArray) -> FloatArray:
    """Convert to float64 and raise `InvalidInput` unless it is one twist per sample."""
    twist = finite_array(twist, "twist")
    size = wrench_size(grips.shape[-1])
    rule = f"(..., {size}) and broadcast against applied {applied.shape[:-2]}"
    try:
        if twist.shape[-1:] != (size,):
            raise ValueError
        np.broadcast_shapes(twist.shape[:-1], applied.shape[:-2])
    except ValueError as error:
        raise InvalidInput(
            f"twist must be of shape {rule}, got {twist.shape}; "
            "give the velocity of the centre of mass [m/s, rad/s] in the frame of the wrench"
        ) from error
    return twist


def level_parameters(torque_weight: float, include_induced: bool, plausible: bool) -> FloatArray:
    """Return the weights as `level_kernel` takes them, padded to the length of its output."""
    return np.array([torque_weight, float(include_induced), float(plausible), 0.0, 0.0])
