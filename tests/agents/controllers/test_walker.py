"""Scripted policies for a walker: they arrive, none of it is internal, and the drive brakes."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Body, Box, Scene, Transport
from coopenv.agents.controllers.walker import AvoidanceDrive, WalkerController, WalkerGains
from coopenv.agents.evaluate import evaluate, run_episodes
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.agents.controllers.test_impedance import last
from tests.helpers import CLUTTERED

IDS = ("coopenv/WalkerTurn-v0", "coopenv/WalkerAvoid-v0")
EVERY_ID = pytest.mark.parametrize("view", IDS)
OPEN = Scene(size=(30.0, 30.0))


@EVERY_ID
def test_the_walker_arrives_and_nothing_of_the_wrench_is_internal(view):
    config = find_config(view, {})
    seen = evaluate(WalkerController(config), config, episodes=500)
    assert seen.success_rate >= 0.99
    assert seen.relative_cost < 1e-9
    assert 3.0 < seen.success_time < 11.0
    np.testing.assert_allclose(seen.force_load_share, (1.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(seen.torque_load_share, (0.0, 1.0), atol=1e-9)


@EVERY_ID
@pytest.mark.parametrize(
    "keywords",
    [
        {"action": "force", "force_limit": 80.0, "horizon": 600},
        {"scene": CLUTTERED, "horizon": 600},
        {"body": Body.walker(mass=60.0, angular_drag=0.0), "horizon": 600},
        {"body": Body.beam(length=1.2, mass=10.0, nonholonomic=True), "horizon": 600},
        {"dt": 0.02, "substeps": 1, "horizon": 1000},
    ],
    ids=["forces", "cluttered", "heavy", "beam", "fine"],
)
def test_it_arrives_with_other_bodies_rooms_and_actions(view, keywords):
    config = find_config(view, keywords)
    assert evaluate(WalkerController(config), config, episodes=60).success_rate >= 0.95


def test_past_an_obstacle_it_hardly_touches_anything():
    config = find_config("coopenv/WalkerAvoid-v0", {})
    seen = run_episodes(WalkerController(config), config, episodes=100)
    assert (seen.contact_impulse > 0).mean() < 0.1
    braking = run_episodes(WalkerController(config, avoid=True), config, episodes=100)
    assert braking.success.mean() >= 0.99
    assert braking.contact_impulse.mean() <= seen.contact_impulse.mean()


def test_it_drives_backwards_where_that_is_less_to_turn():
    config = find_config("coopenv/WalkerTurn-v0", {})
    core = Transport(config=config)
    obs, _ = core.reset(seed=0, pose=(1.5, 0, 0), goal=(-0.5, 0, 0))
    policy, turned, arrived = WalkerController(config), [], False
    while not arrived and len(turned) < 100:
        obs, _, terminated, *_ = core.step(policy(obs, last(core)))
        turned.append(abs(last(core).next_state.pose[0, 2]))
        arrived = bool(terminated[0])
    assert arrived
    assert max(turned) < 0.1


def test_a_team_of_forces_without_a_lever_is_refused():
    body = Body.walker(grips=((0.0, 0.0), (0.0, 0.4)))
    config = find_config("coopenv/WalkerTurn-v0", {"body": body, "action": "force"})
    with pytest.raises(InvalidInput, match=r"body\.grips must give agent 0 a lever"):
        WalkerController(config)


def facing(front, *, speed=0.0, angle=0.0, push=0.0, dt=0.05, mass=25.0, reach=2.0):
    """The drive's force on a walker ``front`` metres from a wide box ahead of it."""
    box = Box(center=(0.5 + front + 1.0, 0.0), size=(2.0, 20.0))
    body = Body.walker(linear_drag=0.0, mass=mass)
    core = Transport(body=body, scene=Scene(size=OPEN.size, obstacles=(box,)), dt=dt)
    core.reset(seed=0, pose=(0, 0, angle), goal=(-9, 9, 0))
    core.world.twist[0] = speed * np.cos(angle), speed * np.sin(angle), 0.0
    before = last(core)
    state = replace(before.next_state, twist=core.world.twist)
    applied = np.array([[[push, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    return AvoidanceDrive(core.config, reach=reach)(
        replace(before, next_state=state, applied=applied)
    )[0]


def test_head_on_the_drive_follows_the_papers_formula_as_the_step_falls():
    for clearance, speed in ((0.3, 0.8), (0.5, 1.2), (1.5, 0.4)):
        wanted = -(1 / clearance - 1 / 2.0) / clearance**2 * speed
        assert facing(clearance, speed=speed, dt=1e-6) == pytest.approx(wanted, rel=1e-4)
        errors = [abs(facing(clearance, speed=speed, dt=dt) - wanted) for dt in (0.02, 0.01)]
        assert errors[1] < 0.6 * errors[0]  # first order in the step


def test_it_does_not_brake_beyond_its_reach_or_while_leaving():
    assert facing(2.5, speed=1.0) == 0.0
    assert facing(0.5, speed=-1.0) == 0.0
    assert facing(0.5, speed=1.0, reach=0.4) == 0.0
    assert facing(0.5) == 0.0


def test_it_opposes_the_approach_whichever_way_it_goes():
    ahead, behind = facing(0.3, speed=1.0), facing(0.3, speed=-1.0, angle=np.pi)
    assert ahead < 0 < behind
    assert behind == pytest.approx(-ahead, rel=1e-9)


def test_what_it_rolls_along_does_not_brake_it():
    scene = Scene(size=OPEN.size, obstacles=(Box(center=(0.0, 1.0), size=(20.0, 0.6)),))
    config = replace(find_config(IDS[0], {"scene": OPEN}), scene=scene)
    core = Transport(config=config)
    core.reset(seed=0, pose=(0, 0, 0), goal=(5, -5, 0))
    drive = AvoidanceDrive(config)
    for _ in range(20):
        assert drive(last(core))[0] == 0.0
        core.step([[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    assert drive.ways(last(core))[0].min() == pytest.approx(0.2, abs=1e-9)
    assert last(core).next_state.twist[0, 0] > 0.5


@pytest.mark.parametrize("clearance", [0.001, 0.01, 0.1])
def test_however_near_it_does_not_throw_the_walker_back(clearance):
    force = facing(clearance, speed=1.0)
    assert -25.0 * 1.0 / 0.05 <= force < 0.0  # at most what stops it within the step


def test_a_human_who_pushes_on_is_held_before_the_obstacle():
    scene = Scene(size=OPEN.size, obstacles=(Box(center=(2.5, 0.0), size=(1.0, 3.0)),))
    config = replace(find_config(IDS[0], {"scene": OPEN, "force_limit": 600.0}), scene=scene)
    core, drive = Transport(config=config), AvoidanceDrive(config)
    core.reset(seed=0, pose=(0, 0, 0), goal=(9, 9, 0))
    for _ in range(200):
        brake = drive(last(core))[0] / 600.0
        core.step([[[0.04, 0.0, 0.0], [max(brake, -1.0), 0.0, 0.0]]])
    assert 0.02 < drive.ways(last(core))[0].min() < 0.2
    assert abs(last(core).next_state.twist[0, 0]) < 0.02
    assert last(core).contact_impulse[0] == 0.0
    assert last(core).applied[0, 1, 0] == pytest.approx(-24.0, rel=0.02)


def test_each_world_is_led_by_itself():
    config = find_config(IDS[1], {})
    together = Transport(num_worlds=3, config=config)
    obs, _ = together.reset(seed=0)
    policy = WalkerController(config, gains=WalkerGains(speed=0.5), avoid=True)
    actions = policy(obs, last(together))
    for k in range(3):
        alone = Transport(config=config)
        obs, _ = alone.reset(seed=k)
        np.testing.assert_allclose(policy(obs, last(alone))[0], actions[k], atol=1e-12)
