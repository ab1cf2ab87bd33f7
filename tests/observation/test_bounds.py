"""Finite bounds of observations: where they come from, that they hold, and what is clipped."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box as BoxSpace
from pettingzoo.test import parallel_api_test

from coopenv import (
    BLOCKS,
    Actuators,
    Block,
    Body,
    Ranges,
    Scene,
    Sensor,
    Transport,
    TransportConfig,
    TransportTask,
    beam_transport_v0,
)
from coopenv.envs.registry import find_config
from coopenv.errors import InvalidInput
from coopenv.observation.bounds import Bounds
from tests.helpers import ALONG, BLIND_TO_HANDS, IDS, NEVER, OPEN_ROOM, TRIO, actions

EVERYTHING = {
    "coopenv/BeamDoorway-v0": ("gap",),
    "coopenv/BeamTracking-v0": ("preview", "reference_twist"),
    "coopenv/WalkerAvoid-v0": ("nearest", "course"),
    "coopenv/BeamLift-v0": ("hurdle", "down"),
}


@pytest.mark.parametrize("view", IDS)
def test_every_feature_has_ends_and_nothing_else_changes(view):
    blocks = (*BLIND_TO_HANDS, *EVERYTHING.get(view, ()))
    loose, tight = (
        Transport(num_worlds=3, config=find_config(view, {"observe": blocks, "bounded": bounded}))
        for bounded in (False, True)
    )
    assert np.isfinite([tight.observation.low, tight.observation.high]).all()
    assert (tight.observation.low < tight.observation.high).all()
    seen, info = tight.reset(seed=0)
    np.testing.assert_array_equal(seen, loose.reset(seed=0)[0])
    for action in actions(0, 30, 3, 2, 3):
        seen, *_, info = tight.step(action)
        np.testing.assert_array_equal(seen, loose.step(action)[0])
        assert not info["observation_clipped"].any()
    assert "observation_clipped" not in loose.reset(seed=0)[1]


def test_actuators_are_not_taken_for_hands():
    plain = TransportConfig(bounded=True).bounds()
    behind = TransportConfig(bounded=True, actuators=Actuators(time_constant=0.1)).bounds()
    assert plain is not None
    assert behind is not None
    for block in BLOCKS.values():
        if not block.needs_hands:
            np.testing.assert_array_equal(behind.ends(block, 2), plain.ends(block, 2))


def test_bounds_are_those_of_room_and_limits():
    config = TransportConfig(
        bounded=True, scene=Scene(size=(6.0, 8.0)), force_limit=(10.0, 20.0), torque_limit=3.0
    )
    seen = Transport(config=config).observation
    high = {name: seen.high[where] for name, where in seen.blocks.items()}
    np.testing.assert_allclose(high["goal"], [10.0, 10.0, 1.0, 1.0])
    np.testing.assert_allclose(high["own_wrench"], [20.0, 20.0, 3.0])
    np.testing.assert_allclose(high["partner_wrench"], [20 * 2**0.5, 20 * 2**0.5, 3.0], rtol=1e-6)
    np.testing.assert_allclose(seen.low[seen.blocks["goal"]], -high["goal"])
    assert high["load_share"].tolist() == [1.0, 1.0]
    assert seen.low[seen.blocks["load_share"]].tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    "body",
    [
        Body(),
        Body(linear_drag=0.0, angular_drag=0.0),
        Body(linear_drag=0.0),
        Body(linear_drag=1e-300, angular_drag=1e-300),
        Body.walker(),
    ],
    ids=["beam", "no drag", "no linear drag", "next to no drag", "walker"],
)
def test_nobody_is_faster_than_the_bound_and_it_is_not_far(body):
    config = TransportConfig(
        body=body, bounded=True, scene=OPEN_ROOM, task=NEVER, horizon=40, observe=("twist",)
    )
    fastest = np.zeros(2)
    for push in ([[1, 1, 0], [-1, -1, 0]], [[0, -1, 1], [0, -1, 1]]):  # all one way; all round
        core = Transport(config=config)
        core.reset(seed=0, pose=(0, 0, 0))
        for _ in range(config.horizon):
            *_, info = core.step([push])
            assert not info["observation_clipped"].any()
            assert core.transition is not None
            x, y, spin = core.transition.next_state.twist[0]
            fastest = np.maximum(fastest, [np.hypot(x, y), abs(spin)])
    bound = core.observation.high[0], core.observation.high[2]
    assert (fastest <= bound).all()
    if body in (Body(), Body(linear_drag=0.0, angular_drag=0.0)):  # else walls could give far more
        assert (fastest > np.array(bound) / 5).all()


def test_speeds_are_bounded_by_the_box_round_the_ellipse_in_which_energy_grows():
    body, limits = Body(linear_drag=4.0, angular_drag=0.5), np.array([[10.0, 5.0], [6.0, 2.0]])
    found = Bounds.of((body,), (Scene(),), limits, None, 1e9, dt=0.05).by_unit
    forces = np.sqrt(2) * limits[:, 0]
    force, torque = forces.sum(), (limits[:, 1] + 0.9 * forces).sum()
    drag, spin_drag = body.linear_drag, body.angular_drag
    reach = force**2 / drag / 4 + torque**2 / spin_drag / 4  # c (v − F/2c)² + d (ω − T/2d)²
    speed = force / drag / 2 + np.sqrt(reach / drag)
    spin = torque / spin_drag / 2 + np.sqrt(reach / spin_drag)
    assert body.inertia is not None
    energy = body.mass * speed**2 / 2 + body.inertia * spin**2 / 2
    assert found["m/s"] == pytest.approx(np.sqrt(2 * energy / body.mass), rel=1e-9)
    assert found["rad/s"] == pytest.approx(np.sqrt(2 * energy / body.inertia), rel=1e-9)


def test_what_is_drawn_stays_within_the_bounds():
    core = Transport(
        num_worlds=50, bounded=True, randomise=ALONG, observe=BLIND_TO_HANDS, body=TRIO
    )
    seen, info = core.reset(seed=0)
    for action in actions(1, 20, 50, 3, 3):
        assert not info["observation_clipped"].any()
        seen, *_, info = core.step(3 * action)
    body = core.observation.blocks["body"]
    assert (seen[..., body] <= core.observation.high[body]).all()
    assert (core.observation.high[body][:6] < [12.1, 3.1, 12.1, 12.1, 0.51, 2.21]).all()


@pytest.mark.parametrize(("name", "most"), [("force_limit", 33.0), ("torque_limit", 9.0)])
def test_where_limits_are_drawn_the_bounds_are_those_of_the_largest(name, most):
    span: dict[str, Any] = {name: (0.5, most)}
    given: tuple[dict[str, Any], ...] = ({"randomise": Ranges(**span)}, {name: most})
    drawn, fixed = (
        Transport(bounded=True, observe=BLIND_TO_HANDS, **keywords).observation
        for keywords in given
    )
    np.testing.assert_allclose(drawn.high, fixed.high, rtol=1e-6)
    np.testing.assert_allclose(drawn.low, fixed.low, rtol=1e-6)


@pytest.mark.parametrize(
    "pair",
    [
        ({"mass": 1.0}, {"mass": 30.0}),
        ({"inertia": 0.1}, {"inertia": 10.0}),
        ({"linear_drag": 1.0}, {"linear_drag": 30.0}),
        ({"angular_drag": 1.0}, {"angular_drag": 30.0}),
        ({"mass": 1.0, "inertia": 10.0}, {"mass": 10.0, "inertia": 0.1}),
    ],
    ids=["mass", "inertia", "linear drag", "angular drag", "light and heavy"],
)
def test_bounds_of_several_bodies_hold_for_each_of_them(pair):
    bodies = tuple(Body(**fields) for fields in pair)
    several, *each = (
        Transport(num_worlds=2, bounded=True, body=body, observe=("twist", "body")).observation.high
        for body in (bodies, *bodies)
    )
    assert (several >= np.max(each, axis=0) * (1 - 1e-6)).all()
    assert (several <= np.max(each, axis=0) * 35).all()


def test_a_reading_beyond_its_bound_is_clipped_and_that_is_told():
    noisy = Sensor("goal", noise=30.0)
    core = Transport(num_worlds=40, bounded=True, observe=(noisy, "twist"))
    seen, info = core.reset(seed=0)
    goal = core.observation.blocks["goal"]
    at_end = (np.abs(seen[..., goal]) == core.observation.high[goal]).any(axis=-1)
    assert at_end.sum() > 0
    np.testing.assert_array_equal(info["observation_clipped"], at_end)


def test_the_flag_of_each_agent_is_in_every_view():
    keywords = {"bounded": True, "observe": (Sensor("twist", noise=50.0),)}
    _, info = gymnasium.make("coopenv/BeamTransport-v0", **keywords).reset(seed=0)
    assert info["observation_clipped"].shape == (2,)
    _, told = beam_transport_v0.parallel_env(**keywords).reset(seed=0)
    flags = [told[agent]["observation_clipped"] for agent in ("agent_0", "agent_1")]
    assert flags == info["observation_clipped"].tolist()
    assert any(flags)


def test_a_block_without_a_known_unit_needs_bounds_of_its_own():
    def heat(transition):
        return transition.per_agent(transition.next_state.time)[..., None]

    named = {"name": "heat", "size": 1, "describe": "", "read": heat}
    with pytest.raises(InvalidInput, match=r"'heat' in the unit 'K'; give the block low= and high"):
        Transport(bounded=True, observe=("goal", Block(**named, unit="K")))
    bounded = Block(**named, unit="K", low=0.0, high=2.5)
    core = Transport(bounded=True, observe=("goal", bounded))
    assert core.observation.high[-1] == 2.5
    half = Block(**named, unit="m/s", low=0.0)  # the missing end by its unit
    core = Transport(bounded=True, observe=(half,))
    assert core.observation.low[0] == 0.0
    assert 0 < core.observation.high[0] < np.inf


def test_pettingzoo_has_nothing_to_remark_about_the_bounds():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", ".*(all zeros|it has no effect)")
        parallel_api_test(beam_transport_v0.parallel_env(bounded=True), num_cycles=20)


def test_a_wrapper_that_scales_to_the_ends_works():
    env = gymnasium.make("coopenv/BeamTransport-v0", bounded=True)
    scaled = gymnasium.wrappers.RescaleObservation(env, np.float32(-1.0), np.float32(1.0))
    seen, _ = scaled.reset(seed=0)
    assert np.abs(seen).max() <= 1.0 + 1e-6
    assert isinstance(scaled.observation_space, BoxSpace)


def test_only_true_and_false_say_whether_it_is_bounded():
    with pytest.raises(InvalidInput, match="bounded must be True or False, got 'yes'"):
        TransportConfig(bounded="yes")  # pyright: ignore[reportArgumentType]


def test_limits_that_are_drawn_bound_the_wrenches():
    core = Transport(bounded=True, randomise=Ranges(force_limit=(5.0, 33.0)), task=TransportTask())
    high = core.observation.high[core.observation.blocks["own_wrench"]]
    assert high.tolist() == [33.0, 33.0, 5.0]
