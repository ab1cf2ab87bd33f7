"""Checks of a split of one's own: balance, plausibility, power, cost."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import wrench
from coopenv.errors import InvalidInput

BEAM = np.array([(-0.9, 0.0), (0.9, 0.0)])
POINT = np.zeros((3, 2))
TRIO = np.array([(3.0, 3.0, 0.0), (4.0, -1.0, 0.0), (-3.0, 0.0, 0.0)])  # the paper's Fig. 5
TRIO_MOVES = np.array([(3.0, 1.5, 0.0), (1.0, 0.5, 0.0), (0.0, 0.0, 0.0)])
CROSSING = np.array([(3.0, 1.0, 0.0), (-1.0, 2.0, 0.0)])


def test_what_decompose_finds_is_plausible_and_has_the_residuals_that_it_says():
    applied = np.random.default_rng(0).normal(size=(50, 2, 3))
    split = wrench.decompose(applied, BEAM)
    assert wrench.is_plausible(applied, split.internal, BEAM).all()
    own = wrench.residuals(applied, split.internal, BEAM)
    for mine, its in zip(own, split.residuals(), strict=True):
        np.testing.assert_allclose(mine, its, atol=1e-15)


def test_the_split_of_a_figure_is_judged():
    internal = TRIO - TRIO_MOVES
    assert wrench.is_plausible(TRIO, internal, POINT)
    least = wrench.decompose(TRIO, POINT, method="moore_penrose").internal
    assert not wrench.is_plausible(TRIO, least, POINT)
    assert wrench.residuals(TRIO, least, POINT).balance == pytest.approx(0.0, abs=1e-14)
    # f_I,3 = (−13/3, −2/3) N: its distance from the middle of (−3, 0), less the radius
    beyond = np.hypot(13 / 3 - 1.5, 2 / 3) - 1.5
    assert wrench.residuals(TRIO, least, POINT).force == pytest.approx(beyond)


def test_each_bound_is_told_by_itself():
    applied = np.array([(2.0, 0.0, 1.0), (-2.0, 0.0, -1.0)])
    unbalanced = np.array([(1.0, 0.0, 0.0), (-0.5, 0.0, 0.0)])
    assert wrench.residuals(applied, unbalanced, BEAM) == pytest.approx((0.5, 0.0, 0.0, 0.0))
    twice = np.array([(0.0, 0.0, 1.5), (0.0, 0.0, -1.5)])
    assert wrench.residuals(applied, twice, BEAM) == pytest.approx((0.0, 0.0, 0.0, 0.5))
    across = np.array([(1.0, 0.5, 0.0), (-1.0, -0.5, 0.9)])  # 0.45 + 0.45 N·m back as pure torque
    found = wrench.residuals(applied, across, BEAM)
    assert found.balance == pytest.approx(0.0, abs=1e-15)
    assert found.force == pytest.approx(0.0)
    assert found.induced_torque == pytest.approx(0.45)
    assert found.torque == pytest.approx(0.9)
    for internal in (unbalanced, twice, across):
        assert not wrench.is_plausible(applied, internal, BEAM)


@settings(max_examples=25)
@given(st.floats(1e-9, 1e9), st.integers(0, 1000))
def test_the_verdict_does_not_depend_on_the_unit(scale, seed):
    rng = np.random.default_rng(seed)
    applied = rng.normal(size=(20, 2, 3))
    fine = wrench.decompose(applied, BEAM).internal
    assert wrench.is_plausible(scale * applied, scale * fine, BEAM).all()
    wrong = wrench.decompose(applied, BEAM, method="nonsqueezing").internal
    verdict = wrench.is_plausible(applied, wrong, BEAM)
    scaled = wrench.is_plausible(scale * applied, scale * wrong, BEAM)
    np.testing.assert_array_equal(scaled, verdict)


@pytest.mark.parametrize("scale", [1e-320, 1e-200, 1e200])
def test_wrenches_whose_squares_are_no_numbers_are_judged_too(scale):
    applied = np.array([(3.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    squeeze = np.array([(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    assert wrench.is_plausible(scale * applied, scale * squeeze, BEAM)
    assert not wrench.is_plausible(scale * applied, 2 * scale * squeeze, BEAM)


def test_numbers_read_off_a_figure_pass_with_a_wider_tolerance():
    read = np.array([(0.0, 1.503, 0.0), (3.0, -1.502, 0.0), (-3.0, 0.0, 0.0)])
    assert not wrench.is_plausible(TRIO, read, POINT)
    assert wrench.is_plausible(TRIO, read, POINT, tolerance=1e-3)


def test_a_split_is_broadcast_against_what_was_applied():
    many = np.stack([TRIO, 2 * TRIO])
    verdict = wrench.is_plausible(many, TRIO - TRIO_MOVES, POINT)
    assert verdict.shape == (2,)
    assert verdict.all()  # half of the second is internal at most


def test_power_may_be_claimed_of_who_took_it():
    internal = wrench.decompose(CROSSING, np.zeros((2, 2)), method="point_mass").internal
    assert wrench.is_plausible(CROSSING, internal, np.zeros((2, 2)))
    found = wrench.work_residuals(CROSSING, internal, np.zeros((2, 2)), [1.0, -0.2, 0.0])
    # f_M,2 = 4/13 (2, 3) N gives 4/13 (2 − 0.6) W; applied were −1.4 W
    assert found.linear == pytest.approx(4 / 13 * 1.4)
    assert found.angular == 0.0


def test_power_of_turning_counts_the_torque_that_forces_induce():
    applied = np.array([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
    internal = np.array([(0.0, 1.0, 0.0), (0.0, -1.0, 1.8)])  # balances
    found = wrench.work_residuals(applied, internal, BEAM, [0.0, 0.0, 2.0])
    # effector 2: applied 2 W, manipulation r × (0, 1) + (1 − 1.8) = 0.1 N·m gives 0.2 W
    assert found.angular == pytest.approx(0.0)
    doubled = wrench.work_residuals(applied, -internal, BEAM, [0.0, 0.0, 2.0])
    # effector 1: −1.8 W were applied, −3.6 W are claimed
    assert doubled.angular == pytest.approx(1.8)


def test_what_was_applied_keeps_every_bound_of_power():
    rng = np.random.default_rng(1)
    applied, grips = rng.normal(size=(30, 3, 6)), rng.normal(size=(3, 3))
    found = wrench.work_residuals(applied, np.zeros((3, 6)), grips, rng.normal(size=(30, 6)))
    assert max(found.linear.max(), found.angular.max()) == 0.0
    everything = wrench.work_residuals(applied, applied, grips, rng.normal(size=(30, 6)))
    assert max(everything.linear.max(), everything.angular.max()) <= 1e-15


@pytest.mark.parametrize("include_induced", [False, True])
def test_cost_of_any_wrench_is_that_of_decompositions(include_induced):
    rng = np.random.default_rng(2)
    applied, grips = rng.normal(size=(4, 5, 2, 3)), rng.normal(size=(2, 2))
    weights = {"torque_weight": 0.3, "include_induced": include_induced}
    split = wrench.decompose(applied, grips, **weights)
    np.testing.assert_array_equal(wrench.cost(applied, grips, **weights), split.applied_cost)
    np.testing.assert_array_equal(wrench.cost(split.manipulation, grips, **weights), split.cost)


def test_cost_by_hand():
    given_wrench = [(3.0, 4.0, -2.0), (0.0, 0.0, 1.0)]
    assert wrench.cost(given_wrench, BEAM, torque_weight=0.25) == pytest.approx(0.75 * 5 + 0.25 * 3)
    induced = wrench.cost(given_wrench, BEAM, torque_weight=0.25, include_induced=True)
    assert induced == pytest.approx(0.75 * 5 + 0.25 * 3 + 0.25 * 0.9 * 4)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: wrench.residuals(TRIO, TRIO[:2], POINT), "internal must be of the shape of"),
        (lambda: wrench.is_plausible(TRIO, np.stack([TRIO] * 2), [POINT] * 3), "internal must be"),
        (lambda: wrench.residuals(TRIO, np.nan * TRIO, POINT), "internal must be finite"),
        (lambda: wrench.is_plausible(TRIO, TRIO, POINT, tolerance=-1.0), "tolerance must be"),
        (lambda: wrench.cost(TRIO, BEAM), "wrench must be of shape"),
        (lambda: wrench.cost(TRIO, POINT, torque_weight=1.0), "torque_weight must be in"),
        (lambda: wrench.work_residuals(TRIO, TRIO, POINT, [1.0, 0.0]), "twist must be of shape"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(ask, message):
    with pytest.raises(InvalidInput, match=message):
        ask()
