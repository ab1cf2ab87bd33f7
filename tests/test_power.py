"""Power of a step: it is the work that is done, its shares, and what agents pass to each other."""

import numpy as np
import pytest

from coopenv import Body, Hands, Transport, rewards, wrench
from coopenv.arrays import FloatArray
from coopenv.transition import Transition
from tests.helpers import NEVER, OPEN_ROOM, QUINTET, TRIO, actions

FREE = Body(linear_drag=0.0, angular_drag=0.0)


def started(num_worlds: int = 1, **keywords) -> Transport:
    keywords = {"scene": OPEN_ROOM, "task": NEVER, **keywords}
    core = Transport(num_worlds=num_worlds, **keywords)
    core.reset(seed=0, pose=(0.0, 0.0, 0.4))
    return core


def played(core: Transport, plan) -> tuple[FloatArray, dict]:
    """Observation and infos after the last action of a plan."""
    steps = [core.step(push) for push in plan]
    return steps[-1][0].astype(float), steps[-1][4]


def after(core: Transport, action) -> Transition:
    core.step(action)
    assert core.transition is not None
    return core.transition


def powers(transition: Transition) -> FloatArray:
    """Of each agent, ``(world, agent)`` [W]: f · (v + ω × r) + t ω."""
    vx, vy, spin = (transition.power.twist[:, None, j] for j in range(3))
    x, y = np.moveaxis(transition.team.grips, -1, 0)
    fx, fy, torque = np.moveaxis(transition.applied, -1, 0)
    return fx * (vx - spin * y) + fy * (vy + spin * x) + torque * spin


def kinetic(core: Transport) -> FloatArray:
    """``(world,)`` [J]."""
    mass, inertia = core.conditions.load.mass, core.conditions.load.inertia
    twist = core.world.twist
    return (mass * (twist[:, 0] ** 2 + twist[:, 1] ** 2) + inertia * twist[:, 2] ** 2) / 2


def missed(dt: float, steps: int) -> float:
    """By how much Σ power · dt misses the gain of kinetic energy, in parts of what all did."""
    core = started(50, body=FREE, dt=dt)
    plan = actions(0, 3, 50, 2, 3).repeat(steps, axis=0)
    all_of_it = off = 0.0
    for push in plan:
        before = kinetic(core)
        done = core.dt * powers(after(core, push))
        off += np.abs(done.sum(axis=1) - (kinetic(core) - before)).sum()
        all_of_it += np.abs(done).sum()
    return off / all_of_it


def test_power_times_duration_is_the_work_of_a_wrench_that_is_held():
    coarse, fine = missed(0.1, 5), missed(0.05, 10)
    assert fine < 3e-7
    assert fine < coarse / 10  # fourth order: by 16


@pytest.mark.parametrize("body", [FREE, Body.walker(), TRIO])
def test_the_mean_twist_is_that_of_many_short_steps_under_the_same_wrench(body):
    core, fine = started(20, body=body), started(20, body=body, dt=0.05 / 100, horizon=10**4)
    for push in actions(1, 15, 20, core.num_agents, 3):
        mean = np.zeros((20, 3))
        for _ in range(100):
            mean += after(fine, push).power.twist / 100
        np.testing.assert_allclose(after(core, push).power.twist, mean, atol=2e-5)
        assert np.abs(mean).max() > 0.01


def test_who_turns_more_than_half_round_in_a_step_is_not_taken_to_turn_back():
    core = started(body=Body(inertia=1e-3, linear_drag=0.0, angular_drag=0.0))
    seen = [after(core, [[[0, 0, 1], [0, 0, 1]]]).power.twist[0, 2] for _ in range(3)]
    spin = 10.0 / 1e-3 * core.dt  # [rad/s] more after each step
    np.testing.assert_allclose(seen, spin * (np.arange(3) + 0.5), rtol=1e-6)


@pytest.mark.parametrize("body", [Body(), TRIO, QUINTET])
def test_shares_are_those_of_the_paper_at_the_mean_twist(body):
    core = started(30, body=body)
    _, info = core.reset(seed=1)
    assert not info["energy_share_defined"].any()
    np.testing.assert_allclose(info["energy_share"], 1 / core.num_agents)
    assert not info["internal_power"].any()
    for push in actions(2, 8, 30, core.num_agents, 3):
        *_, info = core.step(push)
        transition = core.transition
        assert transition is not None
        share = wrench.energy_share(transition.applied, core.team.grips, transition.power.twist)
        np.testing.assert_allclose(info["energy_share"], share.total, rtol=1e-12)
        np.testing.assert_allclose(info["internal_power"], share.internal_power, atol=1e-12)
        assert info["energy_share_defined"].all()
        power = powers(transition)
        passed = (np.abs(power).sum(axis=1) - np.abs(power.sum(axis=1))) / 2
        np.testing.assert_allclose(info["internal_power"], passed, atol=1e-12)
        along = np.maximum(power * np.sign(power.sum(axis=1, keepdims=True)), 0.0)
        np.testing.assert_allclose(info["energy_share"], along / along.sum(1, keepdims=True))


def test_who_brakes_takes_what_the_other_drives():
    core = started(2)
    core.reset(seed=0, pose=(0, 0, 0))
    both = [[[1.0, 0, 0], [-0.5, 0, 0]], [[1.0, 0, 0], [0.5, 0, 0]]]  # in one direction; against
    _, info = played(core, [both] * 5)
    np.testing.assert_allclose(info["energy_share"], [[2 / 3, 1 / 3], [1.0, 0.0]], rtol=1e-9)
    transition = core.transition
    assert transition is not None
    speed = transition.power.twist[1, 0]
    np.testing.assert_allclose(info["internal_power"], [0.0, 5.0 * speed], atol=1e-12)
    assert speed > 0.1


def test_pressing_against_each_other_at_rest_passes_no_power():
    core = started(action="wrench")
    *_, info = core.step([[[1.0, 0, 0], [1.0, 0, 0]]])
    assert info["internal_force_level"][0] == pytest.approx(10.0)
    assert info["internal_power"][0] == 0.0
    assert not info["energy_share_defined"][0]
    np.testing.assert_array_equal(info["energy_share"], 0.5)


@pytest.mark.parametrize("action", ["wrench", "motion"])
def test_blocks_infos_rewards_and_costs_tell_the_same_power_and_energy(action):
    hands = action == "motion"
    price: dict[str, rewards.Term] = {"power": rewards.InternalPower(weight=2.0, scale=4.0)}
    names = ["energy_share", "internal_power"]
    if hands:
        price["stored"] = rewards.StoredEnergy(weight=3.0, scale=0.5)
        names.append("stored_energy")
    core = started(6, action=action, reward=price, cost="internal_power", observe=tuple(names))
    seen, info = played(core, actions(3, 6, 6, 2, 3))
    passed = info["internal_power"][:, None].repeat(2, axis=1)
    np.testing.assert_allclose(seen[..., 0], info["energy_share"], rtol=1e-6)
    np.testing.assert_allclose(seen[..., 1], passed, rtol=1e-6)
    np.testing.assert_allclose(info["reward/power"], -passed / 2, rtol=1e-12)
    np.testing.assert_allclose(info["cost/internal_power"], passed, rtol=1e-12)
    assert (passed > 0).any()
    if hands:
        np.testing.assert_allclose(seen[..., 2], info["stored_energy"], rtol=1e-6)
        np.testing.assert_allclose(info["reward/stored"], -6 * info["stored_energy"], rtol=1e-12)


def test_the_power_of_hands_explains_what_a_beam_gains_but_for_what_varies_in_the_step():
    core = started(50, action="motion", body=FREE, hands=Hands(speed=0.5), substeps=10)
    done, gained, off = np.zeros(50), np.zeros(50), 0.0
    for push in actions(4, 8, 50, 2, 3).repeat(5, axis=0):
        before = kinetic(core)
        work = core.dt * powers(after(core, push)).sum(axis=1)
        done += np.abs(work)
        gain = kinetic(core) - before
        gained += np.abs(gain)
        off += np.abs(work - gain)
    assert (gained > 0.1).all()
    assert (off / done).mean() < 0.1
