"""The kernel for usual samples, and the one for all of which it leaves some to the other."""

import numpy as np
import pytest

from coopenv.wrench.settings import Settings
from coopenv.wrench.structured import solver as structured
from coopenv.wrench.structured.batch import ITERATIONS, REPORT, memory_for
from tests.wrench.structured.cases import GRIPS, families, grips_of_kind


def solved(kernel, applied, grips, include_induced):
    """Manipulation wrenches and report of a kernel alone."""
    manipulation, report = np.empty(applied.shape), np.empty((len(applied), REPORT))
    memory = memory_for(applied.shape[1])
    kernel(
        applied, grips[None].copy(), 0.5, float(include_induced), 1e-9, manipulation, report, memory
    )
    return manipulation, report


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_usual_is_answered_to_the_bits_of_the_kernel_for_all(dimension, include_induced):
    rng = np.random.default_rng(dimension)
    usual, special = 0, 0
    for n in (2, 3, 5):
        for k, applied in enumerate(families(rng, 4, n, dimension).values()):
            grips = grips_of_kind(rng, GRIPS[k % len(GRIPS)], n, dimension)
            mine, told = solved(structured.solve_usual, applied, grips, include_induced)
            whole, report = solved(structured.solve_batch, applied, grips, include_induced)
            is_usual = told[:, ITERATIONS] >= 0
            usual, special = usual + is_usual.sum(), special + (~is_usual).sum()
            np.testing.assert_array_equal(mine[is_usual], whole[is_usual])
            np.testing.assert_array_equal(told[is_usual], report[is_usual])
            settings = Settings(include_induced=include_induced)
            both, reported = structured.iterate(applied, grips[None], settings)
            np.testing.assert_array_equal(both, whole)
            np.testing.assert_array_equal(reported, report)
    assert usual > special > 0
