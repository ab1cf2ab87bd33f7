"""Grips that nearly coincide, with the general solvers: what their gap bounds, and who answers."""

from functools import cache

import numpy as np
import pytest

from coopenv import wrench
from coopenv.wrench.methods import close_grips
from coopenv.wrench.pair import on_axis
from coopenv.wrench.settings import Settings
from tests.wrench.cases import pair_families
from tests.wrench.pair.reference import least_cost
from tests.wrench.pair.test_close_grips import cases

SEPARATIONS = (1e-17, 1e-15, 7e-15, 1e-13, 1e-12, 1e-11, 1e-9, 1e-7, 1e-6, 1e-5)  # [m]
GENERAL = ("structured", "conic")
TEAMS = ("pair", "idle third", "shared force")
ROUNDING = 1e-14  # of J(h)
TRIANGLE = np.array([(0.9, 0.1), (-0.5, 0.7), (-0.3, -0.8)])


def in_space(applied, grips):
    """The same in a plane of space; components are copied, so that no bit of a distance changes."""
    wrenches, places = np.zeros((len(applied), 6)), np.zeros((len(applied), 3))
    wrenches[:, 1:4], places[:, 1:] = applied, grips
    return wrenches, places


def team_of(pair, grips, team, rng):
    """A pair, or three whose optimum costs the same: one is idle, or two do the second's work.

    The sum of balls over parallel vectors is the ball over their sum, so that two at one place may
    be taken for one.
    """
    if team == "pair":
        return pair, grips
    applied, places = np.vstack([pair, np.zeros(3)]), np.vstack([grips, grips[1]])
    if team == "idle third":
        places[2] = rng.normal(size=2)
        return applied, places
    part = rng.integers(2, 7) / 8
    applied[1:] = [(1.0 - part) * pair[1], part * pair[1]]
    return applied, places


def counted(grips, places):
    """A pair's grips as they count in a team; None on a line through the centre of mass."""
    along = grips[1] - grips[0]
    apart, area = np.hypot(*along), np.abs(grips[0, 0] * along[1] - grips[0, 1] * along[0])
    levers, longest = np.hypot(*grips.T), np.hypot(*places.T).max()
    if apart <= 1e-15 * longest:
        return np.tile(grips[levers.argmax()], (2, 1))
    return None if area <= 1e-12 * longest * apart else grips


@cache
def known(team, separation, directions):
    """Teams of every family, and their least cost in 60 digits, of the grips as they count."""
    rng, found = np.random.default_rng(2), []
    for name, pair, grips, weight, induced in cases(0, separation, directions):
        applied, places = team_of(pair, grips, team, rng)
        own = counted(grips, places)
        if own is not None:
            optimum = least_cost(pair, own, weight, induced)
            found.append((name, applied, places, weight, induced, optimum))
    return found


def decomposed(applied, grips, weight, induced, solver):
    return wrench.decompose(
        applied, grips, torque_weight=weight, include_induced=induced, solver=solver
    )


@pytest.mark.parametrize("solver", GENERAL)
@pytest.mark.parametrize("separation", SEPARATIONS)
@pytest.mark.parametrize("directions", ["any", "along"])
@pytest.mark.parametrize("team", TEAMS)
def test_the_optimum_lies_within_the_gap_however_close_two_grips(
    team, directions, separation, solver
):
    for name, applied, grips, weight, induced, optimum in known(team, separation, directions):
        for wrenches, places in ((applied, grips), in_space(applied, grips)):
            d = decomposed(wrenches, places, weight, induced, solver)
            assert np.abs(d.cost - optimum) <= d.gap + ROUNDING * d.applied_cost, name
            assert d.gap <= d.cost, name


@pytest.mark.parametrize(
    ("count", "draws"), [(10, 12), pytest.param(60, 40, marks=pytest.mark.slow)]
)
def test_the_optimum_of_close_teams_of_any_scale_lies_within_the_gap(count, draws):
    # the optimum is that of `pair`, which agrees with 60 digits
    rng = np.random.default_rng(1)
    outside, tried = 0, 0
    for _ in range(draws):
        separation, torque = 10.0 ** rng.uniform(-15, -5), 10.0 ** rng.uniform(-4, 4)
        lever, weight = rng.choice([1e-2, 1.0, 1e2]), rng.choice([0.05, 0.5, 0.95])
        induced, team = bool(rng.integers(2)), rng.choice(TEAMS)
        to_centre, spatial = rng.random() < 0.3, team == "pair" or rng.random() < 0.5
        for pairs in pair_families(rng, count).values():
            pairs[..., 2] *= torque * lever
            place, direction = lever * rng.normal(size=(2, count, 2))
            direction = place if to_centre else direction
            close = np.stack([place, place + separation * direction], axis=1)
            for pair, grips in zip(pairs, close, strict=True):
                applied, places = team_of(pair, grips, team, rng)
                if counted(grips, places) is not grips or on_axis.applies(grips):
                    continue
                applied, places = in_space(applied, places) if spatial else (applied, places)
                d = decomposed(applied, places, weight, induced, "structured")
                exact = decomposed(pair, grips, weight, induced, "pair")
                allowed = d.gap + exact.gap + 1e-9 * d.applied_cost
                outside += (np.abs(d.cost - exact.cost) > allowed) and d.gap < d.cost
                tried += 1
    assert tried >= 0.8 * 11 * count * draws
    assert outside <= 1e-4 * tried


@pytest.mark.parametrize("solver", GENERAL)
@pytest.mark.parametrize("num_others", [1, 2])
def test_the_gap_tells_of_the_jump_where_two_of_a_team_on_a_beam_meet(num_others, solver):
    # Torques of one sign, and others beyond the centre of mass: at one place the two may push each
    # other any way, next to each other only to one side.
    rng = np.random.default_rng(3)
    teams, told = 0, 0
    for _ in range(12):
        place, direction = rng.normal(size=(2, 2))
        others = np.outer(-rng.uniform(0.3, 2.0, size=num_others), place)
        applied = rng.normal(size=(2 + num_others, 3))
        applied[:, 2] = np.abs(applied[:, 2])
        induced = wrench.induced_torque(applied[2:], others)
        applied[2:, :2] *= np.where(induced < 0.0, -1.0, 1.0)
        for of in (lambda a, g: (a, g), in_space):

            def at(separation):
                grips = np.vstack([place, place + separation * direction, others])  # noqa: B023
                return wrench.decompose(*of(applied, grips), solver=solver)  # noqa: B023

            apart = at(1e-5)
            teams += apart.gap <= 1e-6 * apart.applied_cost
            for separation in (1e-13, 1e-11, 1e-9, 1e-7):
                d = at(separation)
                difference, limit = np.abs(d.cost - apart.cost), 1e-4 * d.applied_cost
                assert difference <= d.gap + apart.gap + limit or d.gap == d.cost
                told += difference > 100.0 * limit
    assert teams >= 12
    assert told >= 5


@pytest.mark.parametrize("solver", GENERAL)
def test_where_more_than_the_cost_is_in_doubt_the_gap_is_the_cost(solver):
    # nothing but opposed forces: at one place they cancel, next to each other they are a couple
    # that no torque balances
    applied = np.array([[2.0, 1.0, 0.0], [-2.0, -1.0, 0.0], [0.0, 0.0, 0.0]])
    grips = np.array([(0.9, 0.1), (0.9 + 3e-14, 0.1), (-0.5, 0.7)])
    d = wrench.decompose(applied, grips, solver=solver)
    assert d.gap == d.cost or d.applied_cost - d.cost <= d.gap < d.cost


@pytest.mark.parametrize("solver", ["auto", *GENERAL])
@pytest.mark.parametrize("separation", [0.0, 1e-15, 7e-15, 1e-14, 1e-13, 1e-12, 1e-9, 1e-6])
def test_an_answer_is_not_made_worse_where_it_is_in_doubt(separation, solver):
    forces = np.array([[-1.32, -1.765, -0.358], [1.172, 1.571, -0.301]])
    place = np.array([-0.136352088496291, 0.448969789646627])
    planar = np.array([place, place + separation])
    applied, grips = np.zeros((2, 6)), np.zeros((2, 3))
    applied[:, [1, 2, 3]], grips[:, 1:] = forces, planar  # in the plane x = 0
    exact = wrench.decompose(forces, planar, solver="pair")
    d = wrench.decompose(applied, grips, solver=solver)
    assert d.relative_cost == pytest.approx(exact.relative_cost, abs=1e-6)
    assert exact.relative_cost == pytest.approx(0.8128, abs=1e-4)


@pytest.mark.parametrize("solver", GENERAL)
def test_a_gap_is_small_where_little_is_in_doubt(solver):
    applied = np.array([[2.0, 1.0, 1.0], [-2.0, -1.0, -1.0], [0.0, 0.0, 0.0]])
    grips = np.array([(0.9, 0.1), (0.9 + 1e-7, 0.1), (-0.5, 0.7)])
    d = wrench.decompose(applied, grips, solver=solver)
    exact = wrench.decompose(applied[:2], grips[:2], solver="pair")
    assert exact.cost <= 1e-6 * d.applied_cost
    assert np.abs(d.cost - exact.cost) <= d.gap <= d.cost <= 1e-6 * d.applied_cost


@pytest.mark.parametrize("separation", SEPARATIONS[2:])
def test_structured_leaves_planar_pairs_that_nearly_coincide_to_pair(separation):
    for name, applied, grips, weight, induced, optimum in known("pair", separation, "any"):
        d = decomposed(applied, grips, weight, induced, "structured")
        exact = decomposed(applied, grips, weight, induced, "pair")
        near = close_grips.nearly_coincide(grips)
        assert d.solver == "structured"
        assert d.fell_back == near
        assert near or separation >= 1e-7
        if near:
            np.testing.assert_array_equal(d.manipulation, exact.manipulation)
            np.testing.assert_array_equal(d.gap, exact.gap)
            assert np.abs(d.cost - optimum) <= 2e-15 * d.applied_cost, name


def test_a_batch_may_mix_close_and_ordinary_pairs():
    rng = np.random.default_rng(5)
    applied, grips = rng.normal(size=(6, 1, 2, 3)), rng.normal(size=(4, 2, 2))
    grips[::2, 1] = grips[::2, 0] + 1e-10 * rng.normal(size=(2, 2))
    d = wrench.decompose(applied, grips, solver="structured")
    assert d.gap.shape == d.fell_back.shape == (6, 4)
    np.testing.assert_array_equal(d.fell_back, np.tile([True, False], (6, 2)))
    for k in range(4):
        one = wrench.decompose(applied[:, 0], grips[k], solver="structured")
        np.testing.assert_array_equal(d.fell_back[:, k], one.fell_back)
        np.testing.assert_allclose(d.manipulation[:, k], one.manipulation, atol=1e-14)
        np.testing.assert_allclose(d.gap[:, k], one.gap, atol=1e-14)


def test_ordinary_grips_are_left_to_the_very_solver():
    settings = Settings()

    def solve(applied):
        raise AssertionError

    beam = np.outer([-0.9, 0.9, 0.4], [np.cos(0.7), np.sin(0.7)])
    for grips in (TRIANGLE, beam, np.zeros((3, 2)), np.ones((3, 3)), np.zeros((1, 2))):
        assert close_grips.with_rounding_counted(solve, grips, settings) is solve


def test_the_least_lever_is_that_of_the_closest_pair_or_line():
    lever = close_grips.least_lever
    assert lever(TRIANGLE) == lever(np.zeros((3, 2))) == np.inf
    close = TRIANGLE.copy()
    close[1] = close[0] + [3e-10, 4e-10]
    height = np.abs(0.9 * 4e-10 - 0.1 * 3e-10) / 5e-10
    assert lever(close) == pytest.approx(5e-10 * height / np.hypot(0.9, 0.1), rel=1e-6)
    radial = np.array([(0.9, 0.0), (0.9 + 1e-9, 0.0), (0.0, 0.5)])
    assert lever(radial) == pytest.approx(1e-9, rel=1e-6)
    line = np.array([(0.9, 0.0, 0.0), (-0.9, 2e-8, 0.0), (0.1, 0.0, 0.5)])
    assert lever(line) == pytest.approx(2e-8, rel=1e-6)
    assert lever(np.array([(0.9, 0.0), (0.9 + 4e-16, 0.0)])) == np.inf
    assert lever(np.zeros((5, 0, 2))).shape == (5,)
