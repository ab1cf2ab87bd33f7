"""Load shares, energy shares, costs and internal levels."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.errors import InvalidInput
from coopenv.wrench.measures import level_kernel, level_parameters

BEAM = [[-0.9, 0.0], [0.9, 0.0]]


def random_case(dimension, seed=0, num_effectors=3):
    rng = np.random.default_rng(seed)
    grips = rng.normal(size=(num_effectors, dimension))
    applied = rng.normal(size=(50, num_effectors, 3 * dimension - 3))
    return applied, grips


@pytest.mark.parametrize("dimension", [2, 3])
def test_load_shares_follow_equation_25(dimension):
    applied, grips = random_case(dimension)
    share = wrench.load_share(applied, grips)
    at_centre = applied[..., dimension:] + wrench.induced_torque(applied, grips)
    for parts, found in ((applied[..., :dimension], share.force), (at_centre, share.torque)):
        total = parts.sum(axis=1, keepdims=True)
        projection = (parts * total).sum(-1) / (total**2).sum(-1)
        spent = np.abs(projection).sum(-1, keepdims=True)  # A / ‖f_o‖
        theta = 2.0 / (spent + 1.0)  # eq. 23
        np.testing.assert_allclose(found, theta * np.maximum(projection, 0.0), rtol=1e-12)
        np.testing.assert_allclose(found.sum(-1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_shares_without_nan_are_load_shares_or_even(dimension):
    applied, grips = random_case(dimension)
    applied[0] = 0.0  # neither is defined
    applied[1, :, dimension:] = -wrench.induced_torque(applied[1], grips)  # no torque
    split = wrench.decompose(applied, grips, method="moore_penrose")
    share, filled = split.load_share, split.share_or_even
    for plain, found, defined in (
        (share.force, filled.force, filled.force_defined),
        (share.torque, filled.torque, filled.torque_defined),
    ):
        np.testing.assert_array_equal(defined, ~np.isnan(plain).any(axis=-1))
        np.testing.assert_array_equal(found, np.nan_to_num(plain, nan=1 / 3))
    assert filled.force_defined[:3].tolist() == [False, True, True]
    assert filled.torque_defined[:3].tolist() == [False, False, True]


def test_load_shares_are_undefined_where_the_resultant_vanishes():
    share = wrench.load_share([[1.0, 0.0, 0.0], [-1.0, 1e-10, 0.0]], BEAM)
    assert np.isnan(share.force).all()
    assert not np.isnan(share.torque).any()
    share = wrench.load_share([[1.0, 0.0, 0.0], [-1.0, 1e-8, 0.0]], BEAM)
    np.testing.assert_allclose(share.force, [0.0, 1.0])
    nothing = wrench.load_share(np.zeros((2, 3)), BEAM)
    assert np.isnan(nothing.force).all()
    assert np.isnan(nothing.torque).all()


def test_unequal_loads_are_no_disagreement():
    d = wrench.decompose([[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]], BEAM)
    np.testing.assert_allclose(d.load_share.force, [0.75, 0.25])
    assert d.internal_force_level == 0 == d.relative_cost


@pytest.mark.parametrize("dimension", [2, 3])
def test_energy_shares_follow_equations_26_and_27(dimension):
    applied, grips = random_case(dimension, seed=1)
    twist = np.random.default_rng(2).normal(size=(50, 3 * dimension - 3))
    share = wrench.energy_share(applied, grips, twist)
    at_centre = applied[..., dimension:] + wrench.induced_torque(applied, grips)
    linear = (applied[..., :dimension] * twist[:, None, :dimension]).sum(-1)
    angular = (at_centre * twist[:, None, dimension:]).sum(-1)
    for power, found in (
        (linear + angular, share.total),
        (linear, share.linear),
        (angular, share.angular),
    ):
        net = power.sum(-1, keepdims=True)
        theta = 2.0 / (np.abs(power / net).sum(-1, keepdims=True) + 1.0)
        np.testing.assert_allclose(found, theta * np.maximum(power / net, 0.0), rtol=1e-9)
    total = linear + angular
    passed = 0.5 * (np.abs(total).sum(-1) - np.abs(total.sum(-1)))
    np.testing.assert_allclose(share.internal_power, passed, atol=1e-12)


def test_energy_shares_when_one_brakes():
    share = wrench.energy_share([[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], BEAM, [2.0, 0.0, 0.0])
    np.testing.assert_allclose(share.total, [1.0, 0.0])
    assert share.internal_power == pytest.approx(2.0)
    assert np.isnan(share.angular).all()


def test_braking_together_is_shared_as_pushing_together():
    share = wrench.energy_share([[-3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], BEAM, [2.0, 0.0, 0.0])
    np.testing.assert_allclose(share.linear, [0.75, 0.25])


def test_standing_still_has_no_energy_share():
    share = wrench.energy_share(np.ones((4, 2, 3)), BEAM, np.zeros(3))
    assert np.isnan(share.total).all()
    np.testing.assert_array_equal(share.internal_power, np.zeros(4))


def test_a_twist_of_another_shape_is_refused():
    with pytest.raises(InvalidInput, match=r"twist must be of shape \(\.\.\., 3\)"):
        wrench.energy_share(np.ones((4, 2, 3)), BEAM, np.ones(6))
    d = wrench.decompose(np.ones((4, 2, 3)), BEAM)
    with pytest.raises(InvalidInput, match=r"twist must be of shape .*, got \(5, 3\)"):
        d.energy_share(np.ones((5, 3)))
    with pytest.raises(InvalidInput, match="twist must be finite"):
        d.energy_share([np.nan, 0.0, 0.0])


@pytest.mark.parametrize("include_induced", [False, True])
@pytest.mark.parametrize("dimension", [2, 3])
def test_costs_and_levels_follow_their_equations(dimension, include_induced):
    applied, grips = random_case(dimension, seed=3)
    d = wrench.decompose(
        applied,
        grips,
        method="moore_penrose",
        torque_weight=0.3,
        include_induced=include_induced,
    )

    def norm(vectors):
        return np.linalg.norm(vectors, axis=-1).sum(axis=-1)

    def cost(h):  # eq. 17
        torque = norm(h[..., dimension:])
        induced = norm(wrench.induced_torque(h, grips))
        return 0.7 * norm(h[..., :dimension]) + 0.3 * (torque + include_induced * induced)

    np.testing.assert_allclose(d.cost, cost(d.manipulation), rtol=1e-12)
    np.testing.assert_allclose(d.applied_cost, cost(applied), rtol=1e-12)
    np.testing.assert_allclose(d.relative_cost, 1 - d.cost / d.applied_cost, atol=1e-12)
    internal = d.internal
    at_centre = internal[..., dimension:] + wrench.induced_torque(internal, grips)
    np.testing.assert_allclose(d.internal_force_level, 0.5 * norm(internal[..., :dimension]))
    np.testing.assert_allclose(d.internal_torque_level, 0.5 * norm(at_centre))


def test_wasted_cost_is_what_of_the_applied_cost_was_not_needed():
    d = wrench.decompose([[3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], BEAM)
    assert d.wasted_cost == pytest.approx(0.5 * (4.0 - 2.0))  # w = 0.5: half a newton for each of F
    torques = wrench.decompose([[0.0, 0.0, 3.0], [0.0, 0.0, -1.0]], BEAM, torque_weight=0.25)
    assert torques.wasted_cost == pytest.approx(0.25 * (4.0 - 2.0))
    assert wrench.decompose(np.zeros((2, 3)), BEAM).wasted_cost == 0.0


@pytest.mark.parametrize(("num_effectors", "dimension"), [(2, 2), (3, 2), (4, 3)])
def test_wasted_cost_scales_with_the_wrench_and_is_never_negative(num_effectors, dimension):
    applied, grips = random_case(dimension, seed=7, num_effectors=num_effectors)
    d, faint = wrench.decompose(applied, grips), wrench.decompose(1e-3 * applied, grips)
    np.testing.assert_allclose(d.wasted_cost, d.applied_cost - d.cost, atol=1e-14)
    np.testing.assert_allclose(d.wasted_cost, d.relative_cost * d.applied_cost, atol=1e-14)
    np.testing.assert_allclose(faint.wasted_cost, 1e-3 * d.wasted_cost, atol=1e-9)
    assert (d.wasted_cost >= 0.0).all()


def test_wasted_cost_does_not_jump_where_levels_do():
    # at ±1 m costs tie: pressing out the torque or leaving it to pure torques is the same
    applied, nudge = np.array([[0.0, -1.0, -1.0], [0.0, 1.0, 0.5]]), 1e-6
    near, beyond = (
        wrench.decompose(applied, [[-1.0 + shift, 0.0], [1.0 - shift, 0.0]])
        for shift in (nudge, -nudge)
    )
    assert np.abs(near.internal_force_level - beyond.internal_force_level) > 0.2
    assert near.wasted_cost == pytest.approx(float(beyond.wasted_cost), abs=2e-6)


def test_wasted_cost_of_idle_hands_is_small_where_the_relative_cost_is_not():
    noise = 0.05 * np.random.default_rng(8).normal(size=(1000, 2, 3))
    d = wrench.decompose(noise, BEAM)
    assert d.relative_cost.mean() > 0.1
    assert d.wasted_cost.mean() < 0.05


def test_implausible_methods_may_have_a_negative_relative_cost():
    d = wrench.decompose([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0]], BEAM, method="nonsqueezing")
    assert d.relative_cost < 0
    assert d.wasted_cost < 0


def test_internal_torque_level_is_half_of_what_cancels():
    d = wrench.decompose([[0.0, 0.0, 3.0], [0.0, 0.0, -1.0]], BEAM)
    assert d.internal_torque_level == pytest.approx(1.0)
    assert d.internal_force_level == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_measures_take_time_series_with_one_twist_a_row(dimension):
    rng = np.random.default_rng(6)
    size = 3 * dimension - 3
    applied, grips = rng.normal(size=(2, 50, 3, size)), rng.normal(size=(50, 3, dimension))
    twist = rng.normal(size=(50, size))
    energy, load = wrench.energy_share(applied, grips, twist), wrench.load_share(applied, grips)
    assert energy.total.shape == load.torque.shape == (2, 50, 3)
    assert energy.internal_power.shape == (2, 50)
    one = wrench.energy_share(applied[1, 7], grips[7], twist[7])
    np.testing.assert_array_equal(energy.angular[1, 7], one.angular)
    assert energy.internal_power[1, 7] == one.internal_power
    np.testing.assert_array_equal(
        load.force[0, 3], wrench.load_share(applied[0, 3], grips[3]).force
    )


def test_one_wrench_may_meet_many_twists():
    twist = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    share = wrench.energy_share([[3.0, 1.0, 0.0], [1.0, 1.0, 0.5]], BEAM, twist)
    np.testing.assert_allclose(share.linear[0], [0.75, 0.25])
    np.testing.assert_allclose(share.angular[1], [0.0, 1.0])
    np.testing.assert_array_equal(np.isnan(share.total).all(axis=-1), [False, False, True])
    np.testing.assert_allclose(share.internal_power, [0.0, 0.9, 0.0])


def test_measures_in_the_plane_are_to_the_bit_those_of_the_same_wrenches_in_space():
    rng = np.random.default_rng(8)
    planar, grips = rng.normal(size=(200, 3, 3)), rng.normal(size=(200, 3, 2))
    planar[:20, 1:] = -planar[:20, :1] / 2  # no resultant force
    twist = rng.normal(size=(200, 3))
    spatial, levers = np.zeros((200, 3, 6)), np.zeros((200, 3, 3))
    spatial[..., :2], spatial[..., 5], levers[..., :2] = planar[..., :2], planar[..., 2], grips
    motion = np.zeros((200, 6))
    motion[:, :2], motion[:, 5] = twist[:, :2], twist[:, 2]
    pairs = (
        (wrench.load_share(planar, grips), wrench.load_share(spatial, levers)),
        (wrench.energy_share(planar, grips, twist), wrench.energy_share(spatial, levers, motion)),
    )
    for in_plane, in_space in pairs:
        for one, other in zip(in_plane, in_space, strict=True):
            np.testing.assert_array_equal(one, other)
    assert np.isnan(pairs[0][0].force).sum() == 60
    for induced in (False, True):
        told = level_parameters(0.3, induced, False)
        in_plane = level_kernel(planar, planar[::-1].copy(), grips, told)
        in_space = level_kernel(spatial, spatial[::-1].copy(), levers, told)
        np.testing.assert_array_equal(in_plane, in_space)
