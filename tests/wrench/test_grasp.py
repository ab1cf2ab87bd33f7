"""Grasp matrix, object wrench and induced torque."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput


def test_planar_grasp_matrix_sums_forces_and_moments():
    matrix = wrench.grasp_matrix([[2.0, 3.0], [-1.0, 0.5]])
    assert matrix.shape == (3, 6)
    np.testing.assert_array_equal(
        matrix,
        [[1, 0, 0, 1, 0, 0], [0, 1, 0, 0, 1, 0], [-3, 2, 1, -0.5, -1, 1]],
    )


def test_spatial_grasp_matrix_holds_cross_products():
    rng = np.random.default_rng(0)
    grips, applied = rng.normal(size=(4, 3)), rng.normal(size=(4, 6))
    force, torque = applied[:, :3].sum(0), applied[:, 3:].sum(0)
    expected = np.concatenate([force, torque + np.cross(grips, applied[:, :3]).sum(0)])
    np.testing.assert_allclose(wrench.grasp_matrix(grips) @ applied.ravel(), expected, atol=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
def test_object_wrench_is_grasp_matrix_times_applied_for_any_batch(dimension):
    rng = np.random.default_rng(1)
    grips = rng.normal(size=(5, 3, dimension))
    applied = rng.normal(size=(7, 5, 3, 3 * dimension - 3))
    flat = applied.reshape(7, 5, -1, 1)
    expected = (wrench.grasp_matrix(grips) @ flat)[..., 0]
    np.testing.assert_allclose(wrench.object_wrench(applied, grips), expected, atol=1e-13)


@pytest.mark.parametrize("dimension", [2, 3])
def test_induced_torque_is_the_moment_of_the_force(dimension):
    rng = np.random.default_rng(2)
    grips, applied = rng.normal(size=(3, dimension)), rng.normal(size=(4, 3, 3 * dimension - 3))
    spatial_grips, spatial_force = np.zeros((3, 3)), np.zeros((4, 3, 3))
    spatial_grips[:, :dimension], spatial_force[..., :dimension] = grips, applied[..., :dimension]
    expected = np.cross(spatial_grips, spatial_force)[..., (2 if dimension == 2 else 0) :]
    np.testing.assert_allclose(wrench.induced_torque(applied, grips), expected, atol=1e-14)


@pytest.mark.parametrize("grips", [[1.0, 2.0], [[1.0]], np.zeros((0, 2)), np.zeros((2, 4)), 3.0])
def test_grips_of_another_shape_are_refused(grips):
    with pytest.raises(InvalidInput, match=r"grips must be of shape \(\.\.\., n, 2\)"):
        wrench.grasp_matrix(grips)


def test_grips_that_are_not_finite_are_refused():
    with pytest.raises(InvalidInput, match=r"grips must be finite, got nan at index \(1, 0\)"):
        wrench.grasp_matrix([[0.0, 1.0], [np.nan, 0.0]])


def test_applied_must_match_the_grips():
    grips = [[-0.9, 0.0], [0.9, 0.0]]
    with pytest.raises(InvalidInput, match=r"applied must be of shape \(\.\.\., 2, 3\)"):
        wrench.object_wrench(np.zeros((3, 3)), grips)
    with pytest.raises(InvalidInput, match=r"applied must be of shape \(\.\.\., 2, 3\)"):
        wrench.induced_torque(np.zeros((2, 6)), grips)
    with pytest.raises(InvalidInput, match="broadcasts against that of grips"):
        wrench.object_wrench(np.zeros((4, 2, 3)), np.zeros((5, 2, 2)))
