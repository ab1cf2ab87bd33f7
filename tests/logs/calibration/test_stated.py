"""Numbers of a layout's tables: how many, and how large."""

import pytest

from coopenv.errors import InvalidInput
from coopenv.logs.calibration.stated import LARGEST, square, vector


def test_the_largest_number_is_still_allowed_and_one_beyond_is_not():
    assert vector([LARGEST, 0.0], "offset") == (LARGEST, 0.0)
    assert square([[LARGEST, 0.0], [0.0, 1.0]], "rotation", [2]) == ((LARGEST, 0.0), (0.0, 1.0))
    for made in (
        lambda: vector([1.001 * LARGEST, 0.0], "offset"),
        lambda: square([[-1.001 * LARGEST, 0.0], [0.0, 1.0]], "rotation", [2]),
    ):
        with pytest.raises(InvalidInput, match="must be at most"):
            made()


@pytest.mark.parametrize("rows", [[[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]], [[1.0, 0.0, 0.0]] * 2])
def test_a_matrix_that_is_not_square_is_refused(rows):
    with pytest.raises(
        InvalidInput, match="rotation must be a matrix of 2 by 2 or 3 by 3, got shape"
    ):
        square(rows, "rotation", [2, 3])
