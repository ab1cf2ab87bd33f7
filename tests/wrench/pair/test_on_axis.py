"""The exact solver: feasible, not to be beaten, and where costs tie as we say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import wrench
from coopenv.wrench.answer import Answer
from tests.wrench.cases import (
    LEVERS,
    angles,
    feasible_internal,
    grips_on_line,
    levers,
    pair_cases,
    pair_wrenches,
    planar_cost,
    rotated,
    torque_weights,
)

BEAM = [[-0.9, 0.0], [0.9, 0.0]]
CASES = pair_cases(np.random.default_rng(0), 60)


def solve(applied, grips, torque_weight=0.5, include_induced=False):
    return wrench.decompose(
        applied,
        grips,
        solver="pair",
        torque_weight=torque_weight,
        include_induced=include_induced,
    )


def relative_residuals(decomposition):
    """Largest residual of each sample, relative to its applied wrench and lever (or 1 m)."""
    scale = np.abs(decomposition.applied).max(axis=(-2, -1))
    lever = max(1.0, np.abs(decomposition.grips).max())
    worst = np.max(decomposition.residuals(), axis=0)
    return worst / np.where(scale > 0, scale, 1.0) / lever


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("torque_weight", [0.02, 0.5, 0.8])
def test_answers_balance_are_plausible_and_cannot_be_beaten(torque_weight, include_induced):
    rng = np.random.default_rng(1)
    for case in CASES:
        d = solve(case.applied, case.grips, torque_weight, include_induced)
        assert relative_residuals(d).max() <= 1e-14, case.name
        assert (d.gap == 0).all()
        others = case.applied - feasible_internal(rng, case.applied, case.grips, 40)
        for step in (1.0, 0.1, 1e-3, 1e-5):
            tried = d.manipulation + step * (others - d.manipulation)
            cost = planar_cost(tried, case.grips, torque_weight, include_induced)
            assert (d.cost - cost <= 1e-13 * d.applied_cost).all(), case.name


def test_every_plausible_alternative_of_the_test_is_plausible():
    rng = np.random.default_rng(2)
    for case in CASES:
        internal = feasible_internal(rng, case.applied, case.grips, 5)
        applied = np.broadcast_to(case.applied, internal.shape)
        decomposer = wrench.Decomposer(case.grips)
        d = wrench.Decomposition(applied, Answer(applied - internal), decomposer)
        assert relative_residuals(d).max() <= 1e-13, case.name


def test_agreeing_effectors_keep_their_wrench_to_the_last_bit():
    rng = np.random.default_rng(3)
    force, share = rng.normal(size=(500, 1, 2)), rng.random((500, 2, 1))
    torque = rng.random((500, 2, 1)) * rng.choice([-1.0, 1.0], (500, 1, 1))
    applied = np.concatenate([force * share, torque], axis=-1)
    d = solve(applied, BEAM)
    np.testing.assert_array_equal(d.manipulation, applied)
    assert (d.relative_cost == 0).all()


@pytest.mark.parametrize("levers", LEVERS)
def test_agreement_is_never_called_internal_wherever_the_grips_are(levers):
    rng = np.random.default_rng(4)
    force, share = rng.normal(size=(500, 1, 2)), rng.random((500, 2, 1))
    torque = rng.random((500, 2, 1))
    applied = rotated(np.concatenate([force * share, torque], axis=-1), 0.3)
    d = solve(applied, grips_on_line(levers, 1.1))
    assert d.relative_cost.max() <= 1e-14


def test_no_wrench_has_no_internal_wrench():
    d = solve(np.zeros((2, 3)), BEAM)
    np.testing.assert_array_equal(d.internal, np.zeros((2, 3)))
    assert d.relative_cost == 0 == d.cost


def test_everything_cancels_where_nothing_is_needed():
    d = solve([[3.0, 4.0, 2.0], [-3.0, -4.0, -2.0]], [[0.0, 0.0], [0.0, 0.0]])
    np.testing.assert_array_equal(d.manipulation, np.zeros((2, 3)))
    assert d.relative_cost == 1


def test_among_equal_costs_the_smallest_torque_wins():
    # at ±1 m and w = 0.5 torque through forces and pure torque cost the same
    d = solve([[0.0, -1.0, -1.0], [0.0, 1.0, 0.5]], [[-1.0, 0.0], [1.0, 0.0]])
    assert d.cost == pytest.approx(0.75, abs=1e-15)
    assert d.internal_force_level == pytest.approx(0.25, abs=1e-15)
    np.testing.assert_allclose(d.manipulation[:, 2], 0.0, atol=1e-15)


@given(angle=angles, scale=st.sampled_from([1e-6, 1.0, 1e6]))
def test_the_tie_is_settled_alike_in_every_direction(angle, scale):
    applied = np.array([[0.0, -1.0, -1.0], [0.0, 1.0, 0.5]]) * scale
    d = solve(rotated(applied, angle), grips_on_line((-1.0, 1.0), angle))
    assert d.internal_force_level == pytest.approx(0.25 * scale, rel=1e-9)


def test_torques_of_the_needed_sign_are_shared_in_proportion():
    d = solve([[0.0, 0.0, 3.0], [0.0, 0.0, 1.0]], BEAM)
    np.testing.assert_array_equal(d.manipulation[:, 2], [3.0, 1.0])
    d = solve([[0.0, 1.0, 3.0], [0.0, -0.5, 1.0]], [[-1.0, 0.0], [1.0, 0.0]], torque_weight=0.1)
    needed = d.manipulation[:, 2]
    assert 0.0 < needed[1] < 1.0
    assert needed[0] == pytest.approx(3 * needed[1], rel=1e-14)
    d = solve([[0.0, 0.0, 3.0], [0.0, 0.0, -1.0]], BEAM)
    np.testing.assert_allclose(d.manipulation[:, 2], [2.0, 0.0], rtol=1e-15)


@pytest.mark.parametrize("torque_weight", [0.05, 0.5, 0.9])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_answers_are_plausible_where_an_arc_is_level_at_the_vertex_of_the_lens(torque_weight, turn):
    for across in 10.0 ** np.arange(-16.0, 0.0, 0.25):
        applied = rotated(np.array([[-across, 1.0, 1.0], [-1.0, 0.0, 0.0]]), turn)
        for grips in (grips_on_line((-0.5, 0.0), turn), grips_on_line((0.0, 0.7), turn)):
            assert relative_residuals(solve(applied, grips, torque_weight)) <= 1e-14


@given(applied=pair_wrenches, levers=levers, angle=angles, w=torque_weights, s=st.booleans())
@settings(max_examples=400, deadline=None)
def test_balance_and_plausibility_hold_for_any_wrench(applied, levers, angle, w, s):
    d = solve(applied, grips_on_line(levers, angle), w, s)
    assert relative_residuals(d) <= 1e-11
    assert 0.0 <= d.relative_cost <= 1.0


@given(applied=pair_wrenches, levers=levers, angle=angles, w=torque_weights, s=st.booleans())
@settings(max_examples=200, deadline=None)
def test_turning_everything_changes_no_cost(applied, levers, angle, w, s):
    straight = solve(applied, grips_on_line(levers, 0.0), w, s)
    turned = solve(rotated(applied, angle), grips_on_line(levers, angle), w, s)
    # a force across the line touches its ball there: rounding ε of the input moves the cost by √ε
    assert turned.cost == pytest.approx(straight.cost, rel=1e-7, abs=1e-12)


@given(applied=pair_wrenches, levers=levers, w=torque_weights, s=st.booleans())
@settings(max_examples=200, deadline=None)
def test_swapping_the_effectors_swaps_the_answer(applied, levers, w, s):
    grips = grips_on_line(levers, 0.4)
    one, other = solve(applied, grips, w, s), solve(applied[::-1], grips[::-1], w, s)
    assert other.cost == pytest.approx(one.cost, rel=1e-9, abs=1e-12)


@given(applied=pair_wrenches, levers=levers, power=st.integers(-20, 20), s=st.booleans())
@settings(max_examples=200, deadline=None)
def test_scaling_the_wrench_scales_the_answer(applied, levers, power, s):
    grips = grips_on_line(levers, 0.4)
    one, scaled = solve(applied, grips, 0.5, s), solve(applied * 2.0**power, grips, 0.5, s)
    assert scaled.cost == pytest.approx(one.cost * 2.0**power, rel=1e-9)


def test_s_1_does_not_depend_on_the_weight_for_symmetric_grips():
    applied = np.random.default_rng(5).normal(size=(8000, 2, 3))
    light, heavy = solve(applied, BEAM, 0.05, True), solve(applied, BEAM, 0.95, True)
    for weight, optimum in ((0.05, light.cost), (0.95, heavy.cost)):
        for d in (light, heavy):
            cost = planar_cost(d.manipulation, np.array(BEAM), weight, True)
            np.testing.assert_allclose(cost, optimum, rtol=1e-9)


def test_s_0_depends_on_the_weight_exactly_where_the_paper_says():
    # eq. 24 with its misprints corrected: t_fI,max is that of smaller magnitude, its sign kept
    rng = np.random.default_rng(6)
    applied = rng.normal(size=(8000, 2, 3))
    lever = np.array(BEAM)[:, 0]
    induced, torque = lever * applied[..., 1], applied[..., 2]
    smaller = np.take_along_axis(induced, np.abs(induced).argmin(-1, keepdims=True), -1)[:, 0]
    same = np.sign(induced[:, 0]) == np.sign(induced[:, 1])
    opposed = np.sign(torque) != np.sign(induced)
    one_opposes = same & (opposed.sum(-1) == 1)
    against = np.where(opposed[:, 0], torque[:, 0], torque[:, 1])
    along = np.where(opposed[:, 0], torque[:, 1], torque[:, 0])
    expected = one_opposes & (np.abs(2 * smaller + along) > np.abs(against))
    light, heavy = solve(applied, BEAM, 0.02), solve(applied, BEAM, 0.98)
    shift = np.abs(light.manipulation - heavy.manipulation).max(axis=(-2, -1))
    assert expected.mean() > 0.1
    assert (shift[~expected] < 1e-6).all()
    assert (shift[expected] > 0).mean() > 0.9


@pytest.mark.parametrize("levers", LEVERS)
def test_with_growing_weight_forces_do_not_fall_and_torques_do_not_rise(levers):
    # section III-D of the paper, which is right for s = 0
    applied = np.random.default_rng(7).normal(size=(2000, 2, 3))
    grips = grips_on_line(levers, 0.0)
    force, torque = [], []
    for weight in (0.05, 0.3, 0.5, 0.7, 0.95):
        manipulation = solve(applied, grips, weight).manipulation
        force.append(np.hypot(manipulation[..., 0], manipulation[..., 1]).sum(-1))
        torque.append(np.abs(manipulation[..., 2]).sum(-1))
    assert (np.diff(force, axis=0) >= -1e-9).all()
    assert (np.diff(torque, axis=0) <= 1e-9).all()
