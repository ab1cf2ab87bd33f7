"""The compiled part of `measures`: helpers first, as compilation needs them.

No kernel allocates: numba's allocator is not set up when a gufunc comes from the cache.
"""

from math import sqrt

import numpy as np

from coopenv.compiled import compiled, gufunc

UNDEFINED = 1e-9  # a resultant smaller than this fraction of its summands has no shares
TINY = 1e-300  # keeps divisions finite where the numerator is zero as well


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


@compiled
def _cost(wrench, i, grips, w, induced):
    """Summand i of the cost (eq. 17)."""
    fx, fy, fz, tx, ty, tz = _wrench(wrench, i)
    cost = (1.0 - w) * _norm(fx, fy, fz) + w * _norm(tx, ty, tz)
    if induced > 0.0:
        mx, my, mz = _moment(grips, i, fx, fy, fz)
        cost += w * _norm(mx, my, mz)
    return cost


@gufunc(
    "(n,k),(n,k),(n,d),(q)->(q)",
    "void(float64[:,:], float64[:,:], float64[:,:], float64[:], float64[:])",
)
def level_kernel(applied, manipulation, grips, parameters, result):
    """Write cost, applied cost, relative cost, internal force level and internal torque level.

    ``parameters`` starts with the torque weight, 1 if induced torque has a cost, and 1 if the
    relative cost is known not to be negative.
    """
    w, induced = parameters[0], parameters[1]
    cost, applied_cost, force_level, torque_level = 0.0, 0.0, 0.0, 0.0
    for i in range(applied.shape[0]):
        applied_cost += _cost(applied, i, grips, w, induced)
        cost += _cost(manipulation, i, grips, w, induced)
        ax, ay, az, aa, ab, ac = _wrench(applied, i)
        mx, my, mz, ma, mb, mc = _wrench(manipulation, i)
        fx, fy, fz = ax - mx, ay - my, az - mz
        tx, ty, tz = _moment(grips, i, fx, fy, fz)
        force_level += 0.5 * _norm(fx, fy, fz)
        torque_level += 0.5 * _norm(tx + aa - ma, ty + ab - mb, tz + ac - mc)
    relative = (applied_cost - cost) / max(applied_cost, TINY)
    result[0], result[1] = cost, applied_cost
    result[2] = max(relative, 0.0) if parameters[2] > 0.0 else relative
    result[3], result[4] = force_level, torque_level


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


@compiled
def _at_centre(applied, grips, i):
    """Force, and torque at the centre of mass, of effector i (eq. 4)."""
    fx, fy, fz, tx, ty, tz = _wrench(applied, i)
    mx, my, mz = _moment(grips, i, fx, fy, fz)
    return fx, fy, fz, mx + tx, my + ty, mz + tz


@gufunc(
    "(n,k),(n,d)->(n),(n)",
    "void(float64[:,:], float64[:,:], float64[:], float64[:])",
)
def load_share_kernel(applied, grips, force_share, torque_share):
    """Write each effector's share of the resultant force and torque (eq. 25)."""
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
        force_share[i] = (fx * sfx + fy * sfy + fz * sfz) / max(force, TINY)
        torque_share[i] = (tx * stx + ty * sty + tz * stz) / max(torque, TINY)
    _normalise(force_share, force, forces)
    _normalise(torque_share, torque, torques)


@gufunc(
    "(n,k),(n,d),(k)->(n),(n),(n),()",
    "void(float64[:,:], float64[:,:], float64[:], float64[:], float64[:], float64[:], float64[:])",
)
def energy_share_kernel(applied, grips, twist, total, linear, angular, internal_power):
    """Write each effector's share of the power and what passes between them (eqs. 26-27)."""
    spatial = applied.shape[1] == 6
    for i in range(applied.shape[0]):
        fx, fy, fz, tx, ty, tz = _at_centre(applied, grips, i)
        linear[i] = fx * twist[0] + fy * twist[1] + (fz * twist[2] if spatial else 0.0)
        angular[i] = tz * twist[2]
        if spatial:
            angular[i] = tx * twist[3] + ty * twist[4] + tz * twist[5]
        total[i] = linear[i] + angular[i]
    for power in (linear, angular, total):  # total last: what passes between them is its
        net, magnitude = 0.0, 0.0
        for i in range(applied.shape[0]):
            net += power[i]
            magnitude += abs(power[i])
        internal_power[0] = 0.5 * (magnitude - abs(net))
        for i in range(applied.shape[0]):
            power[i] = -power[i] if net < 0.0 else power[i]
        _normalise(power, abs(net), magnitude)
