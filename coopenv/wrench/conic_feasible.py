"""From an answer that nearly balances and nearly fits its balls to one that does.

A wrench that leaves a ball by ε may be √ε cheaper than is possible, so that an interior-point
answer must be brought back before its cost means anything. Newton steps do that: the shortest step,
every vector measured in its own length, that restores balance and takes each ball that was ever
left to its surface. What is still outside then is drawn back towards the applied wrench, which
keeps the balance: ‖θ x_I‖² ≤ θ xᵀx_I. The best of all steps counts.

All this is done to x_I, which is small where the set is thin: rounding of 1e-16 of x is worth 1e-8
of its cost there, rounding of 1e-16 of x_I is not.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.conic_parts import (
    NEGLIGIBLE,
    TINY,
    Parts,
    along_lever,
    direction,
    norm,
    parts_of,
    saving_of,
    turned,
)
from coopenv.wrench.grasp import grasp_matrix, sum_at_centre

STEPS = 30  # one or two are enough for all but thin feasible sets
ROUNDING = 4e-16  # of the length of a part of x_I by which it may leave its ball
FLOOR = 1e-20  # the same of x, for what should be 0; worth no more than its root
NOISE = 1e-15  # of the largest part of x_I: what may as well be 0
BALANCED = 2e-15  # what may miss from balance, in parts of the largest part of x_I
USABLE = 1e-14  # what may miss for a step to count at all
SOFT = 1e-14  # balance comes before a ball by this square: thin sets have nearly no way out


class _Samples(NamedTuple):
    """What does not change from step to step."""

    grips: FloatArray
    whole: Parts
    unit: FloatArray  # of each row of balance (m, k)
    rays: BoolArray  # forces that must stay on their line (m, n)
    force_size: FloatArray  # (m, n), 0 for what is left as applied [N]
    torque_size: FloatArray  # [N·m]
    force_balance: FloatArray  # G in these sizes and units, (m, k, n, d)
    torque_balance: FloatArray  # (m, k, n, 1) or (m, k, n, 3)


def plausible(
    internal: FloatArray, applied: FloatArray, grips: FloatArray, weights: Parts, wanted: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return balanced plausible internal wrenches that save as much as can be found, and how much.

    Parameters
    ----------
    internal, applied
        ``(m, n, k)`` [N, N·m]; the first nearly an answer.
    grips
        ``(m, n, d)`` [m].
    weights
        Costs of force, torque and induced torque.
    wanted
        Saving J(h) − J ``(m)`` at which to stop [N].
    """
    samples = _samples(applied, grips)
    internal = _on_rays(internal, samples)
    best = applied - with_torques_shared(applied, grips.shape[-1])
    saving = saving_of(parts_of(best, grips), samples.whole, weights)
    left = np.arange(len(applied))  # samples that are not done
    held = Parts(*(np.zeros(part.shape[:-1], dtype=np.bool_) for part in samples.whole))
    for _ in range(STEPS + 1):
        internal = _without_noise(internal, samples.grips)
        parts = parts_of(internal, samples.grips)
        out = _excess(parts, samples)
        tolerance = rounding_of(parts, samples.whole, samples.grips)
        outside = Parts(*(o > t for o, t in zip(out, tolerance, strict=True)))
        held = Parts(*(h | o for h, o in zip(held, outside, strict=True)))
        fits = ~np.logical_or.reduce([o.any(axis=-1) for o in outside])
        missing = -sum_at_centre(internal, samples.grips)
        miss = (np.abs(missing) / balance_unit(parts, samples.grips)).max(axis=-1)
        reach, saved = _drawn_back(parts, outside, samples, weights)
        better = (miss <= USABLE) & (saved > saving[left])
        best[left[better]], saving[left[better]] = (reach * internal)[better], saved[better]
        todo = ~(fits & (miss <= BALANCED)) & (saving[left] < wanted[left])
        if not todo.any():
            break
        if not todo.all():
            left, internal, missing = left[todo], internal[todo], missing[todo]
            held, out, parts = (Parts(*(v[todo] for v in each)) for each in (held, out, parts))
            samples = _samples(applied[left], grips[left])
        internal = internal + _step(parts, missing / samples.unit, held, out, samples)
    return best, saving


def with_torques_shared(applied: FloatArray, dimension: int) -> FloatArray:
    """Return applied wrenches whose torques are shared along their sum (eqs. 22-23)."""
    torque = applied[..., dimension:]
    resultant = torque.sum(axis=-2, keepdims=True)
    along = np.maximum((torque * resultant).sum(axis=-1, keepdims=True), 0.0)
    total = along.sum(axis=-2, keepdims=True)
    shared = applied.copy()
    shared[..., dimension:] = along / np.where(total > 0, total, 1.0) * resultant
    return shared


def _on_rays(internal: FloatArray, samples: _Samples) -> FloatArray:
    """Turn what belongs on a line onto it, to the last bit."""
    dimension = samples.grips.shape[-1]
    line = direction(samples.whole.force)
    along = (internal[..., :dimension] * line).sum(axis=-1, keepdims=True) * line
    turned_to = internal.copy()
    turned_to[..., :dimension][samples.rays] = along[samples.rays]
    return turned_to


def _without_noise(internal: FloatArray, grips: FloatArray) -> FloatArray:
    """Put forces and torques to 0 that are no more than rounding of the largest.

    What must be 0 may not point anywhere else.
    """
    parts = parts_of(internal, grips)
    unit = balance_unit(parts, grips)
    dimension = grips.shape[-1]
    kept = internal.copy()
    kept[..., :dimension][norm(parts.force) <= NOISE * unit[:, :1]] = 0.0
    kept[..., dimension:][norm(parts.torque) <= NOISE * unit[:, -1:]] = 0.0
    return kept


def _excess(internal: Parts, samples: _Samples) -> Parts:
    """By how much parts leave their balls ``(m, n)``, negative inside; accurate near 0.

    ‖x − v/2‖ − ‖v‖/2 = (‖x‖² − x·v) / (‖x − v/2‖ + ‖v‖/2)
    """
    force, torque, induced = (
        (x * (x - v)).sum(axis=-1) / np.maximum(norm(x - 0.5 * v) + 0.5 * norm(v), TINY)
        for x, v in zip(internal, samples.whole, strict=True)
    )
    return Parts(force, torque, np.where(samples.rays, 0.0, induced))  # which its ray sees to


def rounding_of(internal: Parts, whole: Parts, grips: FloatArray) -> Parts:
    """By how much parts may leave their balls ``(m, n)``."""
    force, torque = (
        ROUNDING * norm(x) + FLOOR * norm(v) for x, v in zip(internal[:2], whole[:2], strict=True)
    )
    return Parts(force, torque, force * norm(grips))


def _samples(applied: FloatArray, grips: FloatArray) -> _Samples:
    whole = parts_of(applied, grips)
    (count, num_effectors, size), dimension = applied.shape, grips.shape[-1]
    force, torque = norm(whole.force), norm(whole.torque)
    unit = balance_unit(whole, grips)
    force_size = np.where(force > NEGLIGIBLE * unit[:, :1], force, 0.0)
    torque_size = np.where(torque > NEGLIGIBLE * unit[:, -1:], torque, 0.0)
    matrix = grasp_matrix(grips).reshape(count, size, num_effectors, size)
    matrix /= unit[:, :, None, None]
    return _Samples(
        grips,
        whole,
        unit,
        along_lever(whole, grips),
        force_size,
        torque_size,
        matrix[..., :dimension] * force_size[:, None, :, None],
        matrix[..., dimension:] * torque_size[:, None, :, None],
    )


def balance_unit(whole: Parts, grips: FloatArray) -> FloatArray:
    """Return the largest force, and torque it may have to balance, for each row ``(m, k)``."""
    force = norm(whole.force).max(axis=-1, keepdims=True)
    torque = np.maximum(
        norm(whole.torque).max(axis=-1, keepdims=True),
        norm(grips).max(axis=-1, keepdims=True) * force,
    )
    rows = [whole.force.shape[-1], whole.torque.shape[-1]]
    return np.maximum(np.repeat(np.concatenate([force, torque], axis=-1), rows, axis=-1), TINY)


def _drawn_back(
    parts: Parts, outside: Parts, samples: _Samples, weights: Parts
) -> tuple[FloatArray, FloatArray]:
    """Return by what to shrink internal wrenches ``(m, 1, 1)``, and what they save then [N]."""
    reach = np.ones(len(samples.unit))
    for x, v, o in zip(parts, samples.whole, outside, strict=True):
        room = np.maximum((x * v).sum(axis=-1), 0.0) / np.maximum((x * x).sum(axis=-1), TINY)
        reach = np.minimum(reach, np.where(o, room, 1.0).min(axis=-1))
    reach = reach[:, None, None]
    return reach, saving_of(Parts(*(reach * x for x in parts)), samples.whole, weights)


def _step(
    parts: Parts, missing: FloatArray, held: Parts, out: Parts, samples: _Samples
) -> FloatArray:
    """Shortest change, in the vectors' own lengths, that restores balance and the held balls."""
    push, free = _force_constraints(parts, held, out, samples)
    turn, loose = _torque_constraints(parts, held, out, samples)
    by_force = np.einsum("mkni,mnij->mknj", samples.force_balance, free)
    by_torque = np.einsum("mkni,mnij->mknj", samples.torque_balance, loose)
    matrix = np.einsum("mkni,mlni->mkl", by_force, samples.force_balance)
    matrix += np.einsum("mkni,mlni->mkl", by_torque, samples.torque_balance)
    missing = missing - np.einsum("mkni,mni->mk", samples.force_balance, push)
    missing -= np.einsum("mkni,mni->mk", samples.torque_balance, turn)
    inverse = np.linalg.pinv(matrix, rcond=1e-15, hermitian=True)
    multipliers = np.einsum("mkl,ml->mk", inverse, missing)
    push = push + np.einsum("mkni,mk->mni", by_force, multipliers)
    turn = turn + np.einsum("mkni,mk->mni", by_torque, multipliers)
    sizes = samples.force_size[..., None], samples.torque_size[..., None]
    return np.concatenate([push * sizes[0], turn * sizes[1]], axis=-1)


def _torque_constraints(
    parts: Parts, held: Parts, out: Parts, samples: _Samples
) -> tuple[FloatArray, FloatArray]:
    """Step ``(m, n, d)`` to the surface of held balls, and the projection that stays there."""
    normal = direction(parts.torque - 0.5 * samples.whole.torque) * held.torque[..., None]
    depth = out.torque / np.maximum(samples.torque_size, TINY)
    return -depth[..., None] * normal, np.eye(normal.shape[-1]) - _outer(normal)


def _force_constraints(
    parts: Parts, held: Parts, out: Parts, samples: _Samples
) -> tuple[FloatArray, FloatArray]:
    """Do the same for forces, which are held by two balls, or by a line and a ball."""
    whole, size = samples.whole, np.maximum(samples.force_size, TINY)
    normal = direction(parts.force - 0.5 * whole.force) * held.force[..., None]
    wanted = -out.force / size * held.force
    free = np.broadcast_to(np.eye(normal.shape[-1]), (*size.shape, *[normal.shape[-1]] * 2))
    if samples.rays.any():
        rays, line = samples.rays[..., None], direction(whole.force)
        normal = np.where(rays, np.sign((normal * line).sum(-1, keepdims=True)) * line, normal)
        free = np.where(rays[..., None], line[..., :, None] * line[..., None, :], free)
    step = wanted[..., None] * normal
    free = free - _outer(normal)
    twisted = held.induced & ~samples.rays
    if twisted.any():
        row = turned(direction(parts.induced - 0.5 * whole.induced), samples.grips)
        lever = np.maximum(norm(row), TINY)
        row = row / lever[..., None]
        shadow = (row * normal).sum(axis=-1)
        second = row - shadow[..., None] * normal
        own = norm(second)
        apart = twisted & (own > 1e-6)
        second = second * (apart / np.maximum(own, TINY))[..., None]
        further = -out.induced / np.maximum(lever * size, TINY) - shadow * wanted
        step = step + (np.where(apart, further, 0.0) / np.maximum(own, TINY))[..., None] * second
        free = free - _outer(second)
    return step, free


def _outer(normal: FloatArray) -> FloatArray:
    """Return n nᵀ, a little less of it."""
    return (1.0 - SOFT) * normal[..., :, None] * normal[..., None, :]
