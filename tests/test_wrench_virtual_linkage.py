import numpy as np

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


def test_effectors_at_the_same_place_have_no_line_between_them():
    found = internal([[1.0, 2.0, 0.0], [-1.0, -2.0, 0.0]], [[0.5, 0.0], [0.5, 0.0]])
    np.testing.assert_array_equal(found, np.zeros((2, 3)))
