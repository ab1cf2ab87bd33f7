"""What is shared among threads is what one thread makes of it, whatever the shapes."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.compiled.parallel import shared

COUNT = 600


@pytest.mark.parametrize(
    "grips", [(2, 2), (COUNT, 2, 2), (3, 1, 2, 2), (3, COUNT, 2, 2), (1, 2, 2)]
)
def test_pairs_on_a_line_broadcast_alike_with_any_number_of_threads(grips):
    rng = np.random.default_rng(0)
    applied, along = rng.normal(size=(COUNT, 2, 3)), np.zeros(grips)
    along[..., 0, 0], along[..., 1, 0] = -rng.uniform(0.5, 1.0), rng.uniform(0.5, 1.0)
    decomposer = wrench.Decomposer(along)
    with shared(1):
        one = decomposer(applied).manipulation
    with shared(2):
        many = decomposer(applied).manipulation
    np.testing.assert_array_equal(one, many)
