"""Wishes that some wrench fulfils, and what it means for them to come back."""

import numpy as np

from coopenv import wrench
from coopenv.arrays import FloatArray

NOTHING = np.zeros(())


def assert_comes_back(applied, grips, wanted, internal=NOTHING, force=None, torque=None, **cost):
    """Assert that a wrench has the resultant, shares and internal wrench that were wanted."""
    assert miss(applied, grips, wanted, internal, force, torque, **cost).max(initial=0.0) <= 1e-6


def miss(applied, grips, wanted, internal=NOTHING, force=None, torque=None, **cost) -> FloatArray:
    """By how much wrenches miss what was wanted, relative to their size."""
    d = wrench.decompose(applied, grips, **cost)
    size = np.abs(applied).max(axis=(-1, -2)) + 1e-300
    off = np.abs(d.object_wrench - wanted).max(axis=-1) / size
    off = np.maximum(off, np.abs(d.internal - internal).max(axis=(-1, -2)) / size)
    for found, share in zip(d.load_share, (force, torque), strict=True):
        if share is not None:
            asked = ~np.isnan(share)
            assert np.isfinite(found[asked]).all()
            off = np.maximum(off, np.where(asked, np.abs(found - share), 0.0).max(axis=-1))
    return off


def without_internal_part(
    rng: np.random.Generator, count: int, num_effectors: int, dimension: int
) -> tuple[FloatArray, FloatArray]:
    """Wrenches ``(count, n, k)`` that a random twist vouches for, and their grips.

    Forces are A times the part along the lever of the grip's velocity, B ≤ A times that across,
    torques T times the angular velocity; some T are 0, and some wrenches small.
    """
    grips = rng.normal(size=(count, num_effectors, dimension))
    towards = rng.normal(size=(count, 1, dimension)) * rng.choice([0.2, 1.0, 3.0], (count, 1, 1))
    turning = rng.normal(size=(count, 1, 2 * dimension - 3))
    if dimension == 2:
        velocity = towards + turning * np.stack([-grips[..., 1], grips[..., 0]], axis=-1)
    else:
        velocity = towards + np.cross(turning, grips)
    lever = grips / np.linalg.norm(grips, axis=-1, keepdims=True)
    along = (velocity * lever).sum(axis=-1, keepdims=True) * lever
    each = (count, num_effectors, 1)
    part = rng.random(each) ** rng.choice([1, 3], (count, 1, 1))
    force = part * (along + rng.random(each) * (velocity - along))
    torque = rng.random(each) * rng.choice([0.0, 0.1, 1.0], each) * turning
    return np.concatenate([force, torque], axis=-1), grips
