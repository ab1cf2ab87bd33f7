"""Bound on the optimum by weak duality, whatever multipliers the cone solver returned.

Let λ be any multipliers of balance. Let ζ be any vector with ‖ζ‖ ≤ c for every costed vector v of
the wrench, and any vector for every disc, the ball of an induced torque. For the other balls let
ζ_ball = −Gᵀλ − Σ ζ_cost − Σ ζ_disc. Then the optimum J* obeys

J(h) − J* ≤ Σ_cost [c‖v‖ + ζ·v] + ½ Σ_ball,disc [‖ζ‖‖v‖ + ζ·v]

Every term is ≥ 0 and is evaluated without cancellation. Parts of the wrench that the program leaves
out as negligible or parallel count here.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.conic.parts import TINY, Parts, Prices, along_lever, direction, norm, turned
from coopenv.wrench.grasp import moment

NEAR = 0.03  # sine of the angle to Σ f up to which forces are tried as agreeing
STRAIGHT = 1e-3  # sine of the angle to its lever up to which a force is also bounded as along it
AGREEMENTS = (0.1, 1.0, 10.0)  # multipliers of Σ f tried there, in units of cost / sine


class Duals(NamedTuple):
    """Multipliers of ``(m)`` samples."""

    balance: FloatArray  # λ, (m, 3) or (m, 6) [1, 1/m]
    force: FloatArray  # ζ of the forces' cost (m, n, d) [1]
    torque: FloatArray  # ζ of the torques' cost, (m, n, 1) or (m, n, 3) [1/m]
    induced: FloatArray  # ζ of the induced torques' cost, of the same shape [1/m]
    disc: FloatArray  # ζ of the induced torques' balls, of the same shape [1/m]


class Bound(NamedTuple):
    """What multipliers say about the optimum."""

    shortfall: FloatArray  # J(h) − J* is no more than this, (m) [N]
    balance: FloatArray  # |λ|, what missing balance by 1 N or N·m is worth, as in `Duals`
    balls: Parts  # ‖ζ‖ of the balls, what leaving them by 1 N or N·m is worth (m, n)


def default_duals(whole: Parts, weights: Prices) -> Duals:
    """Return ζ = −c v/‖v‖ for forces and torques, 0 for all else.

    Exact where a vector is restricted to its own ray, as its cost is linear there.
    """
    nothing = np.zeros_like(whole.induced)
    size = whole.force.shape[-1] + whole.torque.shape[-1]
    force, torque = (
        -weights.force * direction(whole.force),
        -weights.torque * direction(whole.torque),
    )
    return Duals(np.zeros((len(nothing), size)), force, torque, nothing, nothing.copy())


def bounded(
    whole: Parts,
    grips: FloatArray,
    weights: Prices,
    duals: Duals,
    near_lever: BoolArray | None = None,
) -> Bound:
    """Bound J(h) − J* from above, whatever the duals.

    Parameters
    ----------
    whole, grips
        The applied wrenches of ``(m, n)`` effectors [N, N·m] and where they grip [m].
    weights
        Costs of force, torque and induced torque.
    duals
        What to bound it with; cut down to ‖ζ‖ ≤ c where they must be.
    near_lever
        Forces ``(m, n)`` across whose lever ζ of the disc is chosen here, as of those along it.
    """
    dimension = grips.shape[-1]
    push, turn = duals.balance[:, None, :dimension], duals.balance[:, None, dimension:]
    force, torque = _clipped(duals.force, weights.force), _clipped(duals.torque, weights.torque)
    total = _cost_defect(force, whole.force, weights.force)
    total += _cost_defect(torque, whole.torque, weights.torque)
    disc, about = duals.disc, turn + duals.disc
    if weights.induced > 0.0:
        induced = _clipped(duals.induced, weights.induced)
        total += _cost_defect(induced, whole.induced, weights.induced)
        about = about + induced
    left = -push - force - turned(about, grips)
    on_ray = along_lever(whole, grips)
    if near_lever is not None:
        on_ray = on_ray | near_lever
    if on_ray.any():  # such a disc is a point, and its ζ free: it takes all that is across
        square = np.where(on_ray, (grips * grips).sum(axis=-1), np.inf)
        free = moment(grips, left) / square[..., None]
        left, disc = left - turned(free, grips), disc + free
    rest = -turn - torque
    total += 0.5 * (_defect(left, whole.force) + _defect(rest, whole.torque))
    total += 0.5 * _defect(disc, whole.induced)
    worth = Parts(norm(left), norm(rest), norm(disc))
    return Bound(total.sum(axis=-1), np.abs(duals.balance), worth)


def best_bound(whole: Parts, grips: FloatArray, weights: Prices, duals: Duals) -> Bound:
    """Return the best of the bounds from these duals and, near agreement, from some others.

    Where forces nearly agree the best multipliers along Σ f grow as 1/sine. No solver reaches them,
    so that they are tried as well.
    """
    bound = bounded(whole, grips, weights, duals)
    _choose_discs_where_better(bound, whole, grips, weights, duals)
    towards = direction(whole.force.sum(axis=-2, keepdims=True))
    sine = _disagreement(whole.force, towards)
    near = np.flatnonzero(sine <= NEAR)
    if not near.size:
        return bound
    some = Parts(*(part[near] for part in whole))
    own, grips = Duals(*(values[near] for values in duals)), grips[near]
    costs = weights.force + weights.torque * norm(grips).max(axis=-1)
    towards = towards[near, 0] * (costs / np.maximum(sine[near], 1e-15))[:, None]
    for candidate in _candidates(some, weights, own, towards):
        _keep_better(bound, near, bounded(some, grips, weights, candidate))
    return bound


def _choose_discs_where_better(
    bound: Bound, whole: Parts, grips: FloatArray, weights: Prices, duals: Duals
) -> None:
    """Overwrite bounds where a force nearly along its lever is better bounded as one along it.

    What it induces is so little that the ζ of its disc costs next to nothing; a solver knows that ζ
    to its tolerance divided by the sine only.
    """
    reach = norm(whole.force) * norm(grips)
    near = (reach > 0.0) & (norm(whole.induced) <= STRAIGHT * reach)
    where = np.flatnonzero(near.any(axis=-1))
    if where.size:
        some, own = Parts(*(v[where] for v in whole)), Duals(*(v[where] for v in duals))
        _keep_better(bound, where, bounded(some, grips[where], weights, own, near[where]))


def _candidates(whole: Parts, weights: Prices, own: Duals, towards: FloatArray) -> list[Duals]:
    """Return multipliers along Σ f, alone and added to a solver's own.

    ζ is −c v/‖v‖ for forces. For torques it is −ν, where ν is along their sum or is the solver's.
    """
    dimension = whole.force.shape[-1]
    plain = default_duals(whole, weights)
    induced = -weights.induced * direction(whole.induced)
    summed = weights.torque * direction(whole.torque.sum(axis=-2))
    candidates = []
    for factor in AGREEMENTS:
        for turn in (summed, own.balance[:, dimension:]):
            balance = np.concatenate([factor * towards, turn], axis=-1)
            torque = np.broadcast_to(-turn[:, None], whole.torque.shape)
            candidates.append(Duals(balance, plain.force, torque, induced, plain.disc))
        more = own.balance.copy()
        more[:, :dimension] += factor * towards
        candidates.append(own._replace(balance=more))
    return candidates


def _keep_better(bound: Bound, where: NDArray[np.intp], other: Bound) -> None:
    """Overwrite the bounds of the samples ``where`` the other is closer."""
    better = other.shortfall < bound.shortfall[where]
    chosen = where[better]
    bound.shortfall[chosen] = other.shortfall[better]
    bound.balance[chosen] = other.balance[better]
    for mine, theirs in zip(bound.balls, other.balls, strict=True):
        mine[chosen] = theirs[better]


def _disagreement(force: FloatArray, towards: FloatArray) -> FloatArray:
    """Return the largest sine of the angle between a force and a direction, 1 if one opposes it."""
    along = (force * towards).sum(axis=-1)
    size = norm(force)
    sine = norm(force - along[..., None] * towards) / np.maximum(size, TINY)
    return np.where((along <= 0.0) & (size > 0.0), 1.0, sine).max(axis=-1)


def _defect(a: FloatArray, v: FloatArray) -> FloatArray:
    """Return ‖a‖‖v‖ + a·v, accurate where they are opposed."""
    size, length = norm(a), norm(v)
    unit = v / np.maximum(length, TINY)[..., None]
    along = (a * unit).sum(axis=-1)
    across = a - along[..., None] * unit
    against = along < 0.0
    opposed = (across * across).sum(axis=-1) / np.where(against, size - along, 1.0)
    return length * np.where(against, opposed, size + along)


def _cost_defect(zeta: FloatArray, v: FloatArray, cost: float) -> FloatArray:
    """Return c‖v‖ + ζ·v for ‖ζ‖ ≤ c."""
    return np.maximum(cost - norm(zeta), 0.0) * norm(v) + _defect(zeta, v)


def _clipped(zeta: FloatArray, cost: float) -> FloatArray:
    """Shorten to ‖ζ‖ ≤ c."""
    return zeta * (cost / np.maximum(norm(zeta), max(cost, TINY)))[..., None]
