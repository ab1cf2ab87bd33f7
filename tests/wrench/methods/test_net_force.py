"""Net force method: forces split along and across the resultant."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput

BEAM = np.array([[-0.9, 0.0], [0.9, 0.0]])


def decompose(applied, grips=BEAM):
    return wrench.decompose(applied, grips, method="net_force")


def test_what_lies_across_the_resultant_is_internal():
    d = decompose([[1.0, 2.0, 0.0], [1.0, -2.0, 0.0]])
    np.testing.assert_array_equal(d.internal, [[0.0, 2.0, 0.0], [0.0, -2.0, 0.0]])


def test_pulling_against_the_resultant_counts_as_manipulation():
    d = decompose([[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(d.internal, np.zeros((2, 3)))


@pytest.mark.parametrize("dimension", [2, 3])
def test_forces_balance_but_their_moments_need_not(dimension):
    rng = np.random.default_rng(0)
    grips, applied = rng.normal(size=(4, dimension)), np.zeros((9, 4, 3 * dimension - 3))
    applied[..., :dimension] = rng.normal(size=(9, 4, dimension))
    d = decompose(applied, grips)
    np.testing.assert_allclose(d.internal.sum(axis=-2), 0.0, atol=1e-14)
    resultant = applied.sum(axis=-2, keepdims=True)
    np.testing.assert_allclose((d.internal * resultant).sum(axis=-1), 0.0, atol=1e-13)
    assert d.residuals().balance.max() > 0.1


def test_a_resultant_that_vanishes_leaves_all_internal():
    applied = np.array([[1.0, 2.0, 0.0], [-1.0, -2.0, 0.0]])
    np.testing.assert_array_equal(decompose(applied).internal, applied)
    np.testing.assert_array_equal(decompose(np.zeros((2, 3))).internal, np.zeros((2, 3)))


def test_grips_may_differ_from_sample_to_sample():
    applied = np.array([[1.0, 2.0, 0.0], [1.0, -2.0, 0.0]])
    assert decompose(applied, np.tile(BEAM, (4, 1, 1))).internal.shape == (4, 2, 3)


def test_torque_is_refused():
    with pytest.raises(InvalidInput, match="applied must be without torque for method='net_force'"):
        decompose([[1.0, 0.0, 0.0], [1.0, 0.0, 1e-9]])
