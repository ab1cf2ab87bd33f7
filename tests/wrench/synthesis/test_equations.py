"""Equations of a wished load share: what they take a twist to make at each grip."""

import numpy as np
import pytest

from coopenv.wrench.synthesis.equations import set_up

LENGTHS = np.array([1.0, 0.3, 1e-3, 0.0])  # of levers, the longest is the unit


def crossed(a, b):
    """a × b; in the plane of numbers along z, and of vectors, their moment."""
    if len(a) == 1:
        return a * np.array([-b[1], b[0]])
    return np.array([a[0] * b[1] - a[1] * b[0]]) if len(a) == 2 else np.cross(a, b)


@pytest.mark.parametrize("dimension", [2, 3])
def test_parts_are_along_the_lever_however_long_it_is_all_of_the_motion_and_its_turning(dimension):
    rng, size = np.random.default_rng(0), 3 * dimension - 3
    towards = rng.normal(size=(len(LENGTHS), dimension))
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    grips, share = LENGTHS[:, None] * towards, np.full((1, len(LENGTHS)), np.nan)
    parts = set_up(np.ones((1, size)), grips[None], share, share).parts[0]
    twist = rng.normal(size=size)
    spin = twist[dimension:]
    for grip, lever, length, made in zip(grips, towards, LENGTHS, parts @ twist, strict=True):
        motion = twist[:dimension] + crossed(spin, grip)
        along = (length > 0) * lever * (lever @ motion)
        for found, force, torque in zip(
            made, (along, motion, 0 * along), (0, 0, spin), strict=True
        ):
            at_centre = np.concatenate([force, crossed(grip, force) + torque])
            np.testing.assert_allclose(found, at_centre, atol=1e-12)
