"""Nearly coincident grips: sensitivity of the optimum to rounding, and a gap that contains it.

Where two grips meet, and where their line passes the centre of mass, the optimum jumps. Next to
such a place it depends on a tiny lever ℓ, with which internal forces g make a torque ℓ·g that pure
torques or other levers must balance. The multiplier of that balance is as large as 1/ℓ, so that
missing it by ε may be worth ε/ℓ of force. Iterative solvers miss it by rounding and find the
multiplier of the cheaper place on the other side of the jump, where their bound holds.
"""

from functools import partial
from math import sqrt

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import compiled
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.grasp import sum_at_centre
from coopenv.wrench.measures import COST, WASTED_COST, level_kernel, level_parameters
from coopenv.wrench.pair.on_axis import COINCIDENT, ON_AXIS
from coopenv.wrench.plausibility import residuals_of
from coopenv.wrench.settings import Settings

NEAR = 1e-6  # of the longest lever: a tiny lever from which on rounding is worth less than 1e-8
ROUNDING = 4e-16  # of a sum of torques, relative to the largest torque in it
GROWTH = 100.0  # 2 as two forces change; more than 20 in one of 10,000, in thin feasible sets


def nearly_coincide(grips: FloatArray) -> BoolArray:
    """Whether ``(...)`` rounding may decide on the optimum at grips ``(..., n, d)``."""
    return np.isfinite(least_lever(grips))


def with_rounding_counted(solve: Solve, grips: FloatArray, settings: Settings) -> Solve:
    """Return a solver whose gap contains what its residuals may be worth at these grips.

    That is the very same solver, unless some grips nearly coincide.

    Parameters
    ----------
    solve
        A solver for these grips and settings.
    grips
        ``(..., n, d)`` [m].
    settings
        Torque weight and whether induced torque is costed.
    """
    lever = least_lever(grips)
    if not np.isfinite(lever).any():
        return solve
    return partial(_solve, solve, lever, grips, settings)


def _solve(
    solve: Solve, lever: FloatArray, grips: FloatArray, settings: Settings, applied: FloatArray
) -> Answer:
    """Answer of ``solve``, its gap widened where grips nearly coincide.

    The optimum costs no more than the applied wrench, so that an answer is too cheap by no more
    than it saves. A gap of the whole cost says that nothing more is known.
    """
    answer = solve(applied)
    assert answer.gap is not None
    parameters = level_parameters(settings.torque_weight, settings.include_induced, plausible=True)
    levels = level_kernel(applied, answer.manipulation, grips, parameters)
    cost, saved = levels[..., COST], levels[..., WASTED_COST]
    w, longest = settings.torque_weight, _norm(grips).max(axis=-1)
    price = (1.0 - w) + settings.include_induced * w * longest
    worth = GROWTH * price * _missed(applied, answer.manipulation, grips) / lever
    below = np.minimum(answer.gap + worth, saved)
    return answer._replace(gap=np.maximum(answer.gap, np.minimum(below, cost)))


def least_lever(grips: FloatArray) -> FloatArray:
    """Least lever ``(...)`` that decides between places where the optimum jumps [m].

    Infinite if it is not tiny. Of two grips off a line through the centre of mass it is their
    distance times that of the line from the centre of mass, relative to the longest lever. Of two
    on such a line it is their distance. Grips that count as one have none.
    """
    lever = np.empty(grips.shape[:-2])
    rows = np.array(grips, order="C").reshape(lever.size, *grips.shape[-2:])
    _write_levers(rows, lever.reshape(-1))
    return lever


def _missed(applied: FloatArray, manipulation: FloatArray, grips: FloatArray) -> FloatArray:
    """By how much an answer breaks its constraints in all, as torque ``(...)`` [N·m].

    It is no less than rounding. Every effector is taken to leave its balls as far as the worst.
    """
    num_effectors, dimension = grips.shape[-2:]
    longest = _norm(grips).max(axis=-1)
    sums = np.abs(sum_at_centre(applied - manipulation, grips))
    balance = longest * sums[..., :dimension].sum(axis=-1) + sums[..., dimension:].sum(axis=-1)
    _, force, induced, torque = residuals_of(applied, manipulation, grips)
    missed = balance + num_effectors * (longest * force + induced + torque)
    push = _norm(applied[..., :dimension]).max(axis=-1)
    turn = _norm(applied[..., dimension:]).max(axis=-1)
    return np.maximum(missed, ROUNDING * np.maximum(longest * push, turn))


def _norm(vectors: FloatArray) -> FloatArray:
    return np.sqrt((vectors * vectors).sum(axis=-1))


@compiled
def _length(grips, i, j):
    """Distance of grip i from grip j, or from the centre of mass for j = −1."""
    square = 0.0
    for r in range(grips.shape[1]):
        step = grips[i, r] - grips[j, r] if j >= 0 else grips[i, r]
        square += step * step
    return sqrt(square)


@compiled
def _area(grips, i, j):
    """Size of r_i × r_j, from the grips' difference to be accurate where they are close."""
    square = 0.0
    for r in range(grips.shape[1]):
        for t in range(r):
            first = grips[i, r] * (grips[j, t] - grips[i, t])
            part = first - grips[i, t] * (grips[j, r] - grips[i, r])
            square += part * part
    return sqrt(square)


@compiled
def _write_levers(grips, levers):
    """Write the least lever of every set of grips."""
    for k in range(len(grips)):
        levers[k] = _least(grips[k])


@compiled
def _least(grips):
    """`least_lever` of one set."""
    longest, least = 0.0, np.inf
    for i in range(grips.shape[0]):
        longest = max(longest, _length(grips, i, -1))
    for i in range(grips.shape[0]):
        for j in range(i):
            apart = _length(grips, i, j)
            if apart <= COINCIDENT * longest:
                continue
            area = _area(grips, i, j)
            on_axis = area <= ON_AXIS * longest * min(apart, longest)
            least = min(least, apart if on_axis else area / longest)
    return least if least < NEAR * longest else np.inf
