"""Measures of decompositions: cost, relative and wasted cost, internal levels."""

from math import sqrt

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, finite_array
from coopenv.compiled import TINY, gufunc, inlined
from coopenv.wrench.components import components, moment, norm
from coopenv.wrench.grasp import checked_grips, require_wrench_per_grip
from coopenv.wrench.settings import Settings

# Columns of what `level_kernel` writes
COST, APPLIED_COST, RELATIVE_COST = 0, 1, 2  # J(h_M), J(h) [N], γ
FORCE_LEVEL, TORQUE_LEVEL = 3, 4  # F_I [N], T_I [N·m]
WASTED_COST = 5  # J(h) − J(h_M) [N]
NUM_LEVELS = 6

# Places of what kernels are told of the cost
TORQUE_WEIGHT, INCLUDE_INDUCED = 0, 1  # w and s of eq. 17
PLAUSIBLE = 2  # 1 if relative and wasted cost are known not to be negative


def cost(
    wrench: npt.ArrayLike,
    grips: npt.ArrayLike,
    *,
    torque_weight: float = 0.5,
    include_induced: bool = False,
) -> FloatArray:
    """Cost of any wrench, be it applied, manipulation or one of one's own.

    J(h) = Σ_i (1−w) ‖f_i‖ + w ‖t_i‖ + s w ‖r_i × f_i‖    (eq. 17)

    Parameters
    ----------
    wrench
        ``(..., n, 3)`` planar or ``(..., n, 6)`` spatial [N, N·m].
    grips
        ``(..., n, 2)`` or ``(..., n, 3)``, broadcast against it [m].
    torque_weight, include_induced
        w in ]0, 1[ and s, as in `Settings`.

    Returns
    -------
    ``(...)`` [N, torques per metre].

    Raises
    ------
    InvalidInput
        If a shape or a number is wrong.
    """
    settings = Settings(torque_weight=torque_weight, include_induced=include_induced)
    grips, given = checked_grips(grips), finite_array(wrench, "wrench")
    require_wrench_per_grip(given, grips, name="wrench")
    weights = level_parameters(settings.torque_weight, settings.include_induced, False)
    return level_kernel(given, given, grips, weights)[..., COST]


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


@inlined
def _cost(wrench, i, grips, w, induced, spatial):
    """Summand i of the cost (eq. 17)."""
    if spatial is None or wrench.shape[1] == 3:  # to the same bits, but where squares underflow
        fx, fy, tz = wrench[i, 0], wrench[i, 1], wrench[i, 2]
        cost = (1.0 - w) * sqrt(fx * fx + fy * fy) + w * abs(tz)
        if induced > 0.0:
            cost += w * abs(grips[i, 0] * fy - grips[i, 1] * fx)
        return cost
    fx, fy, fz, tx, ty, tz = components(wrench, i)
    cost = (1.0 - w) * norm(fx, fy, fz) + w * norm(tx, ty, tz)
    if induced > 0.0:
        mx, my, mz = moment(grips, i, fx, fy, fz)
        cost += w * norm(mx, my, mz)
    return cost


@inlined
def _internal(applied, manipulation, grips, i, spatial):
    """‖f_I,i‖ and ‖r_i × f_I,i + t_I,i‖ (eq. 28)."""
    if spatial is None or applied.shape[1] == 3:
        fx, fy = applied[i, 0] - manipulation[i, 0], applied[i, 1] - manipulation[i, 1]
        torque = grips[i, 0] * fy - grips[i, 1] * fx + applied[i, 2] - manipulation[i, 2]
        return sqrt(fx * fx + fy * fy), abs(torque)
    ax, ay, az, aa, ab, ac = components(applied, i)
    mx, my, mz, ma, mb, mc = components(manipulation, i)
    fx, fy, fz = ax - mx, ay - my, az - mz
    tx, ty, tz = moment(grips, i, fx, fy, fz)
    return norm(fx, fy, fz), norm(tx + aa - ma, ty + ab - mb, tz + ac - mc)


@inlined
def write_levels(applied, manipulation, grips, parameters, result, spatial):
    """See `level_kernel`; ``spatial`` is None where all is planar, and only that is compiled."""
    w, induced = parameters[TORQUE_WEIGHT], parameters[INCLUDE_INDUCED]
    cost, applied_cost, force_level, torque_level = 0.0, 0.0, 0.0, 0.0
    for i in range(applied.shape[0]):
        applied_cost += _cost(applied, i, grips, w, induced, spatial)
        cost += _cost(manipulation, i, grips, w, induced, spatial)
        force, torque = _internal(applied, manipulation, grips, i, spatial)
        force_level += 0.5 * force
        torque_level += 0.5 * torque
    wasted = applied_cost - cost
    relative = wasted / max(applied_cost, TINY)
    plausible = parameters[PLAUSIBLE] > 0.0
    result[COST], result[APPLIED_COST] = cost, applied_cost
    result[RELATIVE_COST] = max(relative, 0.0) if plausible else relative
    result[FORCE_LEVEL], result[TORQUE_LEVEL] = force_level, torque_level
    result[WASTED_COST] = max(wasted, 0.0) if plausible else wasted


@gufunc(
    "(n,k),(n,k),(n,d),(q)->(q)",
    "void(float64[:,:], float64[:,:], float64[:,:], float64[:], float64[:])",
)
def level_kernel(applied, manipulation, grips, parameters, result):
    """Write costs and internal levels (eqs. 17, 28, 29) to the columns from `COST` on.

    ``parameters`` are those of `level_parameters`.
    """
    write_levels(applied, manipulation, grips, parameters, result, True)
