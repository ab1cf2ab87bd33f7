"""Shares: the part of the resultant, and of the power, that each effector supplies.

The compiled kernels stand below what calls them; helpers come before the kernels that use them.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, finite_array
from coopenv.compiled import TINY, compiled, gufunc, inlined
from coopenv.errors import InvalidInput
from coopenv.wrench.components import at_centre, norm, torque_in_plane
from coopenv.wrench.grasp import checked_applied, checked_grips, wrench_size

UNDEFINED = 1e-9  # a resultant smaller than this fraction of its summands has no shares


class LoadShare(NamedTuple):
    """Part of the resultant that each effector supplies; each sums to 1, NaN where undefined."""

    force: FloatArray  # (..., n) dimensionless
    torque: FloatArray  # (..., n) dimensionless


class ShareOrEven(NamedTuple):
    """Load shares that are 1/n where they are undefined, and whether they are defined."""

    force: FloatArray  # (..., n) dimensionless
    force_defined: BoolArray  # (...)
    torque: FloatArray  # (..., n) dimensionless
    torque_defined: BoolArray  # (...)


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


def share_or_even(applied: FloatArray, grips: FloatArray) -> ShareOrEven:
    """Return shares without NaN of arrays that were checked before."""
    return ShareOrEven(*share_or_even_kernel(applied, grips))


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


@compiled
def _normalise(parts, resultant, magnitude):
    """Turn parts into shares (eqs. 22-23); NaN where the resultant vanishes."""
    positive = 0.0
    for i in range(parts.shape[0]):
        positive += max(parts[i], 0.0)
    for i in range(parts.shape[0]):
        parts[i] = max(parts[i], 0.0) / max(positive, TINY)
        if resultant <= UNDEFINED * magnitude:
            parts[i] = np.nan


@inlined
def is_defined(share):
    """Whether shares are numbers."""
    return not np.isnan(share[0])


@inlined
def _share(applied, grips, force_share, torque_share, spatial):
    """Write each effector's share of the resultant force and torque (eq. 25).

    ``spatial`` is None where all is planar, and only that is compiled; here and below.
    """
    if spatial is None or applied.shape[1] == 3:
        force, forces, torque, torques = _parts_in_plane(applied, grips, force_share, torque_share)
    else:
        force, forces, torque, torques = _parts_in_space(applied, grips, force_share, torque_share)
    _normalise(force_share, force, forces)
    _normalise(torque_share, torque, torques)


@inlined
def _parts_in_plane(applied, grips, along_force, along_torque):
    """`_parts_in_space` without the zeros, to the same bits but where squares underflow."""
    sfx, sfy, st, forces, torques = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(applied.shape[0]):
        fx, fy, torque = applied[i, 0], applied[i, 1], torque_in_plane(applied, grips, i)
        sfx, sfy, st = sfx + fx, sfy + fy, st + torque
        forces += sqrt(fx * fx + fy * fy)
        torques += abs(torque)
    size, turning = sqrt(sfx * sfx + sfy * sfy), abs(st)
    for i in range(applied.shape[0]):
        along_force[i] = (applied[i, 0] * sfx + applied[i, 1] * sfy) / max(size, TINY)
        along_torque[i] = torque_in_plane(applied, grips, i) * st / max(turning, TINY)
    return size, forces, turning, torques


@inlined
def _parts_in_space(applied, grips, along_force, along_torque):
    """Write what each effector gives along the resultants, f_iᵀf_o / ‖f_o‖ and torques alike.

    Returns ‖f_o‖, Σ‖f_i‖, and likewise of torques.
    """
    sfx, sfy, sfz, stx, sty, stz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    forces, torques = 0.0, 0.0
    for i in range(applied.shape[0]):
        fx, fy, fz, tx, ty, tz = at_centre(applied, grips, i)
        sfx, sfy, sfz = sfx + fx, sfy + fy, sfz + fz
        stx, sty, stz = stx + tx, sty + ty, stz + tz
        forces += norm(fx, fy, fz)
        torques += norm(tx, ty, tz)
    force, torque = norm(sfx, sfy, sfz), norm(stx, sty, stz)
    for i in range(applied.shape[0]):
        fx, fy, fz, tx, ty, tz = at_centre(applied, grips, i)
        along_force[i] = (fx * sfx + fy * sfy + fz * sfz) / max(force, TINY)
        along_torque[i] = (tx * stx + ty * sty + tz * stz) / max(torque, TINY)
    return force, forces, torque, torques


@gufunc(
    "(n,k),(n,d)->(n),(n)",
    "void(float64[:,:], float64[:,:], float64[:], float64[:])",
)
def load_share_kernel(applied, grips, force_share, torque_share):
    """Write load shares (eq. 25), NaN where they are undefined."""
    _share(applied, grips, force_share, torque_share, True)


@inlined
def write_share_or_even(applied, grips, force_share, torque_share, spatial):
    """Write load shares, 1/n where they are undefined; returns whether they are defined."""
    _share(applied, grips, force_share, torque_share, spatial)
    force_defined, torque_defined = is_defined(force_share), is_defined(torque_share)
    even = 1 / force_share.shape[0]
    for i in range(force_share.shape[0]):
        force_share[i] = force_share[i] if force_defined else even
        torque_share[i] = torque_share[i] if torque_defined else even
    return force_defined, torque_defined


@gufunc(
    "(n,k),(n,d)->(n),(),(n),()",
    "void(float64[:,:], float64[:,:], float64[:], boolean[:], float64[:], boolean[:])",
)
def share_or_even_kernel(applied, grips, force_share, force_defined, torque_share, torque_defined):
    """Write load shares (eq. 25), 1/n where they are undefined, and whether they are defined."""
    force_defined[0], torque_defined[0] = write_share_or_even(
        applied, grips, force_share, torque_share, True
    )


@inlined
def power_of(applied, grips, i, twist, spatial):
    """Power of effector i's force, and of its torque at the centre of mass (eqs. 26-27)."""
    if spatial is None or applied.shape[1] == 3:  # without the zeros of the third dimension
        linear = applied[i, 0] * twist[0] + applied[i, 1] * twist[1]
        return linear, torque_in_plane(applied, grips, i) * twist[2]
    fx, fy, fz, tx, ty, tz = at_centre(applied, grips, i)
    linear = fx * twist[0] + fy * twist[1] + fz * twist[2]
    return linear, tx * twist[3] + ty * twist[4] + tz * twist[5]


@inlined
def share_power(power):
    """Turn powers into shares, NaN where undefined; returns what passes between effectors [W]."""
    net, magnitude = 0.0, 0.0
    for i in range(power.shape[0]):
        net += power[i]
        magnitude += abs(power[i])
    for i in range(power.shape[0]):
        power[i] = -power[i] if net < 0.0 else power[i]
    _normalise(power, abs(net), magnitude)
    return 0.5 * (magnitude - abs(net))


@gufunc(
    "(n,k),(n,d),(k)->(n),(n),(n),()",
    "void(float64[:,:], float64[:,:], float64[:], float64[:], float64[:], float64[:], float64[:])",
)
def energy_share_kernel(applied, grips, twist, total, linear, angular, internal_power):
    """Write each effector's share of the power and what passes between them (eqs. 26-27)."""
    for i in range(applied.shape[0]):
        linear[i], angular[i] = power_of(applied, grips, i, twist, True)
        total[i] = linear[i] + angular[i]
    share_power(linear)
    share_power(angular)
    internal_power[0] = share_power(total)
