"""Densities and quadrants of load shares against closed forms."""

import numpy as np
import pytest

pytest.importorskip("scipy")

from scipy.special import ndtri

from coopenv.agents.studies.dyads.density import LoadDensity, Quadrants
from coopenv.errors import InvalidInput


def uniform(count: int) -> tuple[np.ndarray, np.ndarray]:
    """The midpoints of count × count cells of the unit square."""
    middle = (np.arange(count) + 0.5) / count
    force, torque = np.meshgrid(middle, middle)
    return force.ravel(), torque.ravel()


def normal(count: int, mean, deviation) -> tuple[np.ndarray, np.ndarray]:
    """Quantiles of two independent normal distributions."""
    force, torque = uniform(count)
    return mean[0] + deviation[0] * ndtri(force), mean[1] + deviation[1] * ndtri(torque)


def values(quadrants: Quadrants) -> list[float]:
    return [
        quadrants.dominant,
        quadrants.passive,
        quadrants.force_specialist,
        quadrants.torque_specialist,
    ]


def test_uniform_shares_have_density_one_everywhere_also_at_the_edges():
    found = LoadDensity.of(*uniform(32))
    assert found.share[[0, 1, -1]].tolist() == [0.0, 0.01, 1.0]
    assert found.density.shape == (101, 101)
    np.testing.assert_allclose(found.density, 1.0, atol=0.02)
    assert found.integral == pytest.approx(1.0, abs=1e-3)


def test_normal_shares_have_the_closed_form_of_a_kernel_density():
    mean, deviation, factor = (0.45, 0.6), (0.06, 0.09), 0.3
    found = LoadDensity.of(*normal(50, mean, deviation), bandwidth=factor)
    wide = np.sqrt(1 + factor**2) * np.array(deviation)  # a normal with a normal kernel
    bells = [
        np.exp(-(((found.share - m) / s) ** 2) / 2) / (s * np.sqrt(2 * np.pi))
        for m, s in zip(mean, wide, strict=True)
    ]
    expected = bells[0][:, None] * bells[1]
    np.testing.assert_allclose(found.density, expected, atol=0.02 * expected.max())
    assert found.integral == pytest.approx(1.0, abs=1e-4)


def test_shares_at_the_edge_lose_no_mass():
    generator = np.random.default_rng(0)
    force, torque = np.ones(400), generator.random(400)
    force[:40] = generator.random(40)
    found = LoadDensity.of(force, torque)
    assert found.integral == pytest.approx(1.0, abs=5e-3)
    assert np.unravel_index(found.density.argmax(), found.density.shape)[0] == 100


def test_weights_count_as_repetitions():
    force, torque = np.random.default_rng(1).random((2, 50))
    times = np.random.default_rng(2).integers(1, 5, 50)
    weighted = LoadDensity.of(force, torque, times, bandwidth=0.3)
    repeated = LoadDensity.of(np.repeat(force, times), np.repeat(torque, times), bandwidth=0.3)
    np.testing.assert_allclose(weighted.density, repeated.density, rtol=1e-9)
    again = Quadrants.of(np.repeat(force, times), np.repeat(torque, times))
    assert values(Quadrants.of(force, torque, times)) == pytest.approx(values(again))


def test_quadrants_of_a_mixture_are_its_weights():
    shares = {"dominant": (0.8, 0.7), "passive": (0.1, 0.2), "force_specialist": (0.9, 0.3)}
    duration = {"dominant": 5.0, "passive": 3.0, "force_specialist": 2.0}
    force, torque = np.transpose(list(shares.values()))
    found = Quadrants.of(force, torque, list(duration.values()))
    assert values(found) == pytest.approx([0.5, 0.3, 0.2, 0.0])


def test_quadrants_of_normal_shares_are_those_of_the_normal_distribution():
    # P(α_f > ½) = Φ(1) and P(α_t > ½) = Φ(−½) where the means are 1 and −½ deviations off ½.
    found = Quadrants.of(*normal(400, (0.6, 0.46), (0.1, 0.08)))
    above, torque_above = 0.8413447, 0.3085375
    assert found.dominant == pytest.approx(above * torque_above, abs=2e-3)
    assert found.passive == pytest.approx((1 - above) * (1 - torque_above), abs=2e-3)
    assert found.force_specialist == pytest.approx(above * (1 - torque_above), abs=2e-3)
    assert sum(values(found)) == pytest.approx(1.0)


def test_an_even_share_counts_half_to_either_side_and_nan_not_at_all():
    found = Quadrants.of([0.5, np.nan, 0.4], [1.0, 1.0, np.nan])
    assert values(found) == [0.5, 0.0, 0.0, 0.5]


@pytest.mark.parametrize(
    ("force", "torque", "message"),
    [
        ([np.nan], [0.2], "NaN only"),
        ([0.5, 0.5], [0.2], "one length"),
        ([1.5], [0.2], r"\[0, 1\]"),
    ],
)
def test_bad_shares_are_refused(force, torque, message):
    with pytest.raises(InvalidInput, match=message):
        Quadrants.of(force, torque)


def test_a_density_needs_spread_and_a_step_that_divides_one():
    with pytest.raises(InvalidInput, match="line or a point"):
        LoadDensity.of([0.1, 0.2, 0.3], [0.2, 0.4, 0.6])
    with pytest.raises(InvalidInput, match="line or a point"):
        LoadDensity.of([0.1], [0.2])
    on_line, hardly_there = [1.0, 1.0, 1.0], [1e-15]  # [s]
    with pytest.raises(InvalidInput, match="line or a point"):
        LoadDensity.of([0.1, 0.2, 0.3, 0.9], [0.2, 0.4, 0.6, 0.1], on_line + hardly_there)
    with pytest.raises(InvalidInput, match="divide 1"):
        LoadDensity.of(*uniform(5), step=0.3)
    with pytest.raises(InvalidInput, match="negative"):
        LoadDensity.of(*uniform(2), weights=[1, 1, -1, 1])


@pytest.mark.parametrize("share", [[-0.1, 0.5, 1.0], [0.0, 0.5, 1.1]])
def test_one_share_outside_of_0_to_1_is_refused(share):
    with pytest.raises(InvalidInput, match=r"must lie in \[0, 1\]"):
        Quadrants.of([0.2, 0.5, 0.8], share)
