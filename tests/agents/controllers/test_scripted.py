"""The scripted controllers of the other tasks: through the gap, and along the reference."""

from dataclasses import replace

import numpy as np
import pytest

from coopenv import Body, DoorwayTask, Scene, TrackingTask, Transport, TransportConfig
from coopenv.agents.controllers import find_controller
from coopenv.agents.controllers.doorway import DoorwayController
from coopenv.agents.controllers.impedance import ImpedanceController
from coopenv.agents.controllers.lift import LiftController
from coopenv.agents.controllers.tracking import TrackingController
from coopenv.agents.evaluate import evaluate
from coopenv.envs.registry import find_config
from coopenv.errors import UnknownName
from tests.helpers import LOOP, TRIO


def seen(env, episodes, method="moore_penrose", **keywords):
    config = find_config(f"coopenv/{env}-v0", keywords)
    return evaluate(find_controller(config, method=method), config, episodes=episodes)


def test_each_task_gets_its_own_controller():
    for env, kind in (
        ("BeamTransport", ImpedanceController),
        ("BeamDoorway", DoorwayController),
        ("BeamTracking", TrackingController),
        ("BeamLift", LiftController),
    ):
        assert type(find_controller(find_config(f"coopenv/{env}-v0", {}))) is kind
    with pytest.raises(UnknownName, match="nonsqueezing"):
        find_controller(TransportConfig(), method="non_squeezing")


def test_the_doorway_is_passed_without_squeezing_or_knocking():
    result = seen("BeamDoorway", 200)
    assert result.success_rate >= 0.99
    assert result.relative_cost < 1e-6
    assert result.contact_impulse < 0.05
    assert result.success_time < 6.0


@pytest.mark.parametrize(
    "keywords",
    [
        {"task": DoorwayTask(gap=(0.25, 0.3))},
        {"task": DoorwayTask(gap=(2.3, 2.5), gap_position=(-0.5, 0.5))},
        {"task": DoorwayTask(gap_position=(1.5, 1.6), gap=(0.6, 0.7))},
        {"body": TRIO, "decomposition": {"method": "moore_penrose"}},
        {"action": "force"},
        {"body": Body.beam(length=1.0, width=0.3, mass=15.0, linear_drag=0.0)},
        {"scene": Scene(size=(10.0, 8.0))},
    ],
    ids=["narrow", "wide", "in the corner", "trio", "forces", "heavy", "hall"],
)
def test_other_doorways_are_passed_as_well(keywords):
    assert seen("BeamDoorway", 40, horizon=600, **keywords).success_rate >= 0.95


def test_a_goal_on_the_same_side_is_reached_without_the_gap():
    config = find_config("coopenv/BeamDoorway-v0", {})
    core, policy = Transport(num_worlds=4, config=config), DoorwayController(config)
    obs, _ = core.reset(seed=0, pose=(-2.3, -0.5, 1.0), goal=(-2.2, 0.5, -1.0))
    for _ in range(120):
        assert core.transition is not None
        obs, *_ = core.step(policy(obs, core.transition), restart=core.transition.terminated)
        assert core.world.pose[:, 0].max() < -1.0
        if core.transition.success.all():
            return
    raise AssertionError("the goal was not reached")


@pytest.mark.parametrize("reference", ["minimum_jerk", "rotate", "translate", LOOP])
def test_references_are_followed_closely(reference):
    result = seen("BeamTracking", 100, task=TrackingTask(reference=reference, mean_tolerance=0.02))
    assert result.success_rate >= 0.99
    assert result.relative_cost < 1e-6


def test_tracking_falls_back_onto_the_reference_after_a_push():
    config = find_config("coopenv/BeamTracking-v0", {"body": Body(mass=3.0, linear_drag=2.0)})
    core, policy = Transport(num_worlds=20, config=config), TrackingController(config)
    core.reset(seed=0)
    assert core.transition is not None
    start = np.add(core.transition.next_state.pose, (0.2, -0.2, 0.3))
    obs, _ = core.reset(seed=0, pose=np.clip(start, -2.0, 2.0))
    for _ in range(100):
        obs, *_ = core.step(policy(obs, core.transition))
    assert core.transition.next_state.distance.max() < 0.02


def test_controllers_follow_the_bodies_of_the_episode():
    bodies = tuple(Body(mass=mass, linear_drag=drag) for mass, drag in ((4, 0), (8, 8), (12, 20)))
    config = find_config("coopenv/BeamTracking-v0", {"body": bodies})
    core, policy = Transport(num_worlds=3, config=config), TrackingController(config)
    obs, _ = core.reset(seed=0)
    for _ in range(100):
        assert core.transition is not None
        obs, *_ = core.step(policy(obs, core.transition))
    assert core.transition is not None
    assert core.transition.next_state.distance.max() < 0.01


class Loiterer:
    """Follows the reference, but at its end hovers beside it."""

    def __init__(self, config, beside):
        self.leader, self.beside = ImpedanceController(config), np.array(beside)

    def __call__(self, obs, transition):
        state = replace(transition.next_state, goal=transition.next_state.goal + self.beside)
        return self.leader(obs, replace(transition, next_state=state))


@pytest.mark.parametrize("env", ["BeamDoorway", "BeamTracking"])
def test_finishing_pays_more_than_loitering_with_the_default_reward(env):
    config = find_config(f"coopenv/{env}-v0", {})
    paid = []
    for beside, goal in (((0, 0, 0), True), ((0.0, 0.25, 0.0), False), ((0, 0, 0.3), False)):
        core, policy = Transport(num_worlds=5, config=config), Loiterer(config, beside)
        if env == "BeamDoorway":  # the gap is behind it
            obs, _ = core.reset(seed=0, pose=(2.4, 0, 0), goal=(2.4, 0.5, 0.5))
        else:
            obs, _ = core.reset(seed=0)
        total, running = np.zeros((5, 2)), np.ones(5, dtype=bool)
        for step in range(core.horizon):
            assert core.transition is not None
            over = core.transition.terminated | core.transition.truncated
            obs, reward, terminated, *_ = core.step(policy(obs, core.transition), restart=over)
            worth = np.where(running, reward.mean(axis=1), 0)
            total += worth[:, None] * np.power([1.0, 0.99], step)  # two discounts
            running &= ~terminated
        assert (~running).all() == goal
        paid.append(total)
    assert (paid[0] > paid[1] + 0.2).all()
    assert (paid[0] > paid[2] + 0.2).all()
