"""Surroundings as an effector: what agents waste against walls and wheels, in an environment."""

import pickle
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec

import coopenv
from coopenv import Body, Hands, Ranges, Scene, Transport, TransportConfig, rewards, wrench
from coopenv.errors import InvalidInput
from coopenv.physics.surroundings import acting
from coopenv.render import Renderer
from coopenv.transition import Transition
from tests.helpers import NEVER, OPEN_ROOM, TRIO, actions, assert_same

WITH, WITHOUT = wrench.Settings(surroundings=True), wrench.Settings()
ROOM = Scene(size=(6.0, 6.0))
UPRIGHT = (2.9, 0.0, np.pi / 2)  # a beam along the right wall
SMOOTH = Body.beam(friction=0.0)


def started(settings=WITH, num_worlds=1, **keywords: Any) -> Transport:
    keywords = {"scene": ROOM, "task": NEVER, "horizon": 10**6, **keywords}
    pose = keywords.pop("pose", UPRIGHT)
    core = Transport(num_worlds=num_worlds, decomposition=settings, **keywords)
    core.reset(seed=0, pose=np.broadcast_to(np.array(pose, dtype=float), (num_worlds, 3)))
    return core


def after(core: Transport, action, steps: int) -> dict[str, Any]:
    info: dict[str, Any] = {}
    for _ in range(steps):
        *_, info = core.step(action)
    return info


def last(core: Transport) -> Transition:
    assert core.transition is not None
    return core.transition


# In the agents' frames, of which one looks along the beam and one back: into the wall.
INTO = {
    "wrench": [[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]],
    "force": [[[0.0, -1.0], [0.0, 1.0]]],
    "motion": [[[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]],
    "impedance": [[[0.0, -1.0, 0.0, 0.5, 0.5], [0.0, 1.0, 0.0, 0.5, 0.5]]],
    "discrete": [[4, 3]],
}


@pytest.mark.parametrize("action", list(INTO))
def test_who_push_a_wall_waste_everything(action):
    push = np.array(INTO[action])
    info = after(started(action=action), push, 60)
    bare = after(started(WITHOUT, action=action), push, 60)
    assert info["relative_cost"][0] == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(info["manipulation_wrench"], 0.0, atol=2e-2)
    force = info["internal_wrench"][0, :, 1]
    assert (force < -5.0).all()
    assert info["surroundings_wrench"].shape == (1, 3)
    np.testing.assert_allclose(info["surroundings_wrench"][0, 1], -force.sum(), rtol=1e-3)
    assert info["internal_force_level"][0] == pytest.approx(-force.sum(), rel=1e-3)
    assert bare["relative_cost"][0] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_array_equal(bare["surroundings_wrench"], info["surroundings_wrench"])


@pytest.mark.parametrize(("friction", "told"), [(0.1, 0.767), (0.2, 0.393), (0.3, 0.0)])
def test_what_rough_ground_bears_of_a_push_at_a_wall_is_not_counted_as_waste(friction, told):
    """At rest the ground takes F = μ m g of 2 · 10 N, the wall the rest, which alone cancels."""
    core = started(body=Body(ground_friction=friction))
    info = after(core, np.array(INTO["wrench"]), 80)
    most = friction * 7.7 * 9.81
    borne = min(most, 20.0)
    assert info["relative_cost"][0] == pytest.approx(1 - borne / (40.0 - borne), abs=1e-4)
    assert info["relative_cost"][0] == pytest.approx(told, abs=1e-3)
    np.testing.assert_allclose(info["surroundings_wrench"][0, 1], 20.0 - borne, atol=1e-4)
    np.testing.assert_allclose(core.world.twist, 0.0, atol=1e-12)


@pytest.mark.parametrize(("friction", "told"), [(0.1, 0.558), (0.2, -0.153)])
def test_point_mass_counts_torques_that_nobody_applied_and_may_fall_below_zero(friction, told):
    core = started(replace(WITH, method="point_mass"), body=Body(ground_friction=friction))
    info = after(core, np.array(INTO["wrench"]), 80)
    split = last(core).decomposition
    added = np.abs(split.manipulation[0, :, 2]).sum()
    assert not last(core).applied[..., 2].any()
    assert added > 1.0
    paid = (np.abs(split.manipulation[0, :, :2]).sum() + added) / 2  # at w = 0.5 [N]
    assert info["relative_cost"][0] == pytest.approx(1 - paid / split.applied_cost[0], abs=1e-9)
    assert info["relative_cost"][0] == pytest.approx(told, abs=1e-3)


def test_who_push_wheels_sideways_waste_everything():
    body = Body.walker(grips=((-0.5, 0.0), (0.5, 0.0)))
    core = started(body=body, pose=(0.0, 0.0, 0.3))
    info = after(core, np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]]), 3)
    assert info["relative_cost"][0] == pytest.approx(1.0, abs=1e-9)
    assert core.world.twist[0].tolist() == [0.0, 0.0, 0.0]
    assert info["contact_impulse"].tolist() == [0.0]
    wanted = -last(core).applied[0, :, 1].sum()
    np.testing.assert_allclose(info["surroundings_wrench"], [[0.0, wanted, 0.0]], atol=1e-12)
    assert last(core).wheel_force.tolist() == info["surroundings_wrench"][:, 1].tolist()


def test_who_slide_along_a_wall_waste_what_presses_on_it():
    """f = (a, b) each: b and the wall's −2b cancel, which leaves (a, 0) each, in their balls."""
    core = started(body=SMOOTH, pose=(-4.0, 2.95, 0.0), scene=Scene(size=(40.0, 6.0)))
    info = after(core, np.array([[[0.8, 0.6, 0.0], [-0.8, -0.6, 0.0]]]), 100)
    along, across = last(core).applied[0, 0, :2]
    assert core.world.twist[0, 0] > 0.5
    wanted = 1 - 2 * along / (2 * np.hypot(along, across) + 2 * across)
    assert info["relative_cost"][0] == pytest.approx(wanted, abs=1e-5)
    np.testing.assert_allclose(info["manipulation_wrench"][0, :, 0], along, rtol=1e-4)
    np.testing.assert_allclose(info["manipulation_wrench"][0, :, 1], 0.0, atol=1e-3)


@pytest.mark.parametrize("body", [Body.beam(), TRIO], ids=["pair", "trio"])
@pytest.mark.parametrize("randomise", [None, Ranges(length=(1.0, 2.0))], ids=["alike", "drawn"])
def test_where_nothing_touches_all_is_as_without_to_the_bit(body, randomise):
    if body is TRIO and randomise is not None:
        randomise = Ranges(mass=(1.0, 2.0))
    made = [
        started(settings, 3, body=body, scene=OPEN_ROOM, pose=(0, 0, 0), randomise=randomise)
        for settings in (WITH, WITHOUT)
    ]
    for push in actions(1, 12, 3, body.num_agents, 3):
        together, alone = (core.step(push) for core in made)
        assert_same(together, alone)
        assert list(together[-1]) == list(alone[-1])
    both, alone = (last(core).decomposition for core in made)
    num_agents = body.num_agents
    assert both.applied.shape == (3, num_agents + 1, 3)
    assert not both.applied[:, num_agents].any()
    assert not both.internal[:, num_agents].any()
    np.testing.assert_array_equal(both.internal[:, :num_agents], alone.internal)
    np.testing.assert_array_equal(both.gap, alone.gap)
    np.testing.assert_array_equal(both.fell_back, alone.fell_back)
    assert both.solver == alone.solver


@pytest.mark.parametrize("method", ["optimal", "point_mass"])
@pytest.mark.parametrize("randomise", [None, Ranges(length=(1.0, 2.0))], ids=["alike", "drawn"])
def test_each_world_is_decomposed_with_what_it_touches_and_no_other(method, randomise):
    core = Transport(
        num_worlds=4, scene=ROOM, task=NEVER, decomposition=replace(WITH, method=method),
        randomise=randomise,
    )  # fmt: skip
    pose = np.array([UPRIGHT, (0.0, 0.0, 0.0), (-2.9, 0.3, np.pi / 2), (0.0, 1.0, 0.3)])
    core.reset(seed=0, pose=pose)
    push = 0.2 * actions(0, 1, 4, 2, 3)[0] + np.array(INTO["wrench"])
    after(core, push, 15)
    step = last(core)
    touched = np.any(step.surroundings_wrench != 0.0, axis=1)
    assert 0 < np.sum(touched) < 4
    split, outline = step.decomposition, core.conditions.load.outline
    there, place = acting(step.surroundings_wrench.copy(), step.wheel_force.copy(), outline)
    for k in range(4):
        applied, grips = step.applied[k], step.team.grips[k]
        if touched[k]:
            applied = np.concatenate([applied, there[k : k + 1]])
            grips = np.concatenate([grips, place[k : k + 1]])
        alone = wrench.decompose(applied, grips, method=method)
        np.testing.assert_array_equal(split.manipulation[k, : len(grips)], alone.manipulation)
        assert split.relative_cost[k] == alone.relative_cost
        assert split.internal_torque_level[k] == alone.internal_torque_level
        assert split.gap[k] == alone.gap
    residuals = split.residuals()
    assert np.max(residuals.balance) < 1e-9


def test_agents_that_change_places_change_their_parts_and_nothing_else():
    pushes = np.array([[[0.4, -1.0, 0.3], [0.2, 0.5, -0.1]]])
    grips = ((-0.9, 0.0), (0.6, 0.02))
    one = started(body=Body(grips=grips))
    other = started(body=Body(grips=grips[::-1]))
    first, second = after(one, pushes, 25), after(other, pushes[:, ::-1], 25)
    assert first["surroundings_wrench"].any()
    for name in ("relative_cost", "wasted_cost", "internal_force_level", "surroundings_wrench"):
        np.testing.assert_allclose(first[name], second[name], rtol=1e-6, atol=1e-6)
    for name in ("internal_wrench", "force_load_share"):
        np.testing.assert_allclose(first[name], second[name][:, ::-1], rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_room_that_is_turned_changes_nothing(turns):
    angle = turns * np.pi / 2
    c, s = np.cos(angle), np.sin(angle)
    x, y, heading = UPRIGHT
    pushes = np.array([[[0.4, -1.0, 0.3], [0.2, 0.5, -0.1]]])
    one = after(started(), pushes, 25)
    other = after(started(pose=(c * x - s * y, s * x + c * y, heading + angle)), pushes, 25)
    assert one["surroundings_wrench"].any()
    for name in ("surroundings_wrench", "internal_wrench", "relative_cost", "wasted_cost"):
        np.testing.assert_allclose(one[name], other[name], rtol=1e-6, atol=1e-6)


def test_what_is_told_of_agents_has_a_row_for_each_agent_and_no_more():
    core = started(body=Body(friction=1.0))
    bare = started(WITHOUT, body=Body(friction=1.0))
    pushes = np.array([[[0.4, -1.0, 0.3], [0.2, 0.5, -0.1]]])
    after(core, pushes, 24)
    seen, *_, info = core.step(pushes)
    without = after(bare, pushes, 25)
    assert info["surroundings_wrench"].any()
    for name in ("internal_wrench", "manipulation_wrench"):
        assert info[name].shape == (1, 2, 3)
    np.testing.assert_allclose(
        info["internal_wrench"] + info["manipulation_wrench"], last(core).applied, atol=1e-12
    )
    for name in ("force_load_share", "force_load_share_defined", "torque_load_share"):
        np.testing.assert_array_equal(info[name], without[name])  # of what agents apply together
    assert seen.shape == (1, 2, core.observation.size)
    where = core.observation.blocks["own_internal"]
    frame, internal = last(core).team.frame[0], info["internal_wrench"][0]
    along = (frame * internal[:, :2]).sum(axis=-1)
    np.testing.assert_allclose(seen[0, :, where.start], along, rtol=1e-5)


def test_rewards_may_ask_for_surroundings_that_the_environment_does_not_count():
    terms = {
        "force": rewards.InternalForce(weight=1.0, settings=WITH),
        "torque": rewards.InternalTorque(weight=1.0, settings=WITH),
        "relative": rewards.RelativeCost(weight=1.0, settings=WITH),
        "wasted": rewards.WastedCost(weight=1.0, scale=1.0, settings=WITH),
        "share": rewards.LoadShare(weight=1.0),
    }
    core = started(WITHOUT, reward=rewards.RewardSum(terms))
    info = after(core, np.array(INTO["wrench"]), 60)
    told = info["reward_terms"]
    force = np.abs(last(core).applied[0, 0, 1])
    np.testing.assert_allclose(told["force"], -force, rtol=1e-3)
    np.testing.assert_allclose(told["torque"], -0.9 * force, rtol=1e-3)
    np.testing.assert_allclose(told["relative"], -1.0, atol=1e-4)
    np.testing.assert_allclose(told["wasted"], -2 * force, rtol=1e-3)  # at w = 0.5 half of 4 forces
    np.testing.assert_allclose(told["share"], 0.0, atol=1e-9)
    assert info["relative_cost"][0] == pytest.approx(0.0, abs=1e-9)
    same = started(WITH, reward=rewards.RewardSum(terms))
    assert_same(after(same, np.array(INTO["wrench"]), 60)["reward_terms"], told)


def test_a_transition_with_surroundings_is_pickled_and_drawn():
    core = started()
    after(core, np.array(INTO["wrench"]), 20)
    step = last(core)
    again = pickle.loads(pickle.dumps(step))
    np.testing.assert_array_equal(again.decomposition.internal, step.decomposition.internal)
    split = pickle.loads(pickle.dumps(step.decomposition))
    np.testing.assert_array_equal(split.relative_cost, step.decomposition.relative_cost)
    picture = Renderer(core.bodies, core.scenes, width=320).picture(step)
    assert picture.std() > 1.0


def test_settings_with_surroundings_go_through_json_and_gymnasium():
    config = TransportConfig(decomposition=WITH)
    assert TransportConfig.from_json(config.to_json()) == config
    env = gymnasium.make("coopenv/BeamTransport-v0", decomposition=WITH)
    assert env.spec is not None
    again = gymnasium.make(EnvSpec.from_json(env.spec.to_json()))
    inner = again.unwrapped
    _, info = again.reset(seed=0)
    assert info["surroundings_wrench"].shape == (3,)
    assert inner.transport.config.decomposition == WITH  # pyright: ignore[reportAttributeAccessIssue]
    env = coopenv.beam_transport_v0.parallel_env(decomposition=WITH)
    _, told = env.reset(seed=0)
    assert {each["surroundings_wrench"].shape for each in told.values()} == {(3,)}


def test_hands_that_press_a_wheeled_body_sideways_are_counted():
    body = Body.walker(grips=((-0.5, 0.0), (0.5, 0.0)))
    core = started(body=body, pose=(0, 0, 0.3), action="motion", hands=Hands(stiffness=100.0))
    info = after(core, np.array([[[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]]), 12)
    assert abs(last(core).applied[0, :, 1].sum()) > 5.0
    assert info["relative_cost"][0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("method", sorted(set(wrench.METHODS) - {"optimal", "point_mass"}))
def test_methods_that_would_share_with_a_wall_that_is_not_touched_are_refused(method):
    with pytest.raises(InvalidInput, match=f"surroundings must be False for method='{method}'"):
        wrench.Settings(method=method, surroundings=True)


def test_settings_of_surroundings_are_checked():
    with pytest.raises(InvalidInput, match="surroundings must be True or False, got 'walls'"):
        wrench.Settings(surroundings="walls")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidInput, match="solver must not be 'pair' with surroundings=True"):
        wrench.Settings(surroundings=True, solver="pair")
    assert wrench.Settings(surroundings=np.True_) == WITH  # pyright: ignore[reportArgumentType]
    assert WITH.of_agents == WITHOUT
    assert WITHOUT.of_agents is WITHOUT
