"""Feasible answers from nearly feasible ones: wrenches that balance and are in all their balls.

A wrench that leaves a ball by ε may be √ε cheaper than is possible. An interior-point answer must
therefore be brought back before its cost means anything. Newton steps do that (`newton`): the
shortest steps that restore balance and take each ball that was ever left to its surface. What is
still outside after a step is drawn back towards the applied wrench, which keeps the balance:
‖θ x_I‖² ≤ θ xᵀx_I. The best of all steps counts.

All this is done to x_I, the internal part of x, which is small where the feasible set is thin.
There, rounding of x by 1e-16 may change the cost by 1e-8, rounding of x_I by 1e-16 does not.
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
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

    The third array holds the last ones that balance and leave no ball by more than `NEARLY`. They
    are NaN where there were none.

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
        # which balls are left, and what misses balance
        internal, parts, unit = _without_noise(internal, samples.grips)
        out = _excess(parts, samples)
        tolerance = rounding_of(parts, samples.whole, samples.grips)
        outside = Flags(*(o > t for o, t in zip(out, tolerance, strict=True)))
        held = Flags(*(h | o for h, o in zip(held, outside, strict=True)))
        fits = ~np.logical_or.reduce([o.any(axis=-1) for o in outside])
        missing = -sum_at_centre(internal, samples.grips)
        miss = (np.abs(missing) / unit).max(axis=-1)
        usable = miss <= USABLE

        # keep the best
        near = usable & _nearly_fits(out, tolerance, samples)
        nearly[left[near]] = internal[near]
        if usable.any():
            reach, saved = _drawn_back(parts, outside, samples, weights)
            better = usable & (saved > saving[left])
            best[left[better]], saving[left[better]] = (reach * internal)[better], saved[better]

        # go on with the samples that are not done
        todo = ~(fits & (miss <= BALANCED)) & (saving[left] < wanted[left])
        if not todo.any():
            break
        if not todo.all():
            left, internal, missing = left[todo], internal[todo], missing[todo]
            held = Flags(*(flags[todo] for flags in held))
            out, parts = (Parts(*(v[todo] for v in each)) for each in (out, parts))
            samples = samples_of(applied[left], grips[left])

        # step
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
    """Overwrite answers, and what they save, where sharing the torques alone saves more."""
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
    """Project forces that must stay on a line onto it, to the last bit."""
    dimension = samples.grips.shape[-1]
    line = direction(samples.whole.force)
    along = (internal[..., :dimension] * line).sum(axis=-1, keepdims=True) * line
    turned_to = internal.copy()
    turned_to[..., :dimension][samples.rays] = along[samples.rays]
    return turned_to


def _without_noise(internal: FloatArray, grips: FloatArray) -> tuple[FloatArray, Parts, FloatArray]:
    """Put forces and torques to 0 that are no more than rounding of the largest.

    Rounding points in any direction, which what must be 0 may not. Also returned are the parts, and
    their `balance_unit`.
    """
    internal = internal.copy()
    parts = parts_of(internal, grips)  # force and torque are views
    unit = balance_unit(parts, grips)
    still = norm(parts.force) <= NOISE * unit[:, :1]
    parts.force[still], parts.induced[still] = 0.0, 0.0
    parts.torque[norm(parts.torque) <= NOISE * unit[:, -1:]] = 0.0
    return internal, parts, unit


def _excess(internal: Parts, samples: Samples) -> Parts:
    """Return by how much parts leave their balls ``(m, n)``, negative inside; accurate near 0.

    ‖x − v/2‖ − ‖v‖/2 = (‖x‖² − x·v) / (‖x − v/2‖ + ‖v‖/2)
    """
    force, torque, induced = (
        (x * (x - v)).sum(axis=-1) / np.maximum(norm(x - 0.5 * v) + 0.5 * norm(v), TINY)
        for x, v in zip(internal, samples.whole, strict=True)
    )
    return Parts(force, torque, np.where(samples.rays, 0.0, induced))  # which its ray sees to


def rounding_of(internal: Parts, whole: Parts, grips: FloatArray) -> Parts:
    """Return by how much parts may leave their balls ``(m, n)``."""
    force, torque = (
        ROUNDING * norm(x) + FLOOR * norm(v) for x, v in zip(internal[:2], whole[:2], strict=True)
    )
    return Parts(force, torque, force * norm(grips))


def _nearly_fits(out: Parts, tolerance: Parts, samples: Samples) -> BoolArray:
    """Whether no ball is left by more than rounding and `NEARLY` of its size ``(m,)``."""
    far = [
        ((o > NEARLY * norm(v)) & (o > t)).any(axis=-1)
        for o, t, v in zip(out, tolerance, samples.whole, strict=True)
    ]
    return ~np.logical_or.reduce(far)


def _drawn_back(
    parts: Parts, outside: Flags, samples: Samples, weights: Prices
) -> tuple[FloatArray, FloatArray]:
    """Return factors that shrink wrenches into their balls ``(m, 1, 1)``, and the saving [N]."""
    reach = np.ones(len(samples.unit))
    for x, v, o in zip(parts, samples.whole, outside, strict=True):
        room = np.maximum((x * v).sum(axis=-1), 0.0) / np.maximum((x * x).sum(axis=-1), TINY)
        reach = np.minimum(reach, np.where(o, room, 1.0).min(axis=-1))
    reach = reach[:, None, None]
    return reach, saving_of(Parts(*(reach * x for x in parts)), samples.whole, weights)
