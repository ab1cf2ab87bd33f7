"""Impedance control: the object arrives, without squeezing, within the agents' limits."""

import numpy as np
import pytest

from coopenv import Body, Scene, Transport, TransportConfig
from coopenv.agents.controllers import Gains, ImpedanceController
from coopenv.agents.evaluate import evaluate, run_episodes
from coopenv.errors import UnknownName
from coopenv.wrench import Settings
from coopenv.wrench.grasp import sum_at_centre
from tests.helpers import TRIO

METHODS = ("moore_penrose", "nonsqueezing", "parametrized")


def last(core):
    assert core.transition is not None
    return core.transition


def worst_relative_cost(config, policy, *, worlds, steps):
    """Largest γ of any world in any step, worlds starting anew as they end."""
    core = Transport(num_worlds=worlds, config=config)
    obs, _ = core.reset(seed=0)
    worst = 0.0
    restart = np.zeros(worlds, dtype=np.bool_)
    for _ in range(steps):
        obs, _, terminated, truncated, info = core.step(policy(obs, last(core)), restart=restart)
        worst = max(worst, float(info["relative_cost"].max()))
        restart = terminated | truncated
    return worst


def test_the_scripted_pair_arrives_and_never_squeezes():
    config = TransportConfig()
    seen = evaluate(ImpedanceController(config), config, episodes=500)
    assert seen.success_rate >= 0.99
    assert seen.relative_cost < 1e-6
    assert seen.success_time < 3.0
    worst = worst_relative_cost(config, ImpedanceController(config), worlds=500, steps=120)
    assert worst < 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_every_allocation_arrives(method: str):
    config = TransportConfig()
    seen = evaluate(ImpedanceController(config, method=method), config, episodes=100)
    assert seen.success_rate >= 0.99


def test_the_nonsqueezing_split_is_not_free_of_internal_torque():
    config = TransportConfig()
    seen = evaluate(ImpedanceController(config, method="nonsqueezing"), config, episodes=100)
    assert seen.internal_torque_level > 0.5
    assert seen.internal_force_level < 1e-6


@pytest.mark.parametrize(
    "keywords",
    [
        {"action": "force"},
        {"body": TRIO, "decomposition": Settings(method="moore_penrose")},  # for speed
        {"body": Body.beam(length=1.0, mass=20.0, linear_drag=0.0, angular_drag=0.0)},
        {"body": Body(outline=((-0.6, -0.4), (0.9, 0.0), (-0.6, 0.4)))},
        {"force_limit": (4.0, 12.0), "torque_limit": (5.0, 1.0)},
        {"scene": Scene(size=(2.5, 9.0))},
    ],
    ids=["forces", "trio", "heavy", "triangle", "uneven", "corridor"],
)
def test_it_arrives_with_other_teams_bodies_and_rooms(keywords):
    config = TransportConfig(**keywords, horizon=600)
    seen = evaluate(ImpedanceController(config), config, episodes=60)
    assert seen.success_rate >= 0.99


def test_each_world_is_led_by_its_own_body_and_room():
    bodies = (Body(), Body.beam(length=1.0, mass=3.0), Body(outline=((-0.5, -0.3), (1, 0), (0, 1))))
    scenes = (Scene(), Scene(size=(8.0, 4.0)), Scene(size=(4.0, 4.0)))
    mixed = TransportConfig(body=bodies, scene=scenes)
    core = Transport(num_worlds=3, config=mixed)
    obs, _ = core.reset(seed=0)
    together = ImpedanceController(mixed)(obs, last(core))
    for k in range(3):
        own = TransportConfig(body=bodies[k], scene=scenes[k])
        alone = Transport(num_worlds=1, config=own)
        obs, _ = alone.reset(seed=k)
        np.testing.assert_allclose(
            ImpedanceController(own)(obs, last(alone))[0], together[k], atol=1e-12
        )


def test_a_limit_scales_all_agents_together():
    config = TransportConfig(force_limit=(2.0, 10.0), torque_limit=(5.0, 0.5))
    policy = ImpedanceController(config)
    core = Transport(num_worlds=200, config=config)
    obs, _ = core.reset(seed=0)
    action = policy(obs, last(core))
    wanted = policy.object_wrench(last(core))
    assert np.abs(action).max() <= 1.0 + 1e-12
    assert (np.abs(action).max(axis=(1, 2)) > 0.999).any()
    core.step(action)
    reached = sum_at_centre(last(core).applied, core.team.grips)
    parallel = np.einsum("ki,ki->k", reached, wanted)
    lengths = np.linalg.norm(reached, axis=1) * np.linalg.norm(wanted, axis=1)
    np.testing.assert_allclose(parallel, lengths, rtol=1e-9)


def test_it_is_stateless_and_does_not_touch_what_it_reads():
    config = TransportConfig()
    policy = ImpedanceController(config, gains=Gains(speed=1.0))
    core = Transport(num_worlds=4, config=config)
    obs, _ = core.reset(seed=0)
    before = last(core).next_state.pose.copy()
    first = policy(obs, last(core))
    np.testing.assert_array_equal(first, policy(obs, last(core)))
    np.testing.assert_array_equal(before, last(core).next_state.pose)


def test_it_keeps_off_the_walls():
    config = TransportConfig()
    seen = run_episodes(ImpedanceController(config), config, episodes=200)
    assert (seen.contact_impulse > 0).mean() < 0.02


def test_an_unknown_allocation_is_refused():
    with pytest.raises(UnknownName, match="moore_penrose"):
        ImpedanceController(TransportConfig(), method="moore")
