"""Solver against solver, and against the numbers of the paper's examples."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.wrench.answer import Answer
from tests.wrench.cases import pair_cases

BEAM = [[-1.0, 0.0], [1.0, 0.0]]
CENTRE = np.zeros((3, 2))


def decompose(applied, grips, method="optimal", **settings):
    return wrench.decompose(applied, grips, method=method, **settings)


def forces(*force):
    """Planar wrenches without torque."""
    return np.array([[*f, 0.0] for f in force], dtype=float)


@pytest.mark.parametrize(
    ("torque_weight", "include_induced", "seed"),
    [
        (0.05, False, 0),
        (0.3, True, 1),
        (0.5, False, 2),
        (0.5, True, 3),
        (0.8, False, 4),
        (0.95, True, 5),
    ],
)
def test_pair_and_conic_find_the_same_cost(torque_weight, include_induced, seed):
    settings = {"torque_weight": torque_weight, "include_induced": include_induced}
    count = 19  # 11 families at 10 pairs of levers and 6 costs: 12,540 wrenches
    doubts = []
    for case in pair_cases(np.random.default_rng(seed), count):
        pair = decompose(case.applied, case.grips, solver="pair", **settings)
        conic = decompose(case.applied, case.grips, solver="conic", **settings)
        unit = np.maximum(pair.applied_cost, 1e-300)
        difference = np.abs(pair.cost - conic.cost) / unit
        assert (difference <= conic.gap / unit + 1e-9).all(), case.name
        doubts.append(conic.gap / unit)
    doubt = np.concatenate(doubts)
    assert np.median(doubt) <= 1e-10
    assert (doubt > 1e-6).mean() <= 5e-3


@pytest.mark.parametrize(
    ("applied", "internal", "pseudoinverse"),
    [((2, 0), 0.0, 1.0), ((1, 1), 0.0, 0.0), ((3, -1), 1.0, 2.0)],
)
def test_figure_2(applied, internal, pseudoinverse):
    wrenches = forces((applied[0], 0), (applied[1], 0))
    expected = forces((internal, 0), (-internal, 0))
    for solver in ("pair", "conic"):
        d = decompose(wrenches, BEAM, solver=solver)
        np.testing.assert_allclose(d.internal, expected, atol=1e-8)
    for method in ("moore_penrose", "nonsqueezing", "parametrized"):
        d = decompose(wrenches, BEAM, method)
        np.testing.assert_allclose(
            d.internal, forces((pseudoinverse, 0), (-pseudoinverse, 0)), atol=1e-12
        )


@pytest.mark.parametrize(
    ("method", "force", "torque"),
    [
        ("moore_penrose", 0.35, -0.35),
        ("nonsqueezing", 0.7, -0.7),
        ("virtual_linkage", 0.0, 0.0),
        ("optimal", 0.0, 0.0),
        ("point_mass", 0.7, -0.7),
    ],
)
def test_a_pure_couple(method, force, torque):
    d = decompose(forces((0, -0.7), (0, 0.7)), BEAM, method)
    np.testing.assert_allclose(np.abs(d.internal[:, 1]), force, atol=1e-12)
    np.testing.assert_allclose(d.internal[:, 2], torque, atol=1e-12)


# not printed in the paper: the only forces on half-integer grids to ±6 N that give its numbers
FIGURE_5 = forces((3, 3), (4, -1), (-3, 0))


def test_figure_5_optimal():
    d = decompose(FIGURE_5, CENTRE)
    assert np.linalg.norm(d.manipulation[:, :2], axis=-1).sum() == pytest.approx(4.472, abs=5e-4)
    assert d.solver == "structured"


def test_figure_5_point_mass():
    d = decompose(FIGURE_5, CENTRE, "point_mass")
    expected = forces((2.25, 1.125), (1.75, 0.875), (0, 0))
    np.testing.assert_allclose(d.manipulation, expected, atol=1e-12)
    assert 2 * d.internal_force_level == pytest.approx(7.948, abs=5e-4)


def test_figure_5_split_of_the_paper_is_as_cheap_and_less_internal():
    manipulation = forces((3, 1.5), (1, 0.5), (0, 0))
    decomposer = wrench.Decomposer(CENTRE)
    d = wrench.Decomposition(FIGURE_5, Answer(manipulation), decomposer)
    assert 2 * d.internal_force_level == pytest.approx(7.854, abs=5e-4)
    assert d.cost == pytest.approx(float(decomposer(FIGURE_5).cost), rel=1e-7)
    assert max(d.residuals()) == pytest.approx(0.0, abs=1e-15)


def test_figure_5_pseudoinverse_claims_more_than_was_applied():
    d = decompose(FIGURE_5, CENTRE, "moore_penrose")
    assert np.linalg.norm(d.internal[2]) == pytest.approx(4.384, abs=5e-4)
    assert np.linalg.norm(d.internal[2]) > np.linalg.norm(FIGURE_5[2])
    assert d.residuals().force > 0.5


def test_parametrized_with_unit_masses_is_moore_penrose_at_one_metre():
    matrix = wrench.grasp_matrix(BEAM)
    inverse = wrench.allocate(np.eye(3), BEAM, "parametrized").reshape(3, 6).T
    np.testing.assert_allclose(inverse, np.linalg.pinv(matrix), atol=1e-15)


@pytest.mark.parametrize("mass", [1.0, 2.3, 4.0])
@pytest.mark.parametrize("load", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("include_induced", [False, True])
def test_parametrized_wrenches_are_free_of_internal_wrench(mass, load, include_induced):
    # eqs. 30 and 34: allocate, then shift the load along the beam
    wanted = np.random.default_rng(0).normal(size=(200, 3))
    applied = wrench.allocate(wanted, BEAM, "parametrized", virtual_masses=[mass, mass])
    applied[:, :, 0] += (2 * load - 1) * applied[:, :1, 0] * np.array([1.0, -1.0])
    d = decompose(applied, BEAM, include_induced=include_induced)
    assert d.solver == "pair"
    np.testing.assert_allclose(d.manipulation, applied, atol=1e-14)
    assert d.relative_cost.max() <= 1e-14


def test_walker_is_free_of_internal_wrench_where_one_pushes_and_the_other_turns():
    # section V: the human gives all force, the drive at the centre of mass all torque
    applied = np.zeros((100, 2, 3))
    applied[:, 0, 0] = np.linspace(-30, 30, 100)
    applied[:, 1, 2] = np.linspace(20, -50, 100)
    grips = [[-0.5, 0.0], [0.0, 0.0]]
    for method in ("optimal", "point_mass"):
        d = decompose(applied, grips, method)
        np.testing.assert_array_equal(d.internal, np.zeros((100, 2, 3)))
    np.testing.assert_array_equal(d.load_share.force, np.tile([1.0, 0.0], (100, 1)))
    np.testing.assert_array_equal(d.load_share.torque, np.tile([0.0, 1.0], (100, 1)))
