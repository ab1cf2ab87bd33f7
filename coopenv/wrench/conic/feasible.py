"""From an answer that nearly balances and nearly fits its balls to one that does.

A wrench that leaves a ball by ε may be √ε cheaper than is possible, so that an interior-point
answer must be brought back before its cost means anything. Newton steps do that: the shortest step
that restores balance and takes each ball that was ever left to its surface. What is still outside
then is drawn back towards the applied wrench, which keeps the balance: ‖θ x_I‖² ≤ θ xᵀx_I. The best
of all steps counts.

All this is done to x_I, which is small where the set is thin: rounding of 1e-16 of x is worth 1e-8
of its cost there, rounding of 1e-16 of x_I is not.
"""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.conic.newton import Samples, newton_step, samples_of
from coopenv.wrench.conic.parts import (
    TINY,
    Flags,
    Parts,
    Prices,
    balance_unit,
    direction,
    norm,
    parts_of,
    saving_of,
)
from coopenv.wrench.grasp import sum_at_centre

STEPS = 30  # one or two are enough for all but thin feasible sets
ROUNDING = 4e-16  # of the length of a part of x_I by which it may leave its ball
FLOOR = 1e-20  # the same of x, for what should be 0; worth no more than its root
NOISE = 1e-15  # of the largest part of x_I: what may as well be 0
BALANCED = 2e-15  # what may miss from balance, in parts of the largest part of x_I
NEARLY = 1e-9  # of its own size by which a vector may leave its ball to be nearly plausible
USABLE = 1e-14  # what may miss for a step to count at all


def plausible(
    internal: FloatArray,
    applied: FloatArray,
    grips: FloatArray,
    weights: Prices,
    wanted: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return balanced plausible internal wrenches that save as much as can be found, and how much.

    Third come the last that balance and leave no ball by more than `NEARLY`, NaN where none did.

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
    samples = samples_of(applied, grips)
    internal = _on_rays(internal, samples)
    best, saving = np.zeros_like(applied), np.zeros(len(applied))  # h itself
    nearly = np.full_like(applied, np.nan)
    left = np.arange(len(applied))  # samples that are not done
    held = Flags(*(np.zeros(part.shape[:-1], dtype=np.bool_) for part in samples.whole))
    for _ in range(STEPS + 1):
        internal, parts, unit = _without_noise(internal, samples.grips)
        out = _excess(parts, samples)
        tolerance = rounding_of(parts, samples.whole, samples.grips)
        outside = Flags(*(o > t for o, t in zip(out, tolerance, strict=True)))
        held = Flags(*(h | o for h, o in zip(held, outside, strict=True)))
        fits = ~np.logical_or.reduce([o.any(axis=-1) for o in outside])
        missing = -sum_at_centre(internal, samples.grips)
        miss = (np.abs(missing) / unit).max(axis=-1)
        excess = [
            (o > NEARLY * norm(v)) & (o > t)
            for o, t, v in zip(out, tolerance, samples.whole, strict=True)
        ]
        near = (miss <= USABLE) & ~np.logical_or.reduce([e.any(axis=-1) for e in excess])
        nearly[left[near]] = internal[near]
        if (miss <= USABLE).any():
            reach, saved = _drawn_back(parts, outside, samples, weights)
            better = (miss <= USABLE) & (saved > saving[left])
            best[left[better]], saving[left[better]] = (reach * internal)[better], saved[better]
        todo = ~(fits & (miss <= BALANCED)) & (saving[left] < wanted[left])
        if not todo.any():
            break
        if not todo.all():
            left, internal, missing = left[todo], internal[todo], missing[todo]
            held = Flags(*(flags[todo] for flags in held))
            out, parts = (Parts(*(v[todo] for v in each)) for each in (out, parts))
            samples = samples_of(applied[left], grips[left])
        internal = internal + newton_step(parts, missing / samples.unit, held, out, samples)
    if (saving < wanted).any():
        _share_torques_where_better(best, saving, applied, grips, weights)
    return best, saving, nearly


def _share_torques_where_better(
    best: FloatArray,
    saving: FloatArray,
    applied: FloatArray,
    grips: FloatArray,
    weights: Prices,
) -> None:
    """Overwrite answers, and what they save, that sharing the torques alone would beat."""
    shared = applied - with_torques_shared(applied, grips.shape[-1])
    saved = saving_of(parts_of(shared, grips), parts_of(applied, grips), weights)
    better = saved > saving
    best[better], saving[better] = shared[better], saved[better]


def with_torques_shared(applied: FloatArray, dimension: int) -> FloatArray:
    """Return applied wrenches whose torques are shared along their sum (eqs. 22-23)."""
    torque = applied[..., dimension:]
    resultant = torque.sum(axis=-2, keepdims=True)
    along = np.maximum((torque * resultant).sum(axis=-1, keepdims=True), 0.0)
    total = along.sum(axis=-2, keepdims=True)
    shared = applied.copy()
    shared[..., dimension:] = along / np.where(total > 0, total, 1.0) * resultant
    return shared


def _on_rays(internal: FloatArray, samples: Samples) -> FloatArray:
    """Turn what belongs on a line onto it, to the last bit."""
    dimension = samples.grips.shape[-1]
    line = direction(samples.whole.force)
    along = (internal[..., :dimension] * line).sum(axis=-1, keepdims=True) * line
    turned_to = internal.copy()
    turned_to[..., :dimension][samples.rays] = along[samples.rays]
    return turned_to


def _without_noise(internal: FloatArray, grips: FloatArray) -> tuple[FloatArray, Parts, FloatArray]:
    """Put forces and torques to 0 that are no more than rounding of the largest.

    What must be 0 may not point anywhere else. Also return the parts, and their `balance_unit`.
    """
    internal = internal.copy()
    parts = parts_of(internal, grips)  # force and torque are views
    unit = balance_unit(parts, grips)
    still = norm(parts.force) <= NOISE * unit[:, :1]
    parts.force[still], parts.induced[still] = 0.0, 0.0
    parts.torque[norm(parts.torque) <= NOISE * unit[:, -1:]] = 0.0
    return internal, parts, unit


def _excess(internal: Parts, samples: Samples) -> Parts:
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


def _drawn_back(
    parts: Parts, outside: Flags, samples: Samples, weights: Prices
) -> tuple[FloatArray, FloatArray]:
    """Return by what to shrink internal wrenches ``(m, 1, 1)``, and what they save then [N]."""
    reach = np.ones(len(samples.unit))
    for x, v, o in zip(parts, samples.whole, outside, strict=True):
        room = np.maximum((x * v).sum(axis=-1), 0.0) / np.maximum((x * x).sum(axis=-1), TINY)
        reach = np.minimum(reach, np.where(o, room, 1.0).min(axis=-1))
    reach = reach[:, None, None]
    return reach, saving_of(Parts(*(reach * x for x in parts)), samples.whole, weights)
