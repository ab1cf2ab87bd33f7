"""Weak duality: whatever the multipliers, no plausible wrench saves more than the bound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import wrench
from coopenv.wrench.conic.bound import Bound, Duals, best_bound, bounded, default_duals
from coopenv.wrench.conic.parts import Parts, Prices, cost_of, parts_of, saving_of
from tests.wrench.structured.cases import GRIPS, families, grips_of_kind

PRICES = (Prices(0.5, 0.5, 0.0), Prices(0.5, 0.5, 0.5), Prices(0.05, 0.95, 0.95))


def largest_saving(applied, grips, weights):
    """What an answer that is balanced and in every ball to rounding saves, relative to J(h)."""
    d = wrench.decompose(
        applied,
        grips,
        torque_weight=weights.torque,
        include_induced=weights.induced > 0,
    )
    whole = parts_of(applied, np.broadcast_to(grips, (len(applied), *grips.shape)))
    internal = parts_of(d.internal, np.broadcast_to(grips, (len(applied), *grips.shape)))
    return whole, saving_of(internal, whole, weights)


def random_duals(rng, whole, scale):
    def noise(shape):
        return scale * rng.normal(size=shape) * 10.0 ** rng.uniform(-3, 3, size=(len(shape) * [1]))

    size = whole.force.shape[-1] + whole.torque.shape[-1]
    return Duals(
        noise((len(whole.force), size)),
        noise(whole.force.shape),
        noise(whole.torque.shape),
        noise(whole.torque.shape),
        noise(whole.torque.shape),
    )


@given(
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(1, 5),
    dimension=st.sampled_from([2, 3]),
    kind=st.sampled_from(GRIPS),
    weights=st.sampled_from(PRICES),
)
@settings(max_examples=20, deadline=None)
def test_any_multipliers_bound_what_can_be_saved(seed, n, dimension, kind, weights):
    rng = np.random.default_rng(seed)
    grips = grips_of_kind(rng, kind, n, dimension)
    for name, applied in families(rng, 2, n, dimension).items():
        whole, saved = largest_saving(applied, grips, weights)
        cost = cost_of(whole, weights)
        places = np.broadcast_to(grips, (len(applied), *grips.shape))
        for duals in (
            default_duals(whole, weights),
            random_duals(rng, whole, 1.0),
            random_duals(rng, whole, 1e-3),
            random_duals(rng, whole, 1e3),
        ):
            for bound in (
                bounded(whole, places, weights, duals),
                best_bound(whole, places, weights, duals),
            ):
                # 1e-7: what rounding of a thin set is worth to the other solver
                assert (saved <= bound.shortfall + 1e-7 * cost).all(), name


def test_a_pair_that_pulls_apart_is_bounded_exactly():
    # (3, −1) on a line: 1 N is compensated, which saves 1 N of cost at each end, J = 4 → 2
    applied = np.array([[[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]])
    grips = np.array([[[-1.0, 0.0], [1.0, 0.0]]])
    weights = Prices(1.0, 1.0, 0.0)
    whole = parts_of(applied, grips)
    duals = default_duals(whole, weights)
    duals.balance[:] = [1.0, 0.0, 0.0]
    assert bounded(whole, grips, weights, duals).shortfall == pytest.approx(2.0, rel=1e-15)
    duals.balance[:] = [0.5, 0.0, 0.0]
    assert bounded(whole, grips, weights, duals).shortfall > 2.0


def test_costs_are_cut_down_where_multipliers_exceed_them():
    rng = np.random.default_rng(0)
    applied, grips = rng.normal(size=(4, 3, 6)), rng.normal(size=(4, 3, 3))
    whole, weights = parts_of(applied, grips), PRICES[1]
    duals = default_duals(whole, weights)
    for factor in (1.0, 5.0):
        longer = duals._replace(force=factor * duals.force, torque=factor * duals.torque)
        found = bounded(whole, grips, weights, longer).shortfall
        np.testing.assert_allclose(found, bounded(whole, grips, weights, duals).shortfall)


def test_where_forces_agree_to_rounding_next_to_nothing_can_be_saved():
    rng = np.random.default_rng(1)
    force = rng.random((20, 4, 1)) * rng.normal(size=(20, 1, 3))
    applied = np.concatenate([force, np.zeros((20, 4, 3))], axis=-1)
    grips, weights = np.broadcast_to(rng.normal(size=(4, 3)), (20, 4, 3)), PRICES[0]
    whole = parts_of(applied, grips)
    nothing = Duals(*(np.zeros_like(values) for values in default_duals(whole, weights)))
    cost = cost_of(whole, weights)
    assert (bounded(whole, grips, weights, nothing).shortfall >= 0.9 * cost).all()
    assert (best_bound(whole, grips, weights, nothing).shortfall <= 1e-14 * cost).all()


def test_a_bound_says_what_leaving_balance_and_balls_is_worth():
    applied = np.array([[[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]])
    grips = np.zeros((1, 2, 2))
    whole, weights = parts_of(applied, grips), Prices(1.0, 1.0, 0.0)
    duals = default_duals(whole, weights)
    duals.balance[:] = [1.0, 0.0, 0.0]
    bound = bounded(whole, grips, weights, duals)
    assert isinstance(bound, Bound)
    assert isinstance(bound.balls, Parts)
    np.testing.assert_array_equal(bound.balance, [[1.0, 0.0, 0.0]])
    np.testing.assert_array_equal(bound.balls.force, [[0.0, 2.0]])
