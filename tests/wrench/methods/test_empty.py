"""No samples: every method and solver answers with nothing, or refuses as it does some samples."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput

SHAPES = [  # batches of grips and of wrenches; none, or one for all
    ((0,), (0,)),
    ((), (0,)),
    ((0,), ()),
    ((0,), (1,)),
    ((), (3, 0)),
    ((0,), (2, 0)),
]


def grips(batch, num_effectors, dimension):
    """Those of a balanced team, so that methods which need one take it."""
    angle = 2 * np.pi * np.arange(num_effectors) / num_effectors
    places = np.stack([np.cos(angle), np.sin(angle), np.zeros(num_effectors)], axis=-1)
    return np.broadcast_to(places[:, :dimension], (*batch, num_effectors, dimension))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("num_effectors", [1, 2, 3, 5])
@pytest.mark.parametrize("solver", ["auto", *wrench.SOLVERS])
@pytest.mark.parametrize("method", wrench.METHODS)
def test_an_empty_batch_has_an_empty_answer(method, solver, num_effectors, dimension):
    settings = {"method": method, "solver": solver}
    size = 3 * (dimension - 1)
    for of_grips, of_wrenches in SHAPES:
        held = grips(of_grips, num_effectors, dimension)
        applied = np.zeros((*of_wrenches, num_effectors, size))
        batch = np.broadcast_shapes(of_grips, of_wrenches)
        try:
            split = wrench.Decomposer(held, wrench.Settings(**settings))(applied)
        except InvalidInput:  # of such grips, empty or not
            with pytest.raises(InvalidInput):
                wrench.Decomposer(grips((), num_effectors, dimension), wrench.Settings(**settings))
            continue
        assert split.manipulation.shape == (*batch, num_effectors, size)
        for measure in (split.cost, split.gap, split.relative_cost, split.wasted_cost):
            assert np.shape(measure) == batch
        assert split.residuals().balance.shape == batch
        assert split.load_share.force.shape == (*batch, num_effectors)
        twist = np.zeros((*batch, size))
        assert split.energy_share(twist).total.shape == (*batch, num_effectors)


@pytest.mark.parametrize("method", ["moore_penrose", "nonsqueezing", "parametrized"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_allocation_to_an_empty_batch_is_empty(method, dimension):
    size = 3 * (dimension - 1)
    for of_grips in ((), (0,)):
        shares = wrench.allocate(np.zeros((0, size)), grips(of_grips, 3, dimension), method)
        assert shares.shape == (0, 3, size)
