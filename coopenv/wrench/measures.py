"""Measures of wrenches and decompositions: cost, internal levels, load shares, energy shares.

The compiled kernels stand below what calls them; helpers come before the kernels that use them.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, finite_array
from coopenv.compiled import TINY, compiled, gufunc, inlined
from coopenv.errors import InvalidInput
from coopenv.wrench.grasp import checked_applied, checked_grips, wrench_size

# Columns of what `level_kernel` writes
COST, APPLIED_COST, RELATIVE_COST = 0, 1, 2  # J(h_M), J(h) [N], γ
FORCE_LEVEL, TORQUE_LEVEL = 3, 4  # F_I [N], T_I [N·m]
WASTED_COST = 5  # J(h) − J(h_M) [N]
NUM_LEVELS = 6

# Places of what kernels are told of the cost
TORQUE_WEIGHT, INCLUDE_INDUCED = 0, 1  # w and s of eq. 17
PLAUSIBLE = 2  # 1 if relative and wasted cost are known not to be negative

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


def level_parameters(torque_weight: float, include_induced: bool, plausible: bool) -> FloatArray:
    """Return what `level_kernel` is told; a gufunc has the length of its output from an input."""
    parameters = np.zeros(NUM_LEVELS)
    parameters[TORQUE_WEIGHT] = torque_weight
    parameters[INCLUDE_INDUCED] = include_induced
    parameters[PLAUSIBLE] = plausible
    return parameters


def cost_weights(torque_weight: float, include_induced: float) -> FloatArray:
    """Return w and s as the kernels of solvers take them, at `TORQUE_WEIGHT`, `INCLUDE_INDUCED`."""
    weights = np.zeros(2)
    weights[TORQUE_WEIGHT], weights[INCLUDE_INDUCED] = torque_weight, include_induced
    return weights


@compiled
def _wrench(wrench, i):
    """Force and torque of effector i in three dimensions."""
    if wrench.shape[1] == 3:
        return wrench[i, 0], wrench[i, 1], 0.0, 0.0, 0.0, wrench[i, 2]
    return wrench[i, 0], wrench[i, 1], wrench[i, 2], wrench[i, 3], wrench[i, 4], wrench[i, 5]


@compiled
def _moment(grips, i, fx, fy, fz):
    """Torque about the centre of mass, r_i × f."""
    x, y = grips[i, 0], grips[i, 1]
    z = grips[i, 2] if grips.shape[1] == 3 else 0.0
    return y * fz - z * fy, z * fx - x * fz, x * fy - y * fx


@compiled
def _norm(x, y, z):
    return sqrt(x * x + y * y + z * z)


@inlined
def _cost(wrench, i, grips, w, induced):
    """Summand i of the cost (eq. 17)."""
    if wrench.shape[1] == 3:  # to the same bits, but where squares underflow
        fx, fy, tz = wrench[i, 0], wrench[i, 1], wrench[i, 2]
        cost = (1.0 - w) * sqrt(fx * fx + fy * fy) + w * abs(tz)
        if induced > 0.0:
            moment = grips[i, 0] * fy - grips[i, 1] * fx
            cost += w * abs(moment)
        return cost
    fx, fy, fz, tx, ty, tz = _wrench(wrench, i)
    cost = (1.0 - w) * _norm(fx, fy, fz) + w * _norm(tx, ty, tz)
    if induced > 0.0:
        mx, my, mz = _moment(grips, i, fx, fy, fz)
        cost += w * _norm(mx, my, mz)
    return cost


@inlined
def _internal(applied, manipulation, grips, i):
    """‖f_I,i‖ and ‖r_i × f_I,i + t_I,i‖ (eq. 28)."""
    if applied.shape[1] == 3:
        fx, fy = applied[i, 0] - manipulation[i, 0], applied[i, 1] - manipulation[i, 1]
        torque = grips[i, 0] * fy - grips[i, 1] * fx + applied[i, 2] - manipulation[i, 2]
        return sqrt(fx * fx + fy * fy), abs(torque)
    ax, ay, az, aa, ab, ac = _wrench(applied, i)
    mx, my, mz, ma, mb, mc = _wrench(manipulation, i)
    fx, fy, fz = ax - mx, ay - my, az - mz
    tx, ty, tz = _moment(grips, i, fx, fy, fz)
    return _norm(fx, fy, fz), _norm(tx + aa - ma, ty + ab - mb, tz + ac - mc)


@gufunc(
    "(n,k),(n,k),(n,d),(q)->(q)",
    "void(float64[:,:], float64[:,:], float64[:,:], float64[:], float64[:])",
)
def level_kernel(applied, manipulation, grips, parameters, result):
    """Write costs and internal levels (eqs. 17, 28, 29) to the columns from `COST` on.

    ``parameters`` are those of `level_parameters`.
    """
    w, induced = parameters[TORQUE_WEIGHT], parameters[INCLUDE_INDUCED]
    cost, applied_cost, force_level, torque_level = 0.0, 0.0, 0.0, 0.0
    for i in range(applied.shape[0]):
        applied_cost += _cost(applied, i, grips, w, induced)
        cost += _cost(manipulation, i, grips, w, induced)
        force, torque = _internal(applied, manipulation, grips, i)
        force_level += 0.5 * force
        torque_level += 0.5 * torque
    wasted = applied_cost - cost
    relative = wasted / max(applied_cost, TINY)
    plausible = parameters[PLAUSIBLE] > 0.0
    result[COST], result[APPLIED_COST] = cost, applied_cost
    result[RELATIVE_COST] = max(relative, 0.0) if plausible else relative
    result[FORCE_LEVEL], result[TORQUE_LEVEL] = force_level, torque_level
    result[WASTED_COST] = max(wasted, 0.0) if plausible else wasted


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
def _is_defined(share):
    return not np.isnan(share[0])


@compiled
def _at_centre(applied, grips, i):
    """Force, and torque at the centre of mass, of effector i (eq. 4)."""
    fx, fy, fz, tx, ty, tz = _wrench(applied, i)
    mx, my, mz = _moment(grips, i, fx, fy, fz)
    return fx, fy, fz, mx + tx, my + ty, mz + tz


@inlined
def _share(applied, grips, force_share, torque_share):
    """Write each effector's share of the resultant force and torque (eq. 25)."""
    if applied.shape[1] == 3:
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
        fx, fy, torque = applied[i, 0], applied[i, 1], _torque_in_plane(applied, grips, i)
        sfx, sfy, st = sfx + fx, sfy + fy, st + torque
        forces += sqrt(fx * fx + fy * fy)
        torques += abs(torque)
    size, turning = sqrt(sfx * sfx + sfy * sfy), abs(st)
    for i in range(applied.shape[0]):
        along_force[i] = (applied[i, 0] * sfx + applied[i, 1] * sfy) / max(size, TINY)
        along_torque[i] = _torque_in_plane(applied, grips, i) * st / max(turning, TINY)
    return size, forces, turning, torques


@inlined
def _torque_in_plane(applied, grips, i):
    """Torque at the centre of mass of effector i (eq. 4)."""
    return grips[i, 0] * applied[i, 1] - grips[i, 1] * applied[i, 0] + applied[i, 2]


@inlined
def _parts_in_space(applied, grips, along_force, along_torque):
    """Write what each effector gives along the resultants, f_iᵀf_o / ‖f_o‖ and torques alike.

    Returns ‖f_o‖, Σ‖f_i‖, and likewise of torques.
    """
    sfx, sfy, sfz, stx, sty, stz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    forces, torques = 0.0, 0.0
    for i in range(applied.shape[0]):
        fx, fy, fz, tx, ty, tz = _at_centre(applied, grips, i)
        sfx, sfy, sfz = sfx + fx, sfy + fy, sfz + fz
        stx, sty, stz = stx + tx, sty + ty, stz + tz
        forces += _norm(fx, fy, fz)
        torques += _norm(tx, ty, tz)
    force, torque = _norm(sfx, sfy, sfz), _norm(stx, sty, stz)
    for i in range(applied.shape[0]):
        fx, fy, fz, tx, ty, tz = _at_centre(applied, grips, i)
        along_force[i] = (fx * sfx + fy * sfy + fz * sfz) / max(force, TINY)
        along_torque[i] = (tx * stx + ty * sty + tz * stz) / max(torque, TINY)
    return force, forces, torque, torques


@gufunc(
    "(n,k),(n,d)->(n),(n)",
    "void(float64[:,:], float64[:,:], float64[:], float64[:])",
)
def load_share_kernel(applied, grips, force_share, torque_share):
    """Write load shares (eq. 25), NaN where they are undefined."""
    _share(applied, grips, force_share, torque_share)


@gufunc(
    "(n,k),(n,d)->(n),(),(n),()",
    "void(float64[:,:], float64[:,:], float64[:], boolean[:], float64[:], boolean[:])",
)
def share_or_even_kernel(applied, grips, force_share, force_defined, torque_share, torque_defined):
    """Write load shares (eq. 25), 1/n where they are undefined, and whether they are defined."""
    _share(applied, grips, force_share, torque_share)
    force_defined[0], torque_defined[0] = _is_defined(force_share), _is_defined(torque_share)
    even = 1 / force_share.shape[0]
    for i in range(force_share.shape[0]):
        force_share[i] = force_share[i] if force_defined[0] else even
        torque_share[i] = torque_share[i] if torque_defined[0] else even


@inlined
def power_of(applied, grips, i, twist):
    """Power of effector i's force, and of its torque at the centre of mass (eqs. 26-27)."""
    if applied.shape[1] == 3:  # without the zeros of the third dimension
        linear = applied[i, 0] * twist[0] + applied[i, 1] * twist[1]
        return linear, _torque_in_plane(applied, grips, i) * twist[2]
    fx, fy, fz, tx, ty, tz = _at_centre(applied, grips, i)
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
        linear[i], angular[i] = power_of(applied, grips, i, twist)
        total[i] = linear[i] + angular[i]
    share_power(linear)
    share_power(angular)
    internal_power[0] = share_power(total)
