"""Synthesis for two planar effectors off any line through the centre of mass.

The x axis is laid along D = r_1 − r_2. F is the wanted resultant force, g the wanted internal force
on effector 1, p the manipulation force of effector 1 and F − p that of effector 2; T(p) is the
torque that is left to pure torques. Candidates for p come from `points`. At each, the pure torques
are known: an effector that keeps torque of T's sign supplies T, two supply it in proportion to what
they keep (eq. 23), and only where none keeps any does the torque share say. What keeps plausibility
and shares is decomposed, and what comes back as wanted is an answer.
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.wrench.measures import cost_weights
from coopenv.wrench.pair.off_axis import decompose_off_axis, frame
from coopenv.wrench.synthesis.points import PlanarWish, cross, keeping, points, torque_left
from coopenv.wrench.synthesis.wish import Wish, internal_miss, into_frame, out_of_frame, share_miss

ALLOWED = 1e-7  # by how much a candidate may miss plausibility or shares before it is decomposed
FOUND = 1e-7  # by how much its decomposition may miss what is wanted, relative to the wrench
AT_ONCE = 64  # wishes whose candidates are in memory at the same time


def find(wish: Wish) -> FloatArray:
    """Smallest wrenches ``(batch, 2, 3)`` found that decompose as wanted; NaN where none is."""
    answer = np.full(wish.internal.shape, np.nan)
    for start in range(0, len(answer), AT_ONCE):
        rows = np.arange(start, min(start + AT_ONCE, len(answer)))
        answer[rows] = _find(wish.rows(rows))
    return answer


def _find(wish: Wish) -> FloatArray:
    axis = frame(wish.grips)
    units = _units(wish)
    wanted = _in_frame(wish, axis, units)
    with np.errstate(all="ignore"):  # a candidate that does not exist is NaN or infinite
        manipulation = _candidates(wanted, points(wanted))
        sample, number = np.nonzero(_is_plausible(wanted, manipulation))
        tried = out_of_frame(manipulation[sample, number], axis[sample]) * units[sample, None]
    tried = tried + wish.internal[sample]
    miss = share_miss(tried, wish.rows(sample))
    shared = miss <= FOUND
    miss[shared] = _internal_miss(tried[shared], axis, wish, sample[shared])
    found = np.flatnonzero(miss <= FOUND)
    size = np.abs(tried[found]).max(axis=(-1, -2))
    found = found[np.lexsort((size, sample[found]))]
    rows, first = np.unique(sample[found], return_index=True)
    answer = np.full(wish.internal.shape, np.nan)
    answer[rows] = tried[found[first]]
    return answer


def _internal_miss(
    applied: FloatArray, axis: FloatArray, wish: Wish, sample: IntArray
) -> FloatArray:
    """By how much what is decomposed misses what is wanted, relative to what is applied."""
    weights = cost_weights(wish.settings.torque_weight, wish.settings.include_induced)
    internal = applied - decompose_off_axis(applied, axis[sample], weights)
    length = np.hypot(wish.grips[..., 0], wish.grips[..., 1]).max(axis=-1)[sample]
    return internal_miss(internal, wish.internal[sample], applied, length)


def _units(wish: Wish) -> FloatArray:
    """Of forces and torques ``(batch, 3)``, such that nothing wanted is larger than 1."""
    length = np.hypot(wish.grips[..., 0], wish.grips[..., 1]).max(axis=-1)
    units = np.stack([np.ones_like(length), np.ones_like(length), length], axis=-1)
    largest = np.abs(wish.internal / units[:, None]).max(axis=(-1, -2))
    largest = np.maximum(largest, np.abs(wish.object_wrench / units).max(axis=-1))
    return units * np.where(largest > 0.0, largest, 1.0)[:, None]


def _in_frame(wish: Wish, axis: FloatArray, units: FloatArray) -> PlanarWish:
    length = units[:, 2] / units[:, 0]
    wanted, internal = wish.object_wrench / units, wish.internal / units[:, None]
    weight = wish.settings.torque_weight
    return PlanarWish(
        into_frame(wanted[:, :2], axis),
        wanted[:, 2],
        into_frame(internal[:, 0, :2], axis),
        internal[..., 2],
        wish.force_share[:, 0],
        wish.torque_share[:, 0],
        into_frame(wish.grips, axis[:, None]) / length[:, None, None],
        weight * length / (1.0 - weight),
        wish.settings.include_induced,
    )


def _candidates(wish: PlanarWish, point: FloatArray) -> FloatArray:
    """Manipulation wrenches ``(batch, m, 2, 3)`` of forces p, with every way to supply T."""
    left = torque_left(wish, point)
    own = np.stack([part[:, None] * left for part in keeping(wish)], axis=-1)
    asked = wish.torque_share * wish.torque - wish.internal_torque[:, 0]
    shared = asked[:, None] - cross(wish.grips[:, None, 0], point + wish.internal[:, None])
    own = np.concatenate([own, 0.5 * left[..., None], shared[..., None]], axis=-1)
    manipulation = np.empty((*own.shape, 2, 3))
    manipulation[..., 0, :2] = point[..., None, :]
    manipulation[..., 1, :2] = (wish.force[:, None] - point)[..., None, :]
    manipulation[..., 0, 2] = own
    manipulation[..., 1, 2] = left[..., None] - own
    return manipulation.reshape(len(point), -1, 2, 3)


def _is_plausible(wish: PlanarWish, manipulation: FloatArray) -> BoolArray:
    """Whether nothing internal exceeds what is applied (eqs. 9-11), and no pure torques cancel."""
    good = np.isfinite(manipulation).all(axis=(-1, -2))
    left = manipulation[..., 2].sum(axis=-1)
    size = 1.0 + np.abs(manipulation).max(axis=(-1, -2))
    for k, internal in enumerate((wish.internal, -wish.internal)):
        force, torque = manipulation[..., k, :2], manipulation[..., k, 2]
        grip = wish.grips[:, None, k]
        good &= (force * internal[:, None]).sum(axis=-1) >= -ALLOWED * size
        induced = cross(grip, force) * cross(grip, internal[:, None])
        good &= induced >= -ALLOWED * size
        good &= torque * wish.internal_torque[:, None, k] >= -ALLOWED * size
        good &= torque * left >= -ALLOWED * size
    return np.asarray(good)
