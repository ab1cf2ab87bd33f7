"""Keyed random numbers."""

import numpy as np
import pytest
from scipy import stats

from coopenv.chance import Chance, draw_keys, normal, polar_normal


def test_a_key_is_the_next_number_of_its_worlds_generator():
    generators = [np.random.default_rng(seed) for seed in range(3)]
    keys = draw_keys([*generators, None], np.array([2, 0]))
    wanted = [np.random.default_rng(seed).integers(2**64, dtype=np.uint64) for seed in (2, 0)]
    np.testing.assert_array_equal(keys, np.array(wanted))


def test_chance_is_uniform_and_its_branches_are_independent():
    chance = Chance(np.arange(20_000, dtype=np.uint64))
    names = ("offset", "turn", "noise14", "noise15")
    numbers = [chance.uniform(name) for name in names]
    numbers += [chance.branch("first").uniform("offset"), chance.branch("second").uniform("offset")]
    for drawn in numbers:
        assert (drawn >= 0).all()
        assert (drawn < 1).all()
        np.testing.assert_allclose(np.histogram(drawn, 10, (0, 1))[0] / 20_000, 0.1, atol=0.012)
    between = np.corrcoef(numbers) - np.eye(len(numbers))
    assert np.abs(between).max() < 0.03


def test_a_keys_normal_number_is_the_quantile_of_its_uniform_one():
    generator = np.random.default_rng(0)
    keys = generator.integers(2**64, size=2000, dtype=np.uint64)
    rare = np.uint64(1) << np.arange(13, 64, dtype=np.uint64)  # down to a chance of 2⁻⁵²
    for key in np.concatenate([keys, rare, ~rare, [np.uint64(0), np.uint64(2**64 - 1)]]):
        count = int(key) >> 12
        below, above = (count + 0.5) / 2**52, (2**52 - count - 0.5) / 2**52
        wanted = stats.norm.ppf(below) if below < 0.5 else stats.norm.isf(above)
        assert normal(key) == pytest.approx(wanted, rel=1e-6, abs=1e-7)


def test_polar_normals_of_keys_are_normal():
    keys = Chance(np.arange(5000, dtype=np.uint64)).branch("polar").keys
    drawn = [polar_normal(key) for key in keys]
    assert stats.kstest(drawn, "norm").pvalue > 0.01
