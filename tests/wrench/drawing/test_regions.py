"""Where plausible manipulation forces lie: polygons beside the checks of splits."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.wrench.drawing import regions

BEAM = np.array([(-0.9, 0.0), (0.9, 0.0)])


def test_the_disc_has_the_force_as_its_diameter():
    force = np.array([3.0, 4.0])
    corners = regions.disc(force)
    np.testing.assert_allclose(np.linalg.norm(corners - force / 2, axis=-1), 2.5)
    np.testing.assert_allclose((corners * (corners - force)).sum(axis=-1), 0.0, atol=1e-12)
    assert np.abs(corners - force).sum(axis=-1).min() == pytest.approx(0.0, abs=1e-12)


def test_the_band_of_a_grip_on_the_x_axis_bounds_the_force_across():
    applied = np.array([(3.0, 2.0, 0.0), (0.0, -1.0, 0.0)])
    corners = regions.disc_and_band(applied, BEAM, 0)
    assert corners[:, 1].min() == pytest.approx(0.0, abs=1e-8)
    assert corners[:, 1].max() == pytest.approx(2.0)
    assert corners[:, 0].max() == pytest.approx(1.5 + np.hypot(1.5, 1.0), rel=1e-3)


def is_feasible(applied, grips, first):
    """Whether pure torques complete f_M,1 to a plausible split, by its own constraints."""
    manipulation = np.zeros((2, 3))
    manipulation[0, :2], manipulation[1, :2] = first, applied[:, :2].sum(axis=0) - first
    left = (wrench.object_wrench(applied, grips) - wrench.object_wrench(manipulation, grips))[2]
    shares = np.clip(left, np.minimum(applied[:, 2], 0), np.maximum(applied[:, 2], 0))
    both = shares.sum() - left  # what both gave too much, as far as they oppose each other
    for i in range(2):
        back = np.clip(shares[i] - both, min(applied[i, 2], 0), max(applied[i, 2], 0))
        both -= shares[i] - back
        shares[i] = back
    manipulation[:, 2] = shares
    return wrench.is_plausible(applied, applied - manipulation, grips, tolerance=2e-3)


@pytest.mark.parametrize("seed", range(6))
def test_the_lens_of_a_pair_is_what_plausible_splits_leave(seed):
    rng = np.random.default_rng(seed)
    applied, grips = rng.normal(size=(2, 3)), rng.normal(size=(2, 2))
    corners = regions.feasible_forces(applied, grips)
    middle = corners.mean(axis=0)
    for corner in corners[::7]:
        assert is_feasible(applied, grips, corner)
        beyond = corner + 0.02 * (corner - middle) / max(np.linalg.norm(corner - middle), 1e-9)
        if len(corners) > 2 and np.linalg.norm(corner - middle) > 0.05:
            assert not is_feasible(applied, grips, beyond)


@pytest.mark.parametrize("seed", range(4))
def test_the_optimum_lies_in_the_lens(seed):
    rng = np.random.default_rng(seed)
    applied = rng.normal(size=(2, 3))
    first = wrench.decompose(applied, BEAM).manipulation[0, :2]
    corners = regions.feasible_forces(applied, BEAM)
    edges = np.roll(corners, -1, axis=0) - corners
    to = first - corners
    sides = edges[:, 0] * to[:, 1] - edges[:, 1] * to[:, 0]
    assert sides.min() >= -2e-3 or sides.max() <= 2e-3


def test_who_agree_leave_each_other_nothing_but_what_they_applied():
    applied = np.array([(1.0, 2.0, 0.0), (2.0, 4.0, 0.0)])
    corners = regions.feasible_forces(applied, BEAM)
    np.testing.assert_allclose(corners, np.broadcast_to([1.0, 2.0], corners.shape), atol=1e-6)


def test_opposed_forces_on_a_line_leave_a_line():
    applied = np.array([(3.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    corners = regions.feasible_forces(applied, BEAM)
    assert np.abs(corners[:, 1]).max() <= 1e-6
    assert (corners[:, 0].min(), corners[:, 0].max()) == pytest.approx((2.0, 3.0), abs=1e-3)


def test_an_effector_that_gives_no_force_leaves_the_other_its_own():
    applied = np.array([(3.0, 1.0, 0.0), (0.0, 0.0, 0.0)])
    corners = regions.feasible_forces(applied, BEAM)
    np.testing.assert_allclose(corners, np.broadcast_to([3.0, 1.0], corners.shape), atol=1e-6)
