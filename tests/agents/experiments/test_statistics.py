"""Statistics of a few runs: published values, SciPy's, and what is worked out by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import mannwhitneyu, trim_mean

from coopenv.agents.experiments.report.statistics import (
    bootstrap_interval,
    interquartile_mean,
    mean,
    optimality_gap,
    pareto_front,
    performance_profile,
    probability_of_improvement,
    scores_of,
)
from coopenv.errors import InvalidInput

NUMBERS = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=12)
X = [np.array([1.0, 2.0, 1.0, 2.0]), np.array([2.0, 2.0, 1.0, 1.0])]  # four runs of two problems
Y = [np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0])]


def test_the_interquartile_mean_of_a_textbook_example():
    values = [5, 8, 4, 38, 8, 6, 9, 7, 7, 3, 1, 6]
    assert interquartile_mean(scores_of([values])) == pytest.approx(6.5)


def test_aggregates_of_the_small_matrices_of_the_reference_implementation():
    assert interquartile_mean(X) == 1.5
    assert mean(X) == 1.5
    assert interquartile_mean(Y) == 2.0
    assert probability_of_improvement(X, Y) == pytest.approx(1 / 3)


def test_the_probability_of_improvement_in_the_race_of_tortoises_and_hares():
    """Mann and Whitney's U is 11 of 36 for the tortoises: T H H H H H T T T T T H."""
    order = "THHHHHTTTTTH"
    places = {who: [-float(k) for k, each in enumerate(order) if each == who] for who in "TH"}
    tortoises, hares = scores_of([places["T"]]), scores_of([places["H"]])
    assert probability_of_improvement(tortoises, hares) == pytest.approx(11 / 36)
    assert probability_of_improvement(hares, tortoises) == pytest.approx(25 / 36)


@settings(max_examples=25)
@given(NUMBERS)
def test_the_interquartile_mean_is_the_trimmed_mean(values):
    found = interquartile_mean(scores_of([values]))
    assert found == pytest.approx(trim_mean(values, 0.25), abs=1e-9)


@settings(max_examples=25)
@given(NUMBERS, NUMBERS)
def test_the_probability_of_improvement_is_u_over_the_pairs(mine, others):
    u = mannwhitneyu(mine, others).statistic
    found = probability_of_improvement(scores_of([mine]), scores_of([others]))
    assert found == pytest.approx(u / (len(mine) * len(others)))


def test_problems_weigh_alike_in_the_probability_however_many_runs_they_have():
    mine = scores_of([[1.0], [0.0, 0.0, 0.0]])
    assert probability_of_improvement(mine, scores_of([[0.0], [1.0]])) == 0.5


def test_a_profile_is_the_part_of_the_runs_above_a_threshold():
    scores = scores_of([[0.0, 0.5], [0.5, 1.0]])
    found = performance_profile(scores, np.array([-0.1, 0.0, 0.5, 0.9, 1.0]))
    np.testing.assert_array_equal(found, [1.0, 0.75, 0.25, 0.25, 0.0])


def test_the_optimality_gap_counts_no_excess():
    assert optimality_gap(scores_of([[0.5, 2.0]])) == 0.25


def test_an_interval_of_equal_runs_is_a_point_within_each_problem():
    low, high = bootstrap_interval(interquartile_mean, scores_of([[0.0] * 4, [1.0] * 4]))
    assert low == high == 0.5  # without strata it would not be


def test_an_interval_of_a_mean_is_that_of_theory():
    """For many runs the percentile interval of a mean is ±1.96 standard errors."""
    runs = np.random.default_rng(1).normal(3.0, 2.0, 400)
    low, high = bootstrap_interval(mean, [runs], resamples=4000)
    half = 1.96 * runs.std() / np.sqrt(len(runs))
    np.testing.assert_allclose([low, high], runs.mean() + np.array([-half, half]), atol=0.02)


def test_an_interval_covers_the_truth_about_as_often_as_it_says():
    generator = np.random.default_rng(0)
    covered = 0
    for trial in range(200):
        runs = generator.normal(size=30)
        low, high = bootstrap_interval(mean, [runs], resamples=300, seed=trial)
        covered += low <= 0.0 <= high
    assert 0.88 <= covered / 200 <= 0.98


def test_the_same_runs_give_the_same_interval():
    assert bootstrap_interval(mean, X) == bootstrap_interval(mean, X)


def test_the_front_holds_what_nothing_else_is_better_than():
    points = np.array([[1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [3.0, 3.0], [2.0, 2.0], [1.0, 4.0]])
    assert pareto_front(points) == [0, 1, 2, 4]


@pytest.mark.parametrize("values", [[], [[]], [[1.0, np.nan]], [[1.0], [np.inf]]])
def test_scores_that_say_nothing_are_refused(values):
    with pytest.raises(InvalidInput, match="scores must"):
        scores_of(values)


@pytest.mark.parametrize("confidence", [0.0, 1.0, -1.0, np.nan])
def test_a_confidence_beyond_its_range_is_refused(confidence):
    with pytest.raises(InvalidInput, match="confidence must be"):
        bootstrap_interval(mean, X, confidence=confidence)


def test_different_problems_are_not_compared():
    with pytest.raises(InvalidInput, match="same problems"):
        probability_of_improvement(X, Y[:1])


def test_the_optimality_gap_of_a_curve_is_that_of_each_of_its_points():
    curve = np.array([[0.0, 0.5], [1.0, 2.0], [0.5, 0.5]])  # (point, run)
    np.testing.assert_allclose(optimality_gap([curve]), [0.75, 0.0, 0.5])
