"""Virtual linkage: internal forces along the lines between effectors."""

import numpy as np
import pytest

from coopenv import wrench


def internal(applied, grips):
    return wrench.decompose(applied, grips, method="virtual_linkage").internal


def test_only_the_force_along_the_line_is_internal_and_every_torque():
    found = internal([[3.0, 5.0, 2.0], [-1.0, 7.0, 4.0]], [[-0.9, 0.0], [0.9, 0.0]])
    np.testing.assert_allclose(found, [[2.0, 0.0, 2.0], [-2.0, 0.0, 4.0]], atol=1e-12)


def test_three_effectors_squeeze_along_three_lines():
    grips = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])
    inwards = np.concatenate([-grips, np.zeros((3, 1))], axis=1)
    np.testing.assert_allclose(internal(inwards, grips), inwards, atol=1e-12)
    together = np.tile([2.0, 1.0, 0.0], (3, 1))
    np.testing.assert_allclose(internal(together, grips), 0.0, atol=1e-12)


@pytest.mark.parametrize("apart", [1e-3, 1e-18])  # [m]
def test_a_line_carries_force_however_short_it_is(apart):
    grips = [[0.0, 0.0], [0.0, apart], [1.0, 0.0]]
    applied = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]
    np.testing.assert_allclose(internal(applied, grips), applied, atol=1e-12)


def test_effectors_at_the_same_place_have_no_line_between_them():
    found = internal([[1.0, 2.0, 0.0], [-1.0, -2.0, 0.0]], [[0.5, 0.0], [0.5, 0.0]])
    np.testing.assert_array_equal(found, np.zeros((2, 3)))


@pytest.mark.parametrize(("num_effectors", "dimension"), [(4, 2), (9, 2), (4, 3), (9, 3), (40, 2)])
def test_the_lines_between_all_pairs_carry_every_force_that_balances(num_effectors, dimension):
    # more lines than they can carry independently: E has dependent columns
    rng = np.random.default_rng(num_effectors)
    grips = rng.normal(size=(num_effectors, dimension))
    applied = np.zeros((5, num_effectors, 3 * dimension - 3))
    applied[..., :dimension] = rng.normal(size=(5, num_effectors, dimension))
    d = wrench.decompose(applied, grips, method="virtual_linkage")
    np.testing.assert_allclose(wrench.object_wrench(d.internal, grips), 0.0, atol=1e-10)
    again = wrench.decompose(d.internal, grips, method="virtual_linkage")
    np.testing.assert_allclose(again.internal, d.internal, atol=1e-10)
    rank = num_effectors * dimension - 3 * (dimension - 1)  # all that balance
    matrix = wrench.grasp_matrix(grips).reshape(-1, num_effectors, 3 * dimension - 3)
    forces = matrix[..., :dimension].reshape(len(matrix), -1)
    balanced = np.eye(num_effectors * dimension) - np.linalg.pinv(forces) @ forces
    assert np.linalg.matrix_rank(balanced, tol=1e-8) == rank
    expected = applied[..., :dimension].reshape(5, -1) @ balanced
    np.testing.assert_allclose(d.internal[..., :dimension].reshape(5, -1), expected, atol=1e-10)
