"""Answers that are nearly plausible, made plausible at next to no cost."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.wrench.answer import Answer
from coopenv.wrench.conic.feasible import plausible, with_torques_shared
from coopenv.wrench.conic.parts import Prices, cost_of, parts_of
from tests.wrench.structured.cases import families, grips_of_kind

PRICES = Prices(0.5, 0.5, 0.0)


def mended(internal, applied, grips):
    places = np.broadcast_to(grips, (len(applied), *grips.shape)).copy()
    unlimited = np.full(len(applied), np.inf)
    found, saved, _ = plausible(internal, applied, places, PRICES, unlimited)
    decomposer = wrench.Decomposer(grips, wrench.Settings(solver="conic"))
    cost = cost_of(parts_of(applied, places), PRICES)
    return wrench.Decomposition(applied, Answer(applied - found), decomposer), saved, cost


def relative_residuals(d):
    scale = np.abs(d.applied).max(axis=(-2, -1)) * max(1.0, np.abs(d.grips).max())
    return np.max(d.residuals(), axis=0) / np.where(scale > 0, scale, 1.0)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("noise", [1e-12, 1e-9, 1e-6])
def test_noisy_answers_come_back_to_rounding(dimension, noise):
    rng = np.random.default_rng(0)
    for n in (2, 3, 5):
        grips = grips_of_kind(rng, "scattered", n, dimension)
        applied = rng.normal(size=(40, n, 3 * dimension - 3))
        exact = wrench.decompose(applied, grips)
        noisy = exact.internal + noise * rng.normal(size=applied.shape)
        d, saved, cost = mended(noisy, applied, grips)
        assert relative_residuals(d).max() <= 1e-14
        np.testing.assert_allclose(d.applied_cost - d.cost, saved, atol=1e-14 * cost.max())
        lost = (d.cost - exact.cost) / cost
        assert np.median(lost) <= 3.0 * noise
        assert lost.min() >= -2e-9  # the other solver's own tolerance


@pytest.mark.parametrize("dimension", [2, 3])
def test_whatever_is_given_comes_back_plausible(dimension):
    rng = np.random.default_rng(1)
    for n in (1, 3):
        grips = grips_of_kind(rng, "integer", n, dimension)
        for name, applied in families(rng, 5, n, dimension).items():
            d, saved, _ = mended(rng.normal(size=applied.shape), applied, grips)
            assert relative_residuals(d).max() <= 1e-13, name
            assert (saved >= -1e-15 * d.applied_cost).all(), name


def test_a_sample_is_mended_alike_alone_and_beside_others():
    rng = np.random.default_rng(2)
    grips, applied = rng.normal(size=(3, 3)), rng.normal(size=(12, 3, 6))
    internal = 0.5 * applied + 0.1 * rng.normal(size=applied.shape)
    together = mended(internal, applied, grips)[0].manipulation
    for i in range(len(applied)):
        alone = mended(internal[i : i + 1], applied[i : i + 1], grips)[0].manipulation
        np.testing.assert_array_equal(alone[0], together[i])


def test_torques_are_shared_along_their_sum():
    applied = np.array([[[1.0, 0.0, 3.0], [2.0, 0.0, -1.0], [0.0, 5.0, 1.0]]])
    shared = with_torques_shared(applied, 2)
    np.testing.assert_allclose(shared[0, :, 2], [2.25, 0.0, 0.75], rtol=1e-15)
    np.testing.assert_array_equal(shared[..., :2], applied[..., :2])
