"""Decomposition by every method: batches, dimensions, refusals."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import wrench
from coopenv.errors import InvalidInput, UnknownName
from coopenv.wrench.answer import Answer

BEAM = np.array([[-0.9, 0.0], [0.9, 0.0]])
OFF_AXIS = BEAM + np.array([0.0, 0.1])
TRIANGLE = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])


def wrenches(*batch, n=2, k=3, seed=0):
    return np.random.default_rng(seed).normal(size=(*batch, n, k))


@pytest.mark.parametrize("method", wrench.GENERAL_METHODS)
@pytest.mark.parametrize("batch", [(), (1,), (4,), (2, 3), (0,), (3, 0)])
def test_every_method_keeps_any_batch_shape(method, batch):
    applied = wrenches(*batch)
    d = wrench.decompose(applied, BEAM, method=method)
    assert d.manipulation.shape == d.internal.shape == d.applied.shape == applied.shape
    np.testing.assert_allclose(d.manipulation + d.internal, applied, atol=1e-15)
    assert d.object_wrench.shape == (*batch, 3)
    for name in (
        "cost",
        "applied_cost",
        "relative_cost",
        "wasted_cost",
        "internal_force_level",
        "internal_torque_level",
        "gap",
    ):
        assert np.shape(getattr(d, name)) == batch, name
    assert d.load_share.force.shape == d.load_share.torque.shape == (*batch, 2)
    assert all(np.shape(residual) == batch for residual in d.residuals())


@pytest.mark.parametrize("method", wrench.GENERAL_METHODS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_method_takes_plane_and_space_and_balances(method, dimension):
    grips = np.random.default_rng(1).normal(size=(3, dimension))
    grips -= grips.mean(axis=0)
    d = wrench.decompose(wrenches(5, n=3, k=3 * dimension - 3), grips, method=method)
    if method == "virtual_linkage":
        assert (d.residuals().balance > 0.1).any()
    else:
        assert d.residuals().balance.max() <= 1e-12


@pytest.mark.parametrize("method", wrench.GENERAL_METHODS)
@pytest.mark.parametrize("grips", [BEAM, TRIANGLE])
def test_a_batch_is_its_samples_one_by_one(method, grips):
    applied = wrenches(2, 3, n=len(grips))
    whole = wrench.decompose(applied, grips, method=method)
    for index in np.ndindex(2, 3):
        one = wrench.decompose(applied[index], grips, method=method)
        np.testing.assert_allclose(whole.manipulation[index], one.manipulation, atol=1e-14)
        assert whole.relative_cost[index] == pytest.approx(one.relative_cost, abs=1e-14)
        assert whole.internal_torque_level[index] == pytest.approx(one.internal_torque_level)


@pytest.mark.parametrize("method", wrench.GENERAL_METHODS)
def test_grips_may_differ_from_sample_to_sample(method):
    applied = wrenches(4)
    grips = BEAM * np.array([0.5, 1.0, 1.5, 2.0])[:, None, None]
    d = wrench.decompose(applied, grips, method=method)
    for index in range(4):
        one = wrench.decompose(applied[index], grips[index], method=method)
        np.testing.assert_allclose(d.manipulation[index], one.manipulation, atol=1e-14)
        assert d.internal_torque_level[index] == pytest.approx(one.internal_torque_level)
    assert wrench.decompose(applied[0], grips, method=method).internal.shape == (4, 2, 3)


def test_auto_takes_the_exact_solver_where_it_applies():
    for planar_pair in (BEAM, OFF_AXIS, [BEAM, OFF_AXIS], np.zeros((0, 2, 2))):
        assert wrench.Decomposer(planar_pair).solver == "pair"
    for others in (TRIANGLE, np.zeros((2, 3)), np.zeros((1, 2))):
        assert wrench.Decomposer(others).solver == "structured"
    assert wrench.Decomposer(BEAM, wrench.Settings(method="point_mass")).solver == "closed_form"


def test_a_decomposer_is_the_way_decompose_goes():
    settings = wrench.Settings(torque_weight=0.3, include_induced=True)
    applied = wrenches(7)
    fast = wrench.Decomposer(BEAM, settings)(applied)
    slow = wrench.decompose(applied, BEAM, torque_weight=0.3, include_induced=True)
    np.testing.assert_array_equal(fast.manipulation, slow.manipulation)
    assert fast.settings == slow.settings == settings


def test_what_goes_in_is_neither_changed_nor_watched():
    applied, grips = wrenches(3), BEAM.copy()
    before = applied.copy()
    d = wrench.decompose(applied, grips)
    np.testing.assert_array_equal(applied, before)
    applied[:], grips[:] = 0.0, 0.0
    np.testing.assert_array_equal(d.applied, before)
    np.testing.assert_array_equal(d.grips, BEAM)


def test_views_that_are_not_contiguous_are_welcome():
    applied = wrenches(6)
    d = wrench.decompose(applied[::2], BEAM)
    expected = wrench.decompose(applied[::2].copy(), BEAM)
    np.testing.assert_array_equal(d.manipulation, expected.manipulation)


def test_integers_and_lists_are_numbers_too():
    d = wrench.decompose([[3, 0, 0], [-1, 0, 0]], [[-1, 0], [1, 0]])
    np.testing.assert_array_equal(d.internal, [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])


def test_residuals_tell_what_is_broken():
    decomposer = wrench.Decomposer(BEAM)
    applied = np.array([[1.0, 2.0, 3.0], [1.0, 0.0, 0.0]])
    manipulation = np.array([[1.0, 2.5, 3.0], [1.0, 0.0, -0.25]])
    residuals = wrench.Decomposition(applied, Answer(manipulation), decomposer).residuals()
    assert residuals.balance == pytest.approx(0.7)  # 0.9 m · 0.5 N + 0.25 N·m
    assert residuals.force == pytest.approx(np.hypot(0.5, 1.5) - np.hypot(0.5, 1.0))
    assert residuals.induced_torque == pytest.approx(0.9 * 0.5)
    assert residuals.torque == pytest.approx(0.25)


def test_decompositions_survive_pickling_and_show_what_they_are():
    d = pickle.loads(pickle.dumps(wrench.decompose(wrenches(3), BEAM)))
    np.testing.assert_array_equal(d.internal, wrench.decompose(wrenches(3), BEAM).internal)
    assert "(3,) wrenches of 2 effectors in the plane" in repr(d)
    assert "solver='pair'" in repr(d)


@pytest.mark.parametrize(
    ("applied", "message"),
    [
        (
            np.zeros((3, 3)),
            r"applied must be of shape \(\.\.\., 2, 3\) for grips of shape \(2, 2\)",
        ),
        (np.zeros((2, 6)), r"applied must be of shape \(\.\.\., 2, 3\)"),
        (np.zeros(6), r"applied must be of shape \(\.\.\., 2, 3\)"),
        ([[np.nan, 0, 0], [0, 0, 0]], r"applied must be finite, got nan at index \(0, 0\)"),
        ([[np.inf, 0, 0], [0, 0, 0]], "applied must be finite, got inf"),
        ("wrench", "applied must be an array of numbers"),
        (np.ones((2, 3), dtype=complex), "applied must be an array of numbers"),
        ([["1", "2", "3"], ["4", "5", "6"]], "applied must be an array of numbers"),
        (np.array([[1, 2, 3], [4, 5, "6"]], dtype=object), "applied must be an array of numbers"),
    ],
)
def test_bad_wrenches_are_refused(applied, message):
    with pytest.raises(InvalidInput, match=message):
        wrench.decompose(applied, BEAM)


def test_a_decomposer_checks_shapes_too():
    with pytest.raises(InvalidInput, match="applied must be of shape"):
        wrench.Decomposer(BEAM)(np.zeros((2, 2)))
    with pytest.raises(InvalidInput, match="applied must be of a batch shape that broadcasts"):
        wrench.Decomposer(np.tile(BEAM, (4, 1, 1)))(np.zeros((3, 2, 3)))


def test_no_bound_is_more_than_the_cost():
    decomposer = wrench.Decomposer(TRIANGLE)
    applied = wrenches(2, n=3)
    doubtful = wrench.Decomposition(
        applied, Answer(0.5 * applied, np.array([1e6, 0.1])), decomposer
    )
    np.testing.assert_array_equal(doubtful.gap, [doubtful.cost[0], 0.1])
    cancelled = wrench.Decomposition(applied, Answer(0.0 * applied, np.full(2, 1e-9)), decomposer)
    np.testing.assert_array_equal(cancelled.gap, 0.0)


def test_no_bound_is_more_than_the_cost_however_ill_the_grips():
    far = [[-146809882827.45844, 403269782913.12317], [-42920414863.611755, -2810095958621.9087]]
    d = wrench.decompose(
        [
            [0.6703014093003303, -2.101895560059498, -378430.8659673586],
            [0.4658144484617441, -1.4606762066438992, -262984.02833023213],
        ],
        far,
        solver="structured",
    )
    assert 0.0 < d.gap <= d.cost


@given(
    team=st.integers(1, 4),
    dimension=st.sampled_from([2, 3]),
    seed=st.integers(0, 10**6),
    exponents=st.tuples(*[st.floats(-16.0, 6.0)] * 4),
    degenerate=st.sampled_from(["generic", "integer", "opposite", "no torque", "nearly parallel"]),
    solver=st.sampled_from(["auto", "structured", "conic"]),
    include_induced=st.booleans(),
)
@settings(max_examples=60, deadline=None)
def test_no_bound_is_negative_or_more_than_the_cost_whatever_grips_and_wrenches(
    team, dimension, seed, exponents, degenerate, solver, include_induced
):
    rng = np.random.default_rng(seed)
    apart, lever, torque, _ = 10.0 ** np.array(exponents)
    grips = lever * (rng.normal(size=dimension) + apart * rng.normal(size=(team, dimension)))
    applied = rng.normal(size=(team, 3 * dimension - 3))
    if degenerate == "integer":
        applied = rng.integers(-3, 4, size=applied.shape).astype(float)
    if degenerate == "opposite":
        applied[1:, :dimension] = -applied[0, :dimension]
    if degenerate == "nearly parallel":
        applied[1:, :dimension] = applied[0, :dimension] * (1.0 + 10.0 ** exponents[3])
    applied[:, dimension:] *= 0.0 if degenerate == "no torque" else torque
    d = wrench.decompose(applied, grips, solver=solver, include_induced=include_induced)
    assert 0.0 <= d.gap <= d.cost


@given(seed=st.integers(0, 10**6), team=st.integers(2, 4), dimension=st.sampled_from([2, 3]))
@settings(max_examples=15, deadline=None)
def test_the_largest_internal_force_and_its_bound_are_no_more_than_the_forces(
    seed, team, dimension
):
    rng = np.random.default_rng(seed)
    applied = np.zeros((team, 3 * dimension - 3))
    applied[:, :dimension] = rng.normal(size=(team, dimension))
    d = wrench.decompose(applied, rng.normal(size=(team, dimension)), method="max_internal")
    largest = np.linalg.norm(d.internal[:, :dimension]) + d.gap
    assert d.gap >= 0.0
    assert largest <= np.linalg.norm(applied) * (1.0 + 1e-9)


def test_the_bound_of_the_largest_internal_force_is_none_of_the_cost():
    forces = wrenches(20, n=3) * [1.0, 1.0, 0.0]
    d = wrench.decompose(forces, np.zeros((3, 2)), method="max_internal")
    assert d._answer.gap is not None
    np.testing.assert_array_equal(d.gap, d._answer.gap)


def test_bad_names_and_grips_are_refused():
    with pytest.raises(UnknownName, match="did you mean 'virtual_linkage'"):
        wrench.decompose(wrenches(), BEAM, method="virtual_linkages")
    with pytest.raises(InvalidInput, match="grips must be finite"):
        wrench.decompose(wrenches(), [[np.nan, 0], [0, 0]])
    with pytest.raises(InvalidInput, match=r"torque_weight must be in \]0, 1\["):
        wrench.decompose(wrenches(), BEAM, torque_weight=1.0)
    with pytest.raises(TypeError, match="torqe_weight"):
        wrench.decompose(wrenches(), BEAM, torqe_weight=0.5)  # pyright: ignore[reportCallIssue]


def test_surroundings_that_no_array_tells_of_are_refused():
    for asked in (
        lambda: wrench.decompose(wrenches(), BEAM, surroundings=True),
        lambda: wrench.Decomposer(BEAM, wrench.Settings(surroundings=True)),
    ):
        with pytest.raises(InvalidInput, match=r"surroundings must be False .* one more effector"):
            asked()
    plain = wrench.decompose(wrenches(), BEAM, surroundings=False)
    np.testing.assert_array_equal(plain.internal, wrench.decompose(wrenches(), BEAM).internal)
