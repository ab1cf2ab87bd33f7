"""Gravity and ground friction drawn anew in every episode: what is drawn, and what it moves."""

from typing import Any

import numpy as np
import pytest

from coopenv import Body, Ranges, Scene, Transport, TransportConfig
from coopenv.agents.controllers import find_controller
from coopenv.agents.evaluate import run_episodes
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from tests.helpers import BLIND_TO_HANDS, UPRIGHT, actions, assert_same

G = 9.81
HALL = Scene(size=(90.0, 90.0), gravity=(1.5, -G))
LIFT = "coopenv/BeamLift-v0"


def test_gravity_is_drawn_for_every_world_and_episode_along_that_of_the_scene():
    core = Transport(num_worlds=64, scene=HALL, randomise=Ranges(gravity=(2.0, 12.0)))
    _, first = core.reset(seed=0)
    _, info = core.reset()
    drawn = info["body/gravity"]
    assert 2.0 <= drawn.min() < 2.5
    assert 11.5 < drawn.max() <= 12.0
    assert (drawn != first["body/gravity"]).all()
    pulled = core.conditions.room.gravity
    np.testing.assert_allclose(np.hypot(*pulled.T), drawn, rtol=1e-12)
    np.testing.assert_allclose(pulled[:, 0] / pulled[:, 1], 1.5 / -G, rtol=1e-12)
    assert [scene.gravity for scene in core.scenes] == [tuple(row) for row in pulled.tolist()]


def test_a_logarithmic_gravity_has_its_geometric_mean_in_the_middle():
    ranges = Ranges(gravity=(1.0, 16.0), logarithmic=("gravity",))
    assert ranges.scene(HALL, 0.5).gravity == pytest.approx(HALL.with_gravity(4.0).gravity)
    assert Ranges(gravity=(1.0, 16.0)).scene(HALL, 0.5) == HALL.with_gravity(8.5)
    assert Ranges().scene(HALL, 0.5) is HALL


def test_bodies_fall_as_the_drawn_gravity_says():
    ranges = Ranges(gravity=(0.0, 20.0), mass=(2.0, 20.0))
    core = Transport(num_worlds=16, scene=HALL, randomise=ranges)
    _, info = core.reset(seed=1, pose=(0, 30, 0), goal=(9, 9, 0))
    for _ in range(10):
        core.step(np.zeros((16, 2, 3)))
    rate = 8.0 / info["body/mass"]  # [1/s], of the default drag
    speed = info["body/gravity"] / rate * (1 - np.exp(-rate * 10 * core.dt))
    np.testing.assert_allclose(np.hypot(*core.world.twist[:, :2].T), speed, rtol=1e-9)
    assert np.ptp(speed) > 1.0


def test_a_push_moves_what_the_drawn_friction_does_not_hold():
    body = Body(linear_drag=0.0, angular_drag=0.0)
    core = Transport(num_worlds=32, body=body, randomise=Ranges(ground_friction=(0.0, 0.6)))
    _, info = core.reset(seed=2, pose=(0, 0, 0), goal=(2, 2, 0))
    push = np.zeros((32, 2, 3))
    push[:, 0, 0], push[:, 1, 0] = 1.0, -1.0  # both 10 N along x
    core.step(push)
    kept = info["body/ground_friction"] * body.mass * G  # [N]
    speed = np.maximum(20.0 - kept, 0.0) / body.mass * core.dt
    np.testing.assert_allclose(core.world.twist[:, 0], speed, rtol=1e-9, atol=0)
    assert 0 < (speed == 0).sum() < 32


@pytest.mark.parametrize(
    "keywords",
    [
        {"scene": UPRIGHT, "randomise": Ranges(gravity=(1.0, 12.0))},
        {"randomise": Ranges(ground_friction=(0.0, 0.4), mass=(4.0, 9.0))},
    ],
    ids=["gravity", "friction"],
)
def test_an_episode_is_the_same_in_a_used_world_and_from_a_state(keywords):
    core, fresh = (Transport(num_worlds=4, **keywords) for _ in "ab")
    core.reset(seed=3)
    for action in actions(1, 20, 4, 2, 3):
        core.step(action)
    for k in range(4):
        seeds = [8 + j if j == k else None for j in range(4)]
        core.reset(seed=seeds, mask=np.arange(4) == k)
    fresh.reset(seed=8)
    kept = core.get_state()
    steps = [core.step(action) for action in actions(2, 12, 4, 2, 3)]
    for action, step in zip(actions(2, 12, 4, 2, 3), steps, strict=True):
        assert_same(step, fresh.step(action))
    core.reset(seed=20)
    core.set_state(kept)
    assert_same(core.conditions.parameters(), fresh.conditions.parameters())


def test_the_strongest_gravity_that_may_be_drawn_bounds_the_speed():
    seen = {
        name: Transport(bounded=True, observe=BLIND_TO_HANDS, **keywords).observation.high
        for name, keywords in {
            "drawn": {"scene": UPRIGHT, "randomise": Ranges(gravity=(1.0, 40.0))},
            "fixed": {"scene": UPRIGHT.with_gravity(40.0)},
            "weaker": {"scene": UPRIGHT},
        }.items()
    }
    np.testing.assert_array_equal(seen["drawn"], seen["fixed"])
    assert (seen["drawn"] > seen["weaker"]).any()


def test_a_beam_is_lifted_whatever_it_weighs():
    config = find_config(LIFT, {"randomise": Ranges(gravity=(1.6, 12.0))})
    seen = run_episodes(find_controller(config), config, episodes=24)
    assert seen.success.all()


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"gravity": (0.0, -1.0)}, r"randomise\.gravity must"),
        ({"gravity": (-1.0, 1.0)}, r"randomise\.gravity must not begin below zero"),
        ({"gravity": (1.0, 1e7)}, r"randomise\.gravity must not end above 1e\+06"),
        ({"gravity": (1.0, 2.0)}, r"scene\.gravity must have a direction .* got \(0\.0, 0\.0\)"),
        ({"ground_friction": (-0.1, 1)}, r"randomise\.ground_friction must not begin below zero"),
        (
            {"gravity": (0.0, 2.0), "logarithmic": ("gravity",)},
            r"randomise\.gravity must begin above zero to be drawn log-uniformly",
        ),
    ],
)
def test_a_range_that_cannot_be_drawn_from_is_refused(keywords, said):
    with pytest.raises(InvalidInput, match=said):
        TransportConfig(randomise=Ranges(**keywords))


ROUGH = Ranges(ground_friction=(0.0, 0.3))


@pytest.mark.parametrize(
    ("view", "keywords", "said"),
    [
        ("coopenv/WalkerTurn-v0", {"randomise": ROUGH}, r"randomise\.ground_friction .* on wheels"),
        (LIFT, {"randomise": ROUGH}, r"randomise\.ground_friction must come with a scene\.normal"),
        (
            LIFT,
            {"randomise": Ranges(gravity=(0.0, 9.81))},
            r"randomise must leave the task possible: scene\.gravity must point straight down",
        ),
    ],
)
def test_ranges_that_do_not_go_with_the_rest_are_refused(view, keywords: dict[str, Any], said):
    with pytest.raises(InvalidInput, match=said):
        find_config(view, keywords)
