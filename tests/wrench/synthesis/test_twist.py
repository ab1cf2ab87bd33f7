"""Synthesis of load shares that need forces across the resultant."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from coopenv import wrench
from coopenv.errors import InvalidInput
from coopenv.wrench.synthesis import search
from coopenv.wrench.synthesis.shares import find as find_along_resultant
from coopenv.wrench.synthesis.wish import Wish
from tests.wrench.synthesis.cases import (
    GRIPS,
    MOTIONS,
    assert_comes_back,
    at_the_edge,
    vouched_for,
    without_internal_part,
)

TEAMS = [(2, 2), (3, 2), (6, 2), (2, 3), (3, 3), (5, 3)]


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(TEAMS),
    st.sampled_from([0.1, 0.5, 0.9]),
    st.booleans(),
)
def test_a_wrench_that_a_twist_vouches_for_has_no_internal_part(seed, team, weight, induced):
    applied, grips = without_internal_part(np.random.default_rng(seed), 5, *team)
    d = wrench.decompose(applied, grips, torque_weight=weight, include_induced=induced)
    size = np.abs(applied).max(axis=(-1, -2))
    assert (np.abs(d.internal).max(axis=(-1, -2)) <= 1e-6 * size).all()


def wishes_across(seed, count, team):
    """Reachable wishes that forces along the resultant do not fulfil."""
    applied, grips = without_internal_part(np.random.default_rng(seed), count, *team)
    wanted, shares = wrench.object_wrench(applied, grips), wrench.load_share(applied, grips)
    simple = find_along_resultant(wanted, grips, *shares)
    across = np.isnan(simple).any(axis=(-1, -2))
    return wanted[across], grips[across], shares.force[across], shares.torque[across]


def wishes_at_the_edge(seed, count, team, place, motion):
    """Resultant, grips and shares of special wrenches; what is rounding is 0 and open."""
    applied, grips = at_the_edge(np.random.default_rng(seed), count, team, place, motion)
    wanted, shares = wrench.object_wrench(applied, grips), wrench.load_share(applied, grips)
    dimension = grips.shape[-1]
    length = np.maximum(np.linalg.norm(grips, axis=-1).max(axis=-1), 1e-300)
    size = np.abs(applied[..., :dimension]).max(axis=(-1, -2))
    size = np.maximum(size, np.abs(applied[..., dimension:]).max(axis=(-1, -2)) / length)
    for part, share, unit in (
        (wanted[:, :dimension], shares.force, size),
        (wanted[:, dimension:], shares.torque, size * length),
    ):
        rounding = np.linalg.norm(part, axis=-1) <= 1e-9 * unit
        part[rounding], share[rounding] = 0.0, np.nan
    some = wanted.any(axis=-1)
    return wanted[some], grips[some], shares.force[some], shares.torque[some]


@pytest.mark.parametrize("induced", [False, True])
@pytest.mark.parametrize("team", TEAMS)
def test_shares_that_need_forces_across_the_resultant_come_back(team, induced):
    wanted, grips, force, torque = wishes_across(1, 60, team)
    assert len(wanted) >= 4
    found = wrench.synthesize(
        wanted, grips, force_share=force, torque_share=torque, include_induced=induced
    )
    assert_comes_back(found, grips, wanted, force=force, torque=torque, include_induced=induced)


def test_the_pair_that_forces_along_the_resultant_did_not_serve():
    grips = np.array([[0.7623, -1.1993], [0.0745, 0.5767]])
    applied = np.array([[0.2175, -0.2437, 0.0665], [1.0735, 0.5119, 0.6757]])
    wanted, share = wrench.object_wrench(applied, grips), wrench.load_share(applied, grips)
    found = wrench.synthesize(wanted, grips, force_share=share.force, torque_share=share.torque)
    assert_comes_back(found, grips, wanted, force=share.force, torque=share.torque)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_units_do_not_matter(scale):
    wanted, grips, force, torque = wishes_across(2, 12, (3, 2))
    wanted = wanted * [scale, scale, scale * 1e3]
    grips = grips * 1e3
    found = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
    d = wrench.decompose(found, grips)
    unit = np.abs(wanted) @ [1.0, 1.0, 1e-3]
    assert (np.abs(d.internal[..., :2]).max(axis=(-1, -2)) <= 1e-6 * unit).all()
    assert (np.abs(d.object_wrench - wanted) <= 1e-6 * np.abs(wanted)).all()
    np.testing.assert_allclose(d.load_share.torque, torque, atol=1e-6)


def test_a_sample_does_not_depend_on_its_batch():
    wanted, grips, force, torque = wishes_across(3, 30, (3, 3))
    together = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
    for k in range(3):
        alone = wrench.synthesize(wanted[k], grips[k], force_share=force[k], torque_share=torque[k])
        np.testing.assert_allclose(alone, together[k], rtol=1e-6, atol=1e-9)


def test_effectors_at_the_centre_of_mass_take_part():
    grips = np.array([[0.0, 0.0], [1.0, 0.3], [-0.4, 0.8]])
    turning, towards = 0.7, np.array([1.0, 0.2])
    velocity = towards + turning * np.stack([-grips[:, 1], grips[:, 0]], axis=-1)
    torque = np.array([[0.5], [0.0], [0.1]])
    applied = np.concatenate([velocity * [[0.3], [1.0], [0.6]], torque], axis=-1)
    wanted, share = wrench.object_wrench(applied, grips), wrench.load_share(applied, grips)
    found = wrench.synthesize(wanted, grips, force_share=share.force, torque_share=share.torque)
    assert_comes_back(found, grips, wanted, force=share.force, torque=share.torque)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("place", GRIPS)
def test_shares_at_the_edge_of_what_is_possible_come_back(place, motion):
    for team in ((2, 2), (3, 3)):
        wanted, grips, force, torque = wishes_at_the_edge(6, 5, team, place, motion)
        found = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
        assert_comes_back(found, grips, wanted, force=force, torque=torque)


@pytest.mark.parametrize("given", [(True, False), (False, True)])
@pytest.mark.parametrize("team", TEAMS)
def test_one_of_the_shares_may_be_left_open(team, given):
    wanted, grips, *shares = wishes_across(7, 60, team)
    force, torque = (
        share if keep else np.full_like(share, np.nan)
        for share, keep in zip(shares, given, strict=True)
    )
    found = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
    assert_comes_back(found, grips, wanted, force=force, torque=torque)


def test_a_trio_that_few_starts_serve_comes_back():
    # two effectors give under 1 % of the force; 3 % of random twists lead to a solution
    grips = np.array(
        [[-0.7552, -1.0658, -0.1641], [-0.6004, -0.9534, -0.4333], [-1.4908, -1.9827, -0.7281]]
    )
    twist = np.array([0.7531, -0.9928, 1.1899]), np.array([-0.0050, 0.0077, 0.0153])
    factors = np.array([[0.001, 0.0, 0.0], [0.0004, 0.0004, 0.6], [0.24, 0.24, 0.0]]).T
    applied = vouched_for(grips, twist, factors[..., None])
    wanted, share = wrench.object_wrench(applied, grips), wrench.load_share(applied, grips)
    found = wrench.synthesize(wanted, grips, force_share=share.force, torque_share=share.torque)
    assert_comes_back(found, grips, wanted, force=share.force, torque=share.torque)


def test_an_impossible_wish_is_refused_before_the_rest_of_its_batch_is_searched(monkeypatch):
    impossible = np.array([0, 9, 0.1]), [0.5, 0.25, 0.25], [0, 0.5, 0.5]
    grips = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])
    whole = Wish(
        np.tile(impossible[0], (2000, 1)),
        np.tile(grips, (2000, 1, 1)),
        np.zeros((2000, 3, 3)),
        np.tile(impossible[1], (2000, 1)),
        np.tile(impossible[2], (2000, 1)),
        wrench.Settings(),
    )
    searched = []
    monkeypatch.setattr(
        "coopenv.wrench.synthesis.twist.find",
        lambda wanted, grips, force, torque, starts, steps, seed: (
            searched.append(len(wanted)) or np.full((len(wanted), starts, 3, 3), np.nan)
        ),
    )
    assert search.find(whole)[1] == 0
    assert 0 < sum(searched) <= 500


def test_shares_that_no_wrench_has_are_named():
    grips = np.array([[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]])
    with pytest.raises(InvalidInput, match=r"^torque_share must go with .* cancel .* possible are"):
        wrench.synthesize(
            [0, 9, 0.1], grips, force_share=[0.5, 0.25, 0.25], torque_share=[0, 0.5, 0.5]
        )


@pytest.mark.slow
@pytest.mark.parametrize("team", TEAMS)
def test_of_many_reachable_shares_none_is_refused(team):
    wanted, grips, force, torque = wishes_across(4, 500, team)
    assert len(wanted) >= 50
    found = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
    assert_comes_back(found, grips, wanted, force=force, torque=torque)


@pytest.mark.slow
@pytest.mark.parametrize("team", [*TEAMS, (10, 3)])
def test_of_many_shares_at_the_edge_none_is_refused(team):
    for place in GRIPS:
        for motion in MOTIONS:
            wanted, grips, force, torque = wishes_at_the_edge(8, 30, team, place, motion)
            found = wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
            assert_comes_back(found, grips, wanted, force=force, torque=torque)


@pytest.mark.slow
def test_what_is_refused_to_a_pair_is_found_nowhere_on_a_grid_either():
    # shares leave one number open, the forces across the resultant
    rng = np.random.default_rng(5)
    across = np.tan(np.linspace(-1.57, 1.57, 6000))[:, None]
    refused = 0
    for _ in range(60):
        grips, wanted = rng.normal(size=(2, 2)), rng.normal(size=3) * [1.0, 1.0, 0.2]
        force, torque = rng.dirichlet([1.0, 1.0], 2)
        try:
            wrench.synthesize(wanted, grips, force_share=force, torque_share=torque)
        except InvalidInput:
            refused += 1
            applied = np.zeros((len(across), 2, 3))
            normal = across * [-wanted[1], wanted[0]]
            applied[:, 0, :2] = force[0] * wanted[:2] + normal
            applied[:, 1, :2] = force[1] * wanted[:2] - normal
            applied[..., 2] = torque * wanted[2] - wrench.induced_torque(applied, grips)[..., 0]
            own = np.abs(wrench.decompose(applied, grips).internal).max(axis=(-1, -2))
            assert (own > 1e-7 * np.abs(applied).max(axis=(-1, -2))).all()
    assert refused >= 5
