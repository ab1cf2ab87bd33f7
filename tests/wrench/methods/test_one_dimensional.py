"""One-dimensional method (eq. 8) of two forces on a line."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput

BEAM = np.array([[-0.9, 0.0], [0.9, 0.0]])


def internal(applied, grips=BEAM):
    return wrench.decompose(applied, grips, method="one_dimensional").internal


@pytest.mark.parametrize(
    ("forces", "expected"), [((2, 0), 0), ((1, 1), 0), ((3, -1), 1), ((-1, 3), -1), ((-2, 2), -2)]
)
def test_equation_8(forces, expected):
    applied = np.array([[forces[0], 0, 0], [forces[1], 0, 0]])
    np.testing.assert_array_equal(internal(applied), [[expected, 0, 0], [-expected, 0, 0]])


@pytest.mark.parametrize("dimension", [2, 3])
def test_it_agrees_with_the_optimum_on_any_line(dimension):
    rng = np.random.default_rng(0)
    direction = rng.normal(size=dimension)
    grips = np.array([[-0.7], [0.4]]) * direction
    applied = np.zeros((20, 2, 3 * dimension - 3))
    applied[..., :dimension] = rng.normal(size=(20, 2, 1)) * direction
    optimal = wrench.decompose(applied, grips)
    np.testing.assert_allclose(internal(applied, grips), optimal.internal, atol=1e-7)


def test_grips_at_one_place_leave_the_line_to_the_forces():
    applied = [[[3.0, 6.0, 0.0], [-1.0, -2.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]]
    found = internal(applied, np.zeros((2, 2)))
    np.testing.assert_allclose(found[0, 0], [1.0, 2.0, 0.0])
    np.testing.assert_array_equal(found[1], 0.0)


def test_what_it_is_not_defined_for_is_refused():
    with pytest.raises(InvalidInput, match="grips must be two positions"):
        internal(np.zeros((3, 3)), np.eye(3, 2))
    with pytest.raises(InvalidInput, match=r"without torque .* got 2.0 N·m at index \(1, 0\)"):
        internal([[1.0, 0.0, 0.0], [1.0, 0.0, 2.0]])
    with pytest.raises(InvalidInput, match=r"on the line through both grips .* at index \(0, 1\)"):
        internal([[[1.0, 0.0, 0.0], [1.0, 0.1, 0.0]]])
