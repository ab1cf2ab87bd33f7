"""Any number of effectors: feasible, certified, and as cheap as the oracles say."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.wrench.answer import Answer
from coopenv.wrench.conic import solver as conic
from coopenv.wrench.settings import Settings
from coopenv.wrench.structured import solver as structured
from coopenv.wrench.structured.batch import ITERATIONS
from tests.wrench.cases import pair_cases
from tests.wrench.structured.cases import GRIPS, agreeing, families, grips_of_kind

COUNTS = {n: (10 if n <= 4 else 4 if n <= 8 else 3) for n in range(1, 13)}  # of each family
FEW = {1: 1, 2: 2, 3: 3, 5: 2, 12: 1}  # 1,512 wrenches in all
NEARLY = ("nearly agreeing", "within 1e-3")  # where the oracle is the less accurate
SCALES = (1e-6, 1.0, 1e6)


def solve(applied, grips, solver="structured", **settings):
    return wrench.decompose(applied, grips, solver=solver, **settings)


def relative_residuals(decomposition):
    """Largest residual of each sample, relative to its applied wrench and lever (or 1 m)."""
    scale = np.abs(decomposition.applied).max(axis=(-2, -1))
    lever = max(1.0, np.abs(decomposition.grips).max())
    worst = np.max(decomposition.residuals(), axis=0)
    return worst / np.where(scale > 0, scale, 1.0) / lever


@pytest.mark.parametrize("torque_weight", [0.05, 0.5, 0.95])
@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("counts", [FEW, pytest.param(COUNTS, marks=pytest.mark.slow)])
def test_structured_and_conic_find_the_same_cost(counts, dimension, include_induced, torque_weight):
    # slow: 14 families of 1 to 12 effectors in 12 settings, 11,424 wrenches
    settings = {"torque_weight": torque_weight, "include_induced": include_induced}
    rng = np.random.default_rng(round(100 * torque_weight) + 10 * dimension + include_induced)
    fell_back = []
    for n, count in counts.items():
        for k, (name, applied) in enumerate(families(rng, count, n, dimension).items()):
            grips = grips_of_kind(rng, GRIPS[k % len(GRIPS)], n, dimension)
            scaled = applied * SCALES[(k + n) % 3]
            ours, oracle = (
                solve(scaled, grips, **settings),
                solve(scaled, grips, "conic", **settings),
            )
            assert relative_residuals(ours).max() <= 1e-8, name
            unit = np.maximum(ours.applied_cost, 1e-300)
            assert relative_residuals(oracle).max() <= 1e-8, name
            certified = np.maximum(ours.gap, oracle.gap) / unit
            difference = np.abs(ours.cost - oracle.cost) / unit
            assert (difference <= certified + 1e-9).all(), name
            if name not in NEARLY:
                assert difference.max() <= 1e-8, name
            fell_back.append(ours.fell_back)
    assert np.concatenate(fell_back).mean() <= 0.01


@pytest.mark.parametrize(
    ("torque_weight", "include_induced"), [(0.05, False), (0.5, False), (0.5, True), (0.95, True)]
)
def test_structured_and_pair_find_the_same_cost(torque_weight, include_induced):
    # 11 families at 10 pairs of levers in 4 settings: 11,000 wrenches
    settings = {"torque_weight": torque_weight, "include_induced": include_induced}
    for case in pair_cases(np.random.default_rng(8), 25):
        exact = solve(case.applied, case.grips, "pair", **settings)
        ours = solve(case.applied, case.grips, **settings)
        assert relative_residuals(ours).max() <= 1e-8, case.name
        excess = (ours.cost - exact.cost) / np.maximum(exact.applied_cost, 1e-300)
        assert excess.min() >= -1e-7, case.name  # what a residual of 1e-15 is worth
        assert (ours.cost - exact.cost <= ours.gap + 1e-12 * exact.applied_cost).all(), case.name


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("apart", [0.0, 1e-12, 1e-10])
def test_agreement_is_answered_without_falling_back(dimension, include_induced, apart):
    rng = np.random.default_rng(9)
    for n in (1, 2, 3, 5, 12):
        for kind in GRIPS:
            grips = grips_of_kind(rng, kind, n, dimension)
            applied = agreeing(rng, 40, n, dimension)
            applied += apart * rng.normal(size=applied.shape)
            d = solve(applied, grips, include_induced=include_induced)
            assert d.relative_cost.max() <= 1e-7
            assert (d.gap <= 1e-7 * d.applied_cost).all()
            assert not d.fell_back.any()


@pytest.mark.parametrize("apart", [1e-9, 1e-8, 1e-7, 1e-6, 1e-4])
def test_near_agreement_nearly_always_needs_no_help(apart):
    rng = np.random.default_rng(17)
    bound, fell_back = [], []
    for n, dimension in ((2, 2), (3, 2), (3, 3), (7, 3)):
        grips = grips_of_kind(rng, "scattered", n, dimension)
        applied = agreeing(rng, 100, n, dimension)
        d = solve(applied + apart * rng.normal(size=applied.shape), grips)
        bound.append(d.gap / d.applied_cost)
        fell_back.append(d.fell_back)
    assert np.concatenate(bound).max() <= 1e-5
    assert (np.concatenate(bound) <= structured.ACCEPTED_GAP).mean() >= 0.98
    assert (np.concatenate(bound) <= 1e-8).mean() >= 0.9  # what rounding is worth is part of it
    assert np.concatenate(fell_back).mean() <= 0.02


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_wrench_and_the_same_wrench_turned_are_bounded_alike(dimension, include_induced):
    # forces along their levers come by the dozen; [cost − gap, cost] must overlap
    rng = np.random.default_rng(18)
    turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
    turn[:, 0] *= np.linalg.det(turn)
    for n in (2, 3, 5):
        applied = rng.integers(-1, 2, size=(200, n, 3 * dimension - 3)).astype(float)
        grips = rng.integers(-1, 2, size=(200, n, dimension)).astype(float)
        turned = applied.copy()
        turned[..., :dimension] @= turn.T
        if dimension == 3:
            turned[..., 3:] @= turn.T
        one = solve(applied, grips, include_induced=include_induced)
        other = solve(turned[:, ::-1], (grips @ turn.T)[:, ::-1], include_induced=include_induced)
        assert max(relative_residuals(one).max(), relative_residuals(other).max()) <= 1e-8
        slack = 1e-7 * one.applied_cost
        assert (one.cost - one.gap <= other.cost + slack).all()
        assert (other.cost - other.gap <= one.cost + slack).all()


def test_hopeless_wrenches_fall_back_and_own_up_to_their_gap():
    # levers of picometres beside torques of newton metres
    rng = np.random.default_rng(19)
    applied = rng.normal(size=(300, 2, 3))
    grips = rng.normal(size=(300, 2, 2)) * 10.0 ** rng.uniform(-13, 0, size=(300, 2, 1))
    d = solve(applied, grips)
    doubtful = d.gap > structured.ACCEPTED_GAP * d.applied_cost
    assert relative_residuals(d).max() <= 1e-8
    assert doubtful.mean() <= 0.2
    oracle = solve(applied, grips, "conic")
    assert (d.cost - d.gap <= oracle.cost + oracle.gap + 1e-9 * d.applied_cost).all()


def test_levers_much_longer_than_torques_are_nearly_always_certified_in_the_end():
    rng = np.random.default_rng(23)
    for n in (2, 3):
        d = solve(rng.normal(size=(200, n, 6)), 1e3 * rng.normal(size=(n, 3)))
        assert (d.gap <= 1e-7 * d.applied_cost).mean() >= 0.97
        assert relative_residuals(d).max() <= 1e-8


def test_where_forces_agree_torques_are_shared_along_their_sum():
    d = solve([[1.0, 0.0, 3.0], [2.0, 0.0, -1.0], [0.0, 0.0, 1.0]], np.eye(3, 2))
    np.testing.assert_allclose(d.manipulation[:, 2], [2.25, 0.0, 0.75], atol=1e-15)
    np.testing.assert_array_equal(d.internal[:, :2], 0.0)


def test_ordinary_wrenches_are_certified_without_falling_back():
    rng = np.random.default_rng(10)
    for dimension in (2, 3):
        for n in (3, 4, 8, 40):
            grips = grips_of_kind(rng, "scattered", n, dimension)
            d = solve(rng.normal(size=(200, n, 3 * dimension - 3)), grips)
            assert (d.gap <= 1e-8 * d.applied_cost).all()
            assert not d.fell_back.any()
            assert d.relative_cost.mean() > 0.02


def test_planar_problems_are_spatial_problems_in_a_plane():
    rng = np.random.default_rng(11)
    planar = rng.normal(size=(50, 4, 3))
    spatial = np.zeros((50, 4, 6))
    spatial[..., [0, 1, 5]] = planar
    grips = np.zeros((4, 3))
    grips[:, :2] = rng.normal(size=(4, 2))
    flat, raised = solve(planar, grips[:, :2]), solve(spatial, grips)
    np.testing.assert_allclose(raised.cost, flat.cost, rtol=1e-8)


def test_turning_and_scaling_change_no_relative_cost():
    rng = np.random.default_rng(12)
    applied, grips = rng.normal(size=(50, 5, 6)), rng.normal(size=(5, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    turned = np.concatenate([applied[..., :3] @ turn.T, applied[..., 3:] @ turn.T], axis=-1)
    straight = solve(applied, grips).relative_cost
    for scale in SCALES:
        found = solve(turned * scale, grips @ turn.T).relative_cost
        np.testing.assert_allclose(found, straight, atol=3e-9)


def test_a_sample_has_the_same_bits_alone_and_in_a_batch_on_many_threads():
    rng = np.random.default_rng(13)
    applied, grips = rng.normal(size=(400, 3, 6)), rng.normal(size=(400, 3, 3))
    assert applied[..., 0].size > 2 * structured.WORTH_A_THREAD
    together = solve(applied, grips)
    for i in range(0, 400, 37):
        alone = solve(applied[i], grips[i])
        np.testing.assert_array_equal(alone.manipulation, together.manipulation[i])
        assert alone.gap == together.gap[i]


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_effectors_that_do_nothing_change_nothing(dimension, include_induced):
    # four are treated at once: here with one, two, three, and none of them beside idle ones
    rng = np.random.default_rng(20)
    for n in (1, 2, 3, 4, 5, 7):
        applied = rng.normal(size=(30, n, 3 * dimension - 3))
        grips = rng.normal(size=(n, dimension))
        place = rng.permutation(n + 3)[:n]
        among = np.zeros((30, n + 3, 3 * dimension - 3))
        among[:, place] = applied
        many = 0.1 * rng.normal(size=(n + 3, dimension))
        many[place] = grips
        alone = solve(applied, grips, include_induced=include_induced)
        crowded = solve(among, many, include_induced=include_induced)
        np.testing.assert_allclose(crowded.cost, alone.cost, rtol=3e-9)
        idle = np.setdiff1d(np.arange(n + 3), place)
        np.testing.assert_array_equal(crowded.manipulation[:, idle], 0.0)


def test_batches_broadcast():
    rng = np.random.default_rng(14)
    applied, grips = rng.normal(size=(5, 1, 3, 3)), rng.normal(size=(4, 3, 2))
    d = solve(applied, grips)
    assert d.manipulation.shape == (5, 4, 3, 3)
    assert d.gap.shape == d.fell_back.shape == (5, 4)
    one = solve(applied[2, 0], grips[3])
    np.testing.assert_array_equal(d.manipulation[2, 3], one.manipulation)


def test_nothing_and_one_effector_have_nothing_internal():
    for grips in (np.zeros((3, 2)), np.ones((3, 3)), [[0.3, 0.4]], [[0.0, 0.0, 1.0]]):
        shape = (len(grips), 3 * len(grips[0]) - 3)
        d = solve(np.zeros(shape), grips)
        assert d.cost == d.gap == d.relative_cost == 0
        if len(grips) == 1:
            d = solve(np.arange(1.0, shape[1] + 1)[None], grips)
            np.testing.assert_allclose(d.internal, 0.0, atol=1e-14)


def test_everything_cancels_where_nothing_is_needed():
    applied = np.array([[3.0, 4.0, 2.0], [-3.0, -4.0, -1.0], [0.0, 0.0, -1.0]])
    d = solve(applied, np.zeros((3, 2)))
    np.testing.assert_allclose(d.manipulation, 0.0, atol=1e-7)
    assert d.relative_cost == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("include_induced", [False, True])
def test_internal_wrenches_of_pairs_are_those_of_the_exact_solver_torques_included(include_induced):
    # w = 0.4 and levers off ±1 m: forces do not tie, torques do wherever both supply a part
    applied = np.random.default_rng(21).normal(size=(2000, 2, 3))
    settings = {"torque_weight": 0.4, "include_induced": include_induced}
    grips = np.array([[-0.9, 0.0], [0.7, 0.0]])
    ours, exact = solve(applied, grips, **settings), solve(applied, grips, "pair", **settings)
    off = np.abs(ours.internal - exact.internal).max(axis=(-1, -2))
    off /= np.abs(applied).max(axis=(-1, -2))
    assert np.quantile(off, 0.99) <= 1e-6
    assert off.max() <= 5e-5


@pytest.mark.parametrize("dimension", [2, 3])
def test_torque_that_several_can_supply_is_shared_in_proportion(dimension):
    rng = np.random.default_rng(22)
    grips = rng.normal(size=(4, dimension))
    applied = rng.normal(size=(200, 4, 3 * dimension - 3))
    d = solve(applied, grips)
    torque = d.manipulation[..., dimension:]
    needed = torque.sum(axis=-2, keepdims=True)
    size = np.linalg.norm(needed, axis=-1, keepdims=True)
    supply = np.maximum((applied[..., dimension:] * needed / size).sum(-1, keepdims=True), 0.0)
    enough = (supply.sum(axis=-2) >= (1 + 1e-9) * size[:, 0])[:, 0]
    assert enough.mean() > 0.3
    shared = supply / supply.sum(axis=-2, keepdims=True) * needed
    np.testing.assert_allclose(torque[enough], shared[enough], rtol=0, atol=1e-12)


def test_what_cannot_be_certified_is_also_tried_with_conic(monkeypatch):
    rng = np.random.default_rng(15)
    applied, grips = rng.normal(size=(6, 3, 3)), rng.normal(size=(3, 2))
    good = solve(applied, grips)
    monkeypatch.setattr(structured, "WANTED_GAP_IN_PLANE", 1e-3)
    d = solve(applied, grips)
    assert d.solver == "structured"
    assert d.fell_back.any()
    assert relative_residuals(d).max() <= 1e-8
    assert (d.cost <= good.cost + d.gap).all()

    def knowing_nothing(wrenches):
        return Answer(wrenches, np.array(np.inf))

    monkeypatch.setattr(conic, "prepare", lambda *_: knowing_nothing)
    own = solve(applied, grips)
    assert not own.fell_back.any()
    assert (own.cost - good.cost <= own.gap).all()
    assert own.gap.max() > 1e-6


def test_iterations_hardly_grow_with_the_number_of_effectors():
    rng = np.random.default_rng(16)
    steps = []
    for n in (3, 30, 300):
        applied, grips = rng.normal(size=(10, n, 6)), rng.normal(size=(1, n, 3))
        steps.append(structured.iterate(applied, grips, Settings())[1][:, ITERATIONS].mean())
    assert steps[-1] <= 3.0 * steps[0]


@pytest.mark.parametrize("include_induced", [False, True])
def test_the_gap_reaches_the_optimum_where_one_lever_is_very_short(include_induced):
    rng = np.random.default_rng(8)
    applied = rng.integers(-4, 5, (1000, 2, 3)) / 2.0
    grips = np.zeros((1000, 2, 2))
    grips[:, 1, 0] = -(10.0 ** rng.uniform(-5.0, -2.0, 1000))
    grips[:, 0, 0] = rng.integers(0, 3, 1000) / 2.0
    applied[0], grips[0] = [[1, 0.5, 2], [0, -0.5, 0]], [[0, 0], [-1.284027e-4, 0]]
    settings = {"include_induced": include_induced}
    ours, exact = solve(applied, grips, **settings), solve(applied, grips, "pair", **settings)
    outside = np.abs(ours.cost - exact.cost) - ours.gap
    assert (outside <= 1e-12 * exact.applied_cost).all()
    if include_induced:
        assert 1e-7 < ours.gap[0] < 1e-4  # some, and no more than is needed
