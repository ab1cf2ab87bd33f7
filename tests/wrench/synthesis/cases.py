"""Wishes that some wrench fulfils, and what it means for them to come back."""

import numpy as np

from coopenv import wrench
from coopenv.arrays import FloatArray

NOTHING = np.zeros(())


def assert_comes_back(applied, grips, wanted, internal=NOTHING, force=None, torque=None, **cost):
    """Assert that a wrench has the resultant, shares and internal wrench that were wanted."""
    assert miss(applied, grips, wanted, internal, force, torque, **cost).max(initial=0.0) <= 1e-6


def miss(applied, grips, wanted, internal=NOTHING, force=None, torque=None, **cost) -> FloatArray:
    """By how much wrenches miss what was wanted, in parts of what is applied.

    A torque counts as the force that makes it at the longest lever.
    """
    d = wrench.decompose(applied, grips, **cost)
    length = np.linalg.norm(grips, axis=-1).max(axis=-1)
    units = np.ones((*length.shape, np.shape(applied)[-1]))
    units[..., np.shape(grips)[-1] :] = np.where(length > 0.0, length, 1.0)[..., None]
    size = np.abs(applied / units[..., None, :]).max(axis=(-1, -2)) + 1e-300
    off = np.abs((d.object_wrench - wanted) / units).max(axis=-1) / size
    inside = np.abs((d.internal - internal) / units[..., None, :]).max(axis=(-1, -2))
    off = np.maximum(off, inside / size)
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
    each = (count, num_effectors, 1)
    part = rng.random(each) ** rng.choice([1, 3], (count, 1, 1))
    across = part * rng.random(each)
    factor = rng.random(each) * rng.choice([0.0, 0.1, 1.0], each)
    return vouched_for(grips, (towards, turning), (part, across, factor)), grips


GRIPS = ("anywhere", "regular", "on a line", "one at the centre", "at one point", "at corners")
MOTIONS = ("any", "translation", "rotation", "slow turn", "planar")


def at_the_edge(
    rng: np.random.Generator, count: int, team: tuple[int, int], place: str, motion: str
) -> tuple[FloatArray, FloatArray]:
    """Wrenches free of internal wrench with many factors 0 or equal, in special positions."""
    num_effectors, dimension = team
    grips = rng.normal(size=(count, num_effectors, dimension))
    if place == "regular":
        angle = 2.0 * np.pi * np.arange(num_effectors) / num_effectors
        grips[:] = 0.0
        grips[..., 0], grips[..., 1] = np.cos(angle), np.sin(angle)
    elif place == "on a line":
        grips = grips[..., :1] * rng.normal(size=(count, 1, dimension))
    elif place == "one at the centre":
        grips[:, 0] = 0.0
    elif place == "at one point":
        grips[:, 1] = grips[:, 0]
    elif place == "at corners":
        grips = rng.choice([-1.0, 1.0], grips.shape) * np.array([1.0, 0.5, 0.25][:dimension])
    towards = rng.normal(size=(count, 1, dimension)) * (motion != "rotation")
    turning = rng.normal(size=(count, 1, 2 * dimension - 3))
    turning *= {"translation": 0.0, "slow turn": 0.01}.get(motion, 1.0)
    if motion == "planar" and dimension == 3:
        towards[..., 2], turning[..., :2] = 0.0, 0.0
    each = (count, num_effectors, 1)
    part = rng.random(each) * rng.choice([0.0, 0.1, 1.0], each, p=[0.15, 0.15, 0.7])
    across = part * rng.choice([0.0, 0.5, 1.0], each)
    factor = rng.random(each) * rng.choice([0.0, 0.0, 1.0], each)
    return vouched_for(grips, (towards, turning), (part, across, factor)), grips


def vouched_for(grips, twist, factors) -> FloatArray:
    """Wrenches with factors A, B and T of what a twist makes of grips."""
    towards, turning = twist
    if grips.shape[-1] == 2:
        velocity = towards + turning * np.stack([-grips[..., 1], grips[..., 0]], axis=-1)
    else:
        velocity = towards + np.cross(turning, grips)
    length = np.linalg.norm(grips, axis=-1, keepdims=True)
    lever = grips / np.where(length > 0.0, length, 1.0)
    along = (velocity * lever).sum(axis=-1, keepdims=True) * lever
    force = factors[0] * along + factors[1] * (velocity - along)
    return np.concatenate([force, factors[2] * turning], axis=-1)
