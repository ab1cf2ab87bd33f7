"""Close grips with the general solvers: what their bound says, and what only rounding parts."""

from functools import cache

import numpy as np
import pytest

from coopenv import wrench
from tests.wrench.pair.reference import least_cost
from tests.wrench.pair.test_close_grips import as_counted, cases

SEPARATIONS = (1e-17, 1e-16, 7e-15, 2e-12, 1e-9, 1e-6)  # [m]
GENERAL = ("structured", "conic")


@cache
def known(separation, directions):
    """Cases with what 60 digits make of them, as they are and at one place."""
    return [
        (
            name, applied, grips, weight, induced,
            least_cost(applied, as_counted(grips), weight, induced),
            least_cost(applied, np.tile(grips[0], (2, 1)), weight, induced),
        )
        for name, applied, grips, weight, induced in cases(0, separation, directions)
    ]  # fmt: skip


@pytest.mark.parametrize("solver", GENERAL)
@pytest.mark.parametrize("separation", SEPARATIONS)
@pytest.mark.parametrize("directions", ["any", "along"])
def test_the_bound_holds_from_above_and_what_is_below_is_of_one_place(
    directions, separation, solver
):
    # Closer than some 1e-9 m the torque that forces make of the distance is within rounding.
    for name, applied, grips, weight, induced, optimum, one_place in known(separation, directions):
        d = wrench.decompose(
            applied, grips, torque_weight=weight, include_induced=induced, solver=solver
        )
        assert d.cost - optimum <= d.gap + 1e-15 * d.applied_cost, name
        assert max(d.residuals()) <= 1e-11 * max(1.0, np.abs(applied).max()), name
        if directions == "any":  # along it, so are grips whose line only nearly meets the centre
            lowest = min(optimum, one_place) if separation <= 1e-9 else optimum
            assert d.cost >= lowest - (1e-9 + 2 * separation) * d.applied_cost, name
