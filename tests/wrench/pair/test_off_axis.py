"""The exact solver off the axis: feasible, not to be beaten at any scale, in line with others."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import wrench
from tests.wrench.cases import feasible_internal, pair_families, planar_cost, rotated
from tests.wrench.pair.reference import least_cost

GRIPS = np.array([[0.8, 0.3], [-0.5, 0.9]])
SQUEEZED = [[0.0, -1.0, -1.0], [0.0, 1.0, 0.5]]  # at ±1 m torque costs the same in two ways


def relative_residuals(decomposition):
    """Largest residual of each sample, relative to its applied wrench and lever (or 1 m)."""
    scale = np.abs(decomposition.applied).max(axis=(-2, -1))
    lever = np.maximum(1.0, np.abs(decomposition.grips).max(axis=(-2, -1)))
    worst = np.max(decomposition.residuals(), axis=0)
    return worst / np.where(scale > 0, scale, 1.0) / lever


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("length", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_answers_are_plausible_and_cannot_be_beaten_at_any_scale(length, include_induced):
    rng = np.random.default_rng(1)
    for torque_weight in (0.05, 0.5, 0.95):
        cost = {"torque_weight": torque_weight, "include_induced": include_induced}
        for name, applied in pair_families(rng, 20).items():
            grips = length * rng.normal(size=(2, 2))
            d = wrench.decompose(applied, grips, **cost)
            assert relative_residuals(d).max() <= 1e-14, name
            others = applied - feasible_internal(rng, applied, grips, 40)
            for step in (1.0, 0.1, 1e-3, 1e-5):
                tried = d.manipulation + step * (others - d.manipulation)
                gain = d.cost - planar_cost(tried, grips, torque_weight, include_induced)
                assert (gain <= 1e-13 * d.applied_cost).all(), name


@pytest.mark.parametrize("include_induced", [False, True])
def test_conic_finds_the_same_cost_within_its_bound(include_induced):
    rng = np.random.default_rng(2)
    for torque_weight in (0.05, 0.5, 0.95):
        cost = {"torque_weight": torque_weight, "include_induced": include_induced}
        for name, applied in pair_families(rng, 8).items():
            grips = rng.normal(size=(len(applied), 2, 2))
            d = wrench.decompose(applied, grips, **cost)
            other = wrench.decompose(applied, grips, solver="conic", **cost)
            allowed = other.gap + 1e-12 * d.applied_cost
            assert (np.abs(d.cost - other.cost) <= allowed).all(), name


def test_agreeing_effectors_keep_their_wrench_to_rounding():
    rng = np.random.default_rng(3)
    force, share = rng.normal(size=(500, 1, 2)), rng.random((500, 2, 1))
    torque = rng.random((500, 2, 1)) * rng.choice([-1.0, 1.0], (500, 1, 1))
    applied = np.concatenate([force * share, torque], axis=-1)
    d = wrench.decompose(applied, GRIPS)
    np.testing.assert_allclose(d.manipulation, applied, rtol=0, atol=4e-16)
    assert d.relative_cost.max() <= 1e-15


def test_a_force_along_its_lever_still_induces_no_torque_once_it_is_split():
    rng = np.random.default_rng(9)
    applied = rng.normal(size=(200, 2, 3))
    applied[:, 0, :2] = rng.normal(size=(200, 1)) * GRIPS[0]
    for include_induced in (False, True):
        d = wrench.decompose(applied, GRIPS, include_induced=include_induced)
        kept = d.manipulation[:, 0]
        induced = GRIPS[0, 0] * kept[:, 1] - GRIPS[0, 1] * kept[:, 0]
        assert np.abs(induced).max() <= 1e-14
        assert relative_residuals(d).max() <= 1e-14
        assert (d.relative_cost > 0.01).any()


def test_near_agreement_little_is_internal():
    # the feasible set is a lens of length ε and thickness ε²
    rng = np.random.default_rng(4)
    for epsilon in (1e-4, 1e-6, 1e-8, 1e-10):
        force, share = rng.normal(size=(300, 1, 2)), rng.uniform(0.5, 1.0, (300, 2, 1))
        applied = np.concatenate([force * share, rng.normal(size=(300, 2, 1))], axis=-1)
        applied[..., :2] += epsilon * rng.normal(size=(300, 2, 2))
        d = wrench.decompose(applied, GRIPS, torque_weight=0.95)
        assert d.internal_force_level.max() <= 10.0 * epsilon
        assert (d.internal_force_level > 0.1 * epsilon).any()
        assert relative_residuals(d).max() <= 1e-15


@pytest.mark.parametrize("distance", [3e-12, 1e-10, 1e-8, 1e-6])
def test_close_to_the_axis_no_ball_is_left(distance):
    rng = np.random.default_rng(8)
    for name, applied in pair_families(rng, 100).items():
        along = rng.normal(size=(len(applied), 1, 2))
        grips = rng.normal(size=(len(applied), 2, 1)) * along
        grips[:, 1] += distance * along[:, 0, ::-1] * [-1.0, 1.0]
        d = wrench.decompose(applied, grips)
        assert relative_residuals(d).max() <= 1e-11, name


def test_no_ball_is_left_where_a_disc_that_is_nearly_level_meets_a_strip():
    # as of forces nearly across or along the line: rounding of v moves the disc's end by far more
    grips = np.array([[-1.4, 1.4], [1.4, 1.4]])
    applied = pair_families(np.random.default_rng(9), 20_000)["uneven"]
    for induced in (False, True):
        d = wrench.decompose(applied, grips, include_induced=induced)
        assert relative_residuals(d).max() <= 1e-14


@pytest.mark.parametrize("induced", [False, True])
@pytest.mark.parametrize("weight", [0.05, 0.5, 0.95])
@pytest.mark.parametrize(
    "applied",
    [
        [[0.191, -80530.41, 68166.87], [0.0326577, 30122.5, -204912.99]],
        [[0.05096, 0.14658, 0.13823], [0.06207, 2.15353e-8, -1.24825e-8]],
        [[-1.44018e-8, 0.03326, 4.78122e-7], [0.000144357, -0.10367, 0.17559]],
    ],
)
def test_the_bound_holds_beside_60_digits_where_a_nearly_level_disc_meets_a_strip(
    applied, weight, induced
):
    grips = np.array([[-1.4, 1.4], [1.4, 1.4]])
    d = wrench.decompose(applied, grips, torque_weight=weight, include_induced=induced)
    exact = least_cost(np.array(applied), grips, weight, induced)
    assert abs(d.cost - exact) <= d.gap + 1e-15 * d.applied_cost


def test_the_reference_of_60_digits_sees_that_only_the_torques_given_can_be_left():
    # where v = 0 alone is feasible, and numbers of more than 60 digits are summed
    applied = [[-3.92039816867888e-07, 3.0335576340833335e-06, -1.1588385471816098e-05]]
    applied += [[3.013033067936313e-06, 4.073955665348763e-08, -1.7008718967691538e-05]]
    grips = np.array([[-0.423607673308004, 0.0], [0.0, 0.0]])
    d = wrench.decompose(applied, grips)
    assert least_cost(np.array(applied), grips) == pytest.approx(float(d.cost), rel=1e-14, abs=0)
    assert d.relative_cost > 1e-3


def test_close_to_the_axis_the_bound_grows_as_rounding_does():
    rng = np.random.default_rng(5)
    beam, across = np.array([[-0.9, 0.0], [0.7, 0.0]]), np.array([[0.0, 1.0], [0.0, -1.0]])
    applied = pair_families(rng, 100)["normal"]
    for distance, allowed in ((1e-1, 1e-13), (1e-4, 1e-10), (1e-8, 1e-6)):
        d = wrench.decompose(applied, beam + distance * across)
        assert relative_residuals(d).max() <= 1e-14
        assert (d.gap <= allowed * d.applied_cost).all()
        again = wrench.decompose(applied, beam + distance * (1.0 + 1e-15) * across)
        assert (np.abs(d.cost - again.cost) <= d.gap + again.gap).all()


def test_where_costs_tie_least_torque_is_left_to_pure_torques():
    for across in (0.0, 1e-3, 2.0):
        grips = [[-1.0, across], [1.0, across]]
        d = wrench.decompose(SQUEEZED, grips)
        np.testing.assert_allclose(d.manipulation[:, 2], 0.0, atol=1e-11)
        np.testing.assert_allclose(d.internal_force_level, 0.25, atol=1e-11)


@given(
    st.lists(st.floats(-3, 3), min_size=6, max_size=6),
    st.floats(-np.pi, np.pi),
    st.floats(-6, 6),
    st.booleans(),
)
@settings(max_examples=100, deadline=None)
def test_frame_scale_and_order_of_the_effectors_do_not_matter(numbers, angle, power, induced):
    applied, scale = np.array(numbers).reshape(2, 3), 10.0**power
    d = wrench.decompose(applied, GRIPS, include_induced=induced)
    c, s = np.cos(angle), np.sin(angle)
    turned = wrench.decompose(
        rotated(applied, angle) * scale, GRIPS @ [[c, s], [-s, c]], include_induced=induced
    )
    swapped = wrench.decompose(applied[::-1], GRIPS[::-1], include_induced=induced)
    size = 1e-12 * float(d.applied_cost) + 1e-300
    np.testing.assert_allclose(turned.cost / scale, d.cost, rtol=0, atol=size)
    np.testing.assert_allclose(swapped.cost, d.cost, rtol=0, atol=size)


def test_whatever_numbers_it_is_called_with_it_answers_in_floats():
    applied = np.random.default_rng(7).integers(-3, 4, size=(30, 2, 3))
    decomposer = wrench.Decomposer(GRIPS)
    exact = decomposer(applied.astype(np.float64)).manipulation
    kinds: list[Any] = [applied, applied.astype(np.float32)]
    for wrenches in kinds:
        found = decomposer(wrenches).manipulation
        assert found.dtype == np.float64
        np.testing.assert_array_equal(found, exact)
