"""Point mass approximation: shares along the resultants."""

import numpy as np
import pytest

from coopenv import wrench

BEAM = [[-0.9, 0.0], [0.9, 0.0]]


def test_forces_are_shared_along_their_resultant():
    d = wrench.decompose([[3.0, 1.0, 0.0], [-1.0, -1.0, 0.0]], BEAM, method="point_mass")
    np.testing.assert_allclose(d.manipulation[:, :2], [[2.0, 0.0], [0.0, 0.0]], atol=1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_torques_are_shared_at_the_centre_of_mass(dimension):
    rng = np.random.default_rng(0)
    grips, applied = rng.normal(size=(3, dimension)), rng.normal(size=(9, 3, 3 * dimension - 3))
    d = wrench.decompose(applied, grips, method="point_mass")
    at_centre = d.manipulation[..., dimension:] + wrench.induced_torque(d.manipulation, grips)
    resultant = d.object_wrench[:, None, dimension:]
    np.testing.assert_allclose(at_centre, d.load_share.torque[..., None] * resultant, atol=1e-12)
    assert d.residuals().balance.max() <= 1e-12


def test_a_resultant_that_vanishes_leaves_nothing_to_share():
    d = wrench.decompose([[1.0, 0.0, 2.0], [-1.0, 0.0, -2.0]], BEAM, method="point_mass")
    np.testing.assert_array_equal(d.manipulation, np.zeros((2, 3)))
