"""The paper's walker simulations, and its claims about them (section V-A)."""

import numpy as np
import pytest

from coopenv import wrench
from coopenv.agents.studies.walker.simulations import (
    Impedance,
    RollingPlan,
    WalkerAvoid,
    WalkerTurn,
)
from coopenv.errors import InvalidInput

PLAUSIBLE = ("optimal", "point_mass")
INFLATING = ("moore_penrose", "nonsqueezing", "virtual_linkage")


@pytest.fixture(scope="module")
def turn():
    return WalkerTurn().run()


@pytest.fixture(scope="module")
def avoid():
    return WalkerAvoid().run()


def decomposed(recording, method):
    return wrench.decompose(recording.applied, recording.grips, method=method)


def test_the_human_gives_the_force_and_the_drive_the_torque(turn):
    assert np.abs(turn.applied[:, 0, 0]).max() > 5.0
    assert np.abs(turn.applied[:, 1, 2]).max() > 50.0
    assert not turn.applied[:, 0, 1:].any()
    assert not turn.applied[:, 1, :2].any()


def test_the_walker_follows_its_plan_round_the_turn(turn):
    assert np.abs(turn.pose - turn.planned).max() < 0.01
    assert turn.planned[-1, 2] == pytest.approx(np.pi / 2)


@pytest.mark.parametrize("method", PLAUSIBLE)
def test_turning_takes_no_internal_wrench(turn, method):
    found = decomposed(turn, method)
    assert found.internal_force_level.max() < 1e-9
    assert found.internal_torque_level.max() < 1e-9


@pytest.mark.parametrize("method", INFLATING)
def test_other_methods_see_one_all_the_same(turn, method):
    found = decomposed(turn, method)
    assert found.internal_force_level.max() > 1.0
    assert found.internal_torque_level.max() > 10.0


def test_force_and_torque_are_each_of_one_agent_alone(turn):
    load = wrench.load_share(turn.applied, turn.grips)
    energy = wrench.energy_share(turn.applied, turn.grips, turn.twist_object)
    for share, wanted in (
        (load.force, (1.0, 0.0)),
        (energy.linear, (1.0, 0.0)),
        (load.torque, (0.0, 1.0)),
        (energy.angular, (0.0, 1.0)),
    ):
        defined = share[~np.isnan(share[:, 0])]
        assert len(defined) > 0.6 * len(share)
        np.testing.assert_allclose(defined, np.broadcast_to(wanted, defined.shape), atol=1e-9)


def crossing(recording):
    """First step in which the drive's force outweighs the human's."""
    return int(np.argmax(recording.applied[..., 0].sum(axis=1) < 0))


def test_the_walker_stops_short_of_the_obstacle(avoid):
    assert 0.02 < avoid.clearance[-1] < 0.2
    assert avoid.clearance.min() > 0.02
    assert avoid.pose[-1, 0] < 0.7 < 2.9 < avoid.planned[-1, 0]
    assert abs(avoid.twist[-1, 0]) < 0.02


def test_internal_force_and_relative_cost_peak_where_the_forces_are_equal(avoid):
    at, found = crossing(avoid), decomposed(avoid, "optimal")
    assert abs(int(found.internal_force_level.argmax()) - at) <= 1
    assert found.relative_cost[at - 1 : at + 1].max() > 0.9
    smaller = np.abs(avoid.applied[..., 0]).min(axis=1)
    opposed = avoid.applied[:, 0, 0] * avoid.applied[:, 1, 0] < 0
    np.testing.assert_allclose(
        found.internal_force_level, np.where(opposed, smaller, 0.0), atol=1e-9
    )


def test_the_human_carries_all_before_and_nothing_after(avoid):
    share = wrench.load_share(avoid.applied, avoid.grips).force[:, 0]
    at = crossing(avoid)
    np.testing.assert_allclose(share[at - 50 : at], 1.0, atol=1e-12)
    np.testing.assert_allclose(share[at : at + 20], 0.0, atol=1e-12)


def test_the_point_mass_agrees_and_the_others_inflate(avoid):
    ours = decomposed(avoid, "optimal").internal_force_level
    np.testing.assert_allclose(
        decomposed(avoid, "point_mass").internal_force_level, ours, atol=1e-9
    )
    for method in INFLATING:
        theirs = decomposed(avoid, method).internal_force_level
        assert (theirs >= ours - 1e-9).all()
        assert theirs.max() > 1.2 * ours.max()


def test_the_braking_does_not_hang_on_the_control_step(avoid):
    finer = WalkerAvoid(dt=0.005).run()
    assert finer.pose[-1, 0] == pytest.approx(avoid.pose[-1, 0], abs=0.01)
    assert finer.time[crossing(finer)] == pytest.approx(avoid.time[crossing(avoid)], abs=0.03)


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: WalkerAvoid(obstacle=0.3).run(), r"obstacle must stand between the walker"),
        (lambda: RollingPlan(turning=(0.7, 0.3)), r"plan\.turning must be"),
        (lambda: RollingPlan(length=0.0), r"plan\.length must be positive, .*; give it in m$"),
        (lambda: RollingPlan(duration=0.0), r"plan\.duration must be positive, .*; give it in s$"),
        (lambda: Impedance(stiffness=-1.0), r"impedance\.stiffness must be zero or positive"),
    ],
)
def test_what_makes_no_sense_is_refused(build, said):
    with pytest.raises(InvalidInput, match=said):
        build()
