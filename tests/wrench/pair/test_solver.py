"""Any two planar effectors: who answers, alone and in batches, and what is refused."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput
from tests.wrench.cases import pair_families

BEAM, BENT = np.array([[-0.9, 0.0], [0.9, 0.0]]), np.array([[0.8, 0.3], [-0.5, 0.9]])


def solve(applied, grips, solver="pair", **settings):
    return wrench.decompose(applied, grips, solver=solver, **settings)


@pytest.mark.parametrize("grips", [BEAM, BENT, [BEAM, BENT]])
def test_every_planar_pair_is_answered_as_by_default(grips):
    applied = np.random.default_rng(0).normal(size=(2, 2, 3))
    named, default = solve(applied, grips), wrench.decompose(applied, grips)
    assert named.solver == default.solver == "pair"
    np.testing.assert_array_equal(named.manipulation, default.manipulation)
    np.testing.assert_array_equal(named.gap, default.gap)
    assert not named.fell_back.any()


def test_pairs_on_and_off_the_axis_mix_in_a_batch():
    applied = np.random.default_rng(6).normal(size=(40, 2, 3))
    grips = np.where(np.arange(40)[:, None, None] % 2, BENT, BEAM)
    d = solve(applied, grips)
    for k in range(40):
        alone = solve(applied[k], grips[k])
        np.testing.assert_array_equal(d.manipulation[k], alone.manipulation)
        assert d.gap[k] == alone.gap
        assert d.gap[k] <= 1e-14 * d.applied_cost[k]


def test_mixed_grips_broadcast_against_wrenches():
    applied = np.random.default_rng(7).normal(size=(5, 1, 2, 3))
    d = solve(applied, [BEAM, BENT])
    assert d.manipulation.shape == (5, 2, 2, 3)
    assert d.gap.shape == d.fell_back.shape == (5, 2)
    for k, grips in enumerate((BEAM, BENT)):
        alone = solve(applied[:, 0], grips)
        np.testing.assert_array_equal(d.manipulation[:, k], alone.manipulation)


@pytest.mark.parametrize("include_induced", [False, True])
def test_the_structured_method_finds_the_same_cost_off_the_axis(include_induced):
    rng = np.random.default_rng(8)
    for torque_weight in (0.05, 0.5, 0.95):
        cost = {"torque_weight": torque_weight, "include_induced": include_induced}
        for name, applied in pair_families(rng, 100).items():
            grips = rng.normal(size=(len(applied), 2, 2))
            exact, other = (
                solve(applied, grips, **cost),
                solve(applied, grips, "structured", **cost),
            )
            assert other.solver == "structured"
            unit = np.maximum(exact.applied_cost, 1e-300)
            allowed = (exact.gap + other.gap) / unit + 1e-14
            assert (np.abs(exact.cost - other.cost) / unit <= allowed).all(), name
            assert (other.gap / unit).max() <= (1e-6 if name == "nearly parallel" else 1e-8), name


@pytest.mark.parametrize(
    "grips",
    [
        [[-0.9, 0.0], [0.9, 0.0], [0.0, 0.0]],
        [[-0.9, 0.0, 0.0], [0.9, 0.0, 0.0]],
        [[0.3, 0.4]],
    ],
)
def test_other_grips_are_refused(grips):
    with pytest.raises(InvalidInput, match=r"grips must be two planar .* use solver='structured'"):
        wrench.Decomposer(grips, wrench.Settings(solver="pair"))
