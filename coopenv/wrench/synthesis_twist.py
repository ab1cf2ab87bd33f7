"""Wished-for shares of any number of effectors, with nothing internal: forces across f_o too.

A wrench h is its own manipulation wrench where the conditions of optimality hold at h_M = h: there
is a twist (a, ω), the multipliers of balance, such that with u_i = a + ω × r_i, e_i = r_i/‖r_i‖

    f_i = A_i (part of u_i along e_i) + B_i (part of u_i across e_i),  A_i ≥ B_i ≥ 0
    t_i = T_i ω,  T_i ≥ 0

(the multipliers of force ball, induced-torque disc and torque ball being what A, B and T say). The
costs w and s only bound the length of the twist from below, so that its direction is all that
matters. Resultant and shares are linear in A, B, T and linear in the twist. With B_i = b_i²,
A_i = (1 + margin) b_i² + c_i² and T_i = d_i², what is wanted is a system of polynomial equations
with more unknowns than equations. Levenberg and Marquardt's method solves it, from many twists at
once. A margin keeps the answer off the edge, where other answers would cost the same.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.grasp import grasp_matrix, moment

SOLVED = 1e-12  # largest residual of a solution, relative to the wish
STUCK = 1e8  # damping at which a system is given up
EASIER, HARDER = 0.2, 4.0  # factors of the damping after a step that helped, or did not


class Wishes(NamedTuple):
    """One system of equations a row, in units of the wish and of the longest lever."""

    wrench: FloatArray  # (batch, k)
    grips: FloatArray  # (batch, n, d)
    force_share: FloatArray  # (batch, n), NaN where open
    torque_share: FloatArray  # (batch, n), NaN where open
    margin: float


def find(
    wanted: FloatArray,
    grips: FloatArray,
    force_share: FloatArray,
    torque_share: FloatArray,
    num_starts: int,
    margin: float,
    num_steps: int,
    seed: int,
) -> FloatArray:
    """Wrenches ``(batch, start, n, k)`` with these shares and nothing internal, NaN where none.

    Parameters
    ----------
    wanted
        Object wrenches ``(batch, 3)`` or ``(batch, 6)``, none of them 0 [N, N·m].
    grips
        ``(batch, n, 2)`` or ``(batch, n, 3)`` [m].
    force_share, torque_share
        ``(batch, n)``, rows of NaN where open.
    num_starts
        Twists to start from; the same for every sample.
    margin
        By how much A must exceed B, relative to it.
    num_steps
        After which to give up.
    seed
        Of the twists.
    """
    batch, num_effectors, dimension = grips.shape
    size = wanted.shape[-1]
    length = np.linalg.norm(grips, axis=-1).max(axis=-1)
    length = np.where(length > 0.0, length, 1.0)
    units = np.ones((batch, size))
    units[:, dimension:] = length[:, None]
    scale = np.abs(wanted / units).max(axis=-1)
    units = units * scale[:, None]
    wishes = Wishes(
        np.repeat(wanted / units, num_starts, axis=0),
        np.repeat(grips / length[:, None, None], num_starts, axis=0),
        np.repeat(force_share, num_starts, axis=0),
        np.repeat(torque_share, num_starts, axis=0),
        margin,
    )
    answer = _solve(wishes, _starts(wishes, num_starts, seed), num_steps)
    return answer.reshape(batch, num_starts, num_effectors, size) * units[:, None, None]


def entries(num_effectors: int, size: int) -> int:
    """Number of derivatives in one system of equations, for wrenches ``(n, k)``."""
    return (size + 2 * num_effectors) * (size + 5 * num_effectors + 2)


def _starts(wishes: Wishes, num_starts: int, seed: int) -> FloatArray:
    """Twists of every kind, from translations to rotations, and factors as large as the shares.

    No twist that would take power from the object, as every effector gives some, f_i·u_i ≥ 0.
    """
    num_effectors, size = wishes.grips.shape[-2], wishes.wrench.shape[-1]
    rng = np.random.default_rng(seed)
    shape = (num_starts, size + 5 * num_effectors + 2)
    start = rng.uniform(0.3, 0.8, size=shape)
    start[1::2] = 10.0 ** rng.uniform(-1.5, 0.3, size=shape)[1::2]
    start[:, size:] /= np.sqrt(num_effectors)
    start[:, :size] = rng.normal(size=(num_starts, size))
    start = np.tile(start, (len(wishes.wrench) // num_starts, 1))
    power = (start[:, :size] * wishes.wrench).sum(axis=-1, keepdims=True)
    start[:, :size] *= np.where(power < 0.0, -1.0, 1.0)
    for kind, share in enumerate((wishes.force_share, wishes.force_share, wishes.torque_share)):
        first = size + kind * num_effectors
        factor = np.sqrt(np.where(share > 0.0, num_effectors * share, 1.0))
        start[:, first : first + num_effectors] *= factor
    return start


def _solve(wishes: Wishes, unknowns: FloatArray, num_steps: int) -> FloatArray:
    """Run all systems until each is solved or out of steps; return wrenches, NaN if unsolved."""
    unknowns = unknowns.copy()
    answer = np.full((*wishes.grips.shape[:2], wishes.wrench.shape[-1]), np.nan)
    active = np.arange(len(unknowns))
    damping = np.full(len(unknowns), 1e-2)
    applied, residual, slope = _equations(wishes, unknowns)
    for _ in range(num_steps):
        solved = np.abs(residual).max(axis=-1) <= SOLVED
        answer[active[solved]] = applied[solved]
        keep = ~(solved | (damping > STUCK))
        if not keep.all():
            active, damping = active[keep], damping[keep]
            wishes, unknowns = _rows(wishes, keep), unknowns[keep]
            residual, slope = residual[keep], slope[keep]
        if not len(active):
            break
        square = (residual**2).sum(axis=-1)
        tried = unknowns - _step(residual, slope, damping * square)
        applied, new_residual, new_slope = _equations(wishes, tried)
        better = (new_residual**2).sum(axis=-1) < square
        unknowns = np.where(better[:, None], tried, unknowns)
        residual = np.where(better[:, None], new_residual, residual)
        slope = np.where(better[:, None, None], new_slope, slope)
        damping = np.where(better, np.maximum(EASIER * damping, 1e-6), HARDER * damping)
    return answer


def _step(residual: FloatArray, slope: FloatArray, damping: FloatArray) -> FloatArray:
    """Smallest step that solves the linearised equations, as far as damping lets it."""
    normal = slope @ slope.swapaxes(-1, -2)
    damping = damping + 1e-13 * np.einsum("...ii->...", normal)
    rows = np.arange(normal.shape[-1])
    normal[:, rows, rows] += damping[:, None]
    solution = np.linalg.solve(normal, residual[..., None])
    return (slope.swapaxes(-1, -2) @ solution)[..., 0]


def _rows(wishes: Wishes, which: BoolArray) -> Wishes:
    return Wishes(*(part[which] for part in wishes[:-1]), wishes.margin)  # pyright: ignore


def _equations(wishes: Wishes, unknowns: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Wrenches ``(batch, n, k)``, residuals ``(batch, k + 2n)`` and their derivatives.

    Unknown are the twist (k); b, c, d (n each); slacks of both shares (n each), in use where a
    share is 0 and less may be; and by how much the others exceed their shares then (2).
    """
    batch, num_effectors, dimension = wishes.grips.shape
    size = unknowns.shape[-1] - 5 * num_effectors - 2
    twist = unknowns[:, :size]
    factors = unknowns[:, size : size + 3 * num_effectors].reshape(batch, 3, num_effectors)
    applied, at_centre, by_twist, by_factor = _wrenches(wishes, twist, factors)
    residual = np.zeros((batch, size + 2 * num_effectors))
    slope = np.zeros((batch, residual.shape[-1], unknowns.shape[-1]))
    residual[:, :size] = at_centre.sum(axis=1) - wishes.wrench
    slope[:, :size, :size] = by_twist.sum(axis=1)
    for kind in range(3):
        columns = slice(size + kind * num_effectors, size + (kind + 1) * num_effectors)
        slope[:, :size, columns] = by_factor[:, kind].swapaxes(-1, -2)
    for kind in range(2):
        part = slice(dimension) if kind == 0 else slice(dimension, size)
        rows = slice(size + kind * num_effectors, size + (kind + 1) * num_effectors)
        parts = at_centre[..., part], by_twist[:, :, part], by_factor[..., part]
        residual[:, rows] = _share_equations(wishes, unknowns, kind, parts, slope[:, rows])
    return applied, residual, slope


def _share_equations(
    wishes: Wishes,
    unknowns: FloatArray,
    kind: int,
    parts: tuple[FloatArray, FloatArray, FloatArray],
    slope: FloatArray,
) -> FloatArray:
    """By how much each effector's part along f_o (kind 0) or t_o misses its share ``(batch, n)``.

    ``parts`` are the forces or torques at the centre and their derivatives by twist and factors;
    those of the misses are written to ``slope``.
    """
    value, by_twist, by_factor = parts
    share = (wishes.force_share, wishes.torque_share)[kind]
    size, num_effectors = wishes.wrench.shape[-1], share.shape[-1]
    dimension = wishes.grips.shape[-1]
    resultant = wishes.wrench[:, dimension:] if kind else wishes.wrench[:, :dimension]
    length = np.linalg.norm(resultant, axis=-1)
    asked = ~np.isnan(share[:, :1])
    direction = resultant / np.where(length > 0.0, length, 1.0)[:, None] * asked
    none = (share == 0.0) * 1.0
    first, last = size + (3 + kind) * num_effectors, size + 5 * num_effectors + kind
    slack = none * unknowns[:, first : first + num_effectors]
    excess = none.any(axis=-1) * unknowns[:, last]
    wanted = np.nan_to_num(share)
    slope[..., :size] = np.einsum("bp,bnpt->bnt", direction, by_twist)
    each = np.arange(num_effectors)
    for factor in range(3):
        along = (by_factor[:, factor] * direction[:, None]).sum(axis=-1)
        slope[:, each, size + factor * num_effectors + each] = along
    slope[:, each, first + each] = 2.0 * slack
    slope[..., last] = -2.0 * wanted * excess[:, None]
    along = (value * direction[:, None]).sum(axis=-1)
    return along + slack**2 - wanted * (length + excess**2)[:, None]


def _wrenches(
    wishes: Wishes, twist: FloatArray, factors: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Wrenches at the grips and at the centre ``(batch, n, k)``; the latter's derivatives.

    By the twist ``(batch, n, k, k)`` and by each b, c and d ``(batch, 3, n, k)``.
    """
    batch, num_effectors, dimension = wishes.grips.shape
    size = twist.shape[-1]
    squares = factors**2
    length = np.linalg.norm(wishes.grips, axis=-1, keepdims=True)
    lever = wishes.grips / np.where(length > 0.0, length, 1.0)
    to_centre = grasp_matrix(wishes.grips).reshape(batch, size, num_effectors, size)
    to_centre = to_centre.swapaxes(1, 2)[..., :dimension]  # a force as a wrench at the centre
    moving = to_centre.swapaxes(-1, -2)  # a twist as a velocity at the grip (batch, n, d, k)
    velocity = np.einsum("bndk,bk->bnd", moving, twist)
    along = (velocity * lever).sum(axis=-1, keepdims=True) * lever
    both = velocity + wishes.margin * along
    force = squares[:, 0, :, None] * both + squares[:, 1, :, None] * along
    torque = squares[:, 2, :, None] * twist[:, None, dimension:]
    applied = np.concatenate([force, torque], axis=-1)
    more = wishes.margin * squares[:, 0] + squares[:, 1]
    moving_along = lever[..., None] * np.einsum("bnd,bndk->bnk", lever, moving)[:, :, None]
    force_by_twist = squares[:, 0, :, None, None] * moving + more[..., None, None] * moving_along
    by_twist = to_centre @ force_by_twist
    turning = np.arange(dimension, size)
    by_twist[..., turning, turning] += squares[:, 2, :, None]
    by_factor = np.zeros((batch, 3, num_effectors, size))
    by_factor[:, 0] = (to_centre @ both[..., None])[..., 0]
    by_factor[:, 1] = (to_centre @ along[..., None])[..., 0]
    by_factor[:, 2, :, dimension:] = twist[:, None, dimension:]
    by_factor *= 2.0 * factors[..., None]
    at_centre = applied.copy()
    at_centre[..., dimension:] += moment(wishes.grips, force)
    return applied, at_centre, by_twist, by_factor
