"""A trained policy as a partner: it acts as it was trained, in every view."""

import pickle
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from coopenv import PUSHES, Sensor, Transport, TransportConfig, beam_transport_v0
from coopenv.agents import sb3
from coopenv.agents.partners import LearnedPartner
from coopenv.errors import InvalidInput
from tests.agents.learned.cases import normalized, trained, untrained
from tests.agents.partners.cases import OTHER, SEEN, wrenches
from tests.agents.partners.saved import saved, saved_each, sb3_ppo
from tests.helpers import NEVER, TRIO, actions

ID = "coopenv/BeamTransport-v0"


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, str]:
    """One of each kind of control."""
    return saved_each(tmp_path_factory.mktemp("policies"))


def beside(
    partner: Any, policy: Any, seen: tuple[int, ...], config: TransportConfig, *, steps: int = 12
) -> None:
    """Agent 1 of a core with ``partner`` does what ``policy`` does in a twin without one.

    The twin shows what the policy was trained on. World 1 starts anew on its own.
    """
    core = Transport(num_worlds=3, config=replace(OTHER, partner=partner, action=config.action))
    twin = Transport(num_worlds=3, config=config)
    pose, goal = np.zeros((3, 3)), np.tile([1.0, -0.5, 0.4], (3, 1))
    everywhere, alone = np.ones(3, dtype=np.bool_), np.array([False, True, False])
    for k, action in enumerate(actions(0, steps, 3, 1, 3)):
        mask = everywhere if k == 0 else alone if k == steps // 2 else None
        if mask is not None:
            for each in (core, twin):
                each.reset(seed=4, mask=mask, pose=pose, goal=goal)
            policy.reset(mask)
        assert core.transition is not None
        assert twin.transition is not None
        obs = twin.observation(twin.transition)[:, list(seen)]
        given = policy(obs, twin.transition)[:, [seen.index(1)]]
        core.step(action)
        twin.step(np.concatenate([action, given], axis=1))
        np.testing.assert_allclose(core.transition.applied, twin.transition.applied, atol=1e-6)
    assert twin.transition is not None
    assert np.abs(twin.transition.applied[:, 1]).min() > 0


@pytest.mark.parametrize(
    ("control", "seen"), [("joint", (0, 1)), ("shared", (1,)), ("partner", (1,))]
)
def test_a_policy_acts_as_in_its_training_whatever_the_learner_sees(files, control, seen):
    beside(files[control], sb3.SB3Policy.load(files[control]), seen, SEEN)


def test_it_sees_through_its_own_statistics_and_remembers_each_episode(tmp_path):
    model = trained("RecurrentPPO", normalized("shared"))
    policy = sb3.SB3Policy(model)
    policy.save(tmp_path / "it")
    assert policy.normalization is not None
    beside(str(tmp_path / "it"), policy, (1,), replace(TransportConfig(), task=NEVER))
    beside(policy, policy.frozen(), (1,), replace(TransportConfig(), task=NEVER))


def test_samples_are_of_seed_episode_and_step_whatever_runs_beside(files):
    sampled = LearnedPartner(path=files["partner"], deterministic=False)
    config = replace(OTHER, partner=sampled)
    three = wrenches(Transport(num_worlds=3, config=config), seed=5)
    alone = wrenches(Transport(num_worlds=1, config=config), seed=7)
    np.testing.assert_array_equal(three, wrenches(Transport(num_worlds=3, config=config), seed=5))
    np.testing.assert_allclose(three[0, 2], alone[0, 0], atol=1e-6)  # then learners differ
    again = wrenches(Transport(num_worlds=3, config=config), seed=6)
    assert (three != again).all()
    assert len(np.unique(three)) == three.size
    mean = wrenches(
        Transport(num_worlds=3, config=replace(OTHER, partner=files["partner"])), seed=5
    )
    assert np.abs(three - mean).mean() > 0.3
    other = replace(sampled, seed=1)
    assert (
        wrenches(Transport(num_worlds=3, config=replace(OTHER, partner=other)), seed=5) != three
    ).all()


def test_a_world_that_begins_alone_draws_as_if_all_did(files):
    config = replace(OTHER, partner=LearnedPartner(path=files["partner"], deterministic=False))
    cores = [Transport(num_worlds=3, config=config) for _ in range(2)]
    for core, mask in zip(cores, (None, np.array([False, True, False])), strict=True):
        core.reset(seed=1)
        core.step(np.zeros((3, 1, 3)))
        core.reset(seed=9, mask=mask)
        core.step(np.zeros((3, 1, 3)))
    everywhere, alone = (core.transition.applied[:, 1] for core in cores)  # pyright: ignore[reportOptionalMemberAccess]
    np.testing.assert_array_equal(everywhere[1], alone[1])
    assert (everywhere[[0, 2]] != alone[[0, 2]]).all()


def test_its_sensors_err_anew_in_every_episode(tmp_path):
    seen = replace(SEEN, observe=("goal", Sensor("twist", noise=0.5, bias=0.5), "own_wrench"))
    partner = saved(tmp_path / "noisy.zip", seen, "partner")
    pose, goal = np.zeros((2, 3)), np.ones((2, 3))
    core = Transport(num_worlds=2, config=replace(OTHER, partner=partner))
    given = wrenches(core, episodes=2, steps=1, seed=0, pose=pose, goal=goal)
    core.reset(pose=pose, goal=goal)
    core.step(np.zeros((2, 1, 3)))
    assert core.transition is not None
    assert len(np.unique([*given[0, :, 0], *core.transition.applied[:, 1, 0]])) == 4


def test_every_view_has_it(files):
    keywords: dict[str, Any] = {"partner": files["shared"], "horizon": 3}
    views = [
        gymnasium.make(ID, **keywords),
        gymnasium.make_vec(ID, num_envs=2, **keywords),
        beam_transport_v0.parallel_env(**keywords),
        beam_transport_v0.env(**keywords),
        sb3.make_vec_env(ID, 2, control="partner", **keywords),
    ]
    wanted = LearnedPartner(path=files["shared"])
    given = []
    for view in views:
        core = view.unwrapped.transport if hasattr(view, "unwrapped") else view.transport  # pyright: ignore
        assert core.config.partner == wanted
        assert core.learners == (0,)
        core.reset(seed=2)
        core.step(np.zeros((core.num_worlds, 1, 3)))
        given.append(core.transition.applied[0, 1])
        assert not core._info["partner_has_plan"].any()
    assert np.abs(given[0]).min() > 0
    np.testing.assert_allclose(given, [given[0]] * len(given), atol=1e-6)


def test_the_torchrl_view_has_it(files):
    pytest.importorskip("torchrl")
    from coopenv.agents import torchrl

    keywords: dict[str, Any] = {"num_worlds": 2, "partner": files["shared"], "horizon": 3}
    env, core = torchrl.make_env(ID, seed=2, **keywords), Transport(**keywords)
    assert env.group_map == {"agents": ["agent_0"]}
    core.reset(seed=2)
    data = env.reset()
    for _ in range(2):
        data["agents", "action"] = env.full_action_spec.zero()["agents", "action"]
        data = env.step(data)["next"]
        core.step(np.zeros((2, 1, 3)))
        assert env.transport.transition is not None
        assert core.transition is not None
        applied = env.transport.transition.applied
        np.testing.assert_array_equal(applied, core.transition.applied)
        assert np.abs(applied[:, 1]).min() > 0


def test_a_core_and_an_environment_with_it_can_be_pickled(files):
    env: Any = gymnasium.make(ID, partner=files["shared"])
    twin = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(twin.reset(seed=1)[0], env.reset(seed=1)[0])
    for each in (env, twin):
        each.step(np.zeros(3))
    wanted, found = (each.unwrapped.transport.transition.applied for each in (env, twin))
    np.testing.assert_array_equal(found, wanted)


def test_a_policy_that_learned_to_move_hands_moves_them_and_gives_no_wrenches(files, tmp_path):
    moving = replace(SEEN, action="motion")
    mover = saved(tmp_path / "mover.zip", moving)
    beside(mover, sb3.SB3Policy.load(mover), (0, 1), moving)
    with pytest.raises(InvalidInput, match=r"must be 'motion' for a policy .* got 'wrench'"):
        Transport(config=replace(OTHER, partner=mover))
    with pytest.raises(InvalidInput, match=r"must be 'wrench' for a policy .* got 'motion'"):
        Transport(config=replace(OTHER, partner=files["joint"], action="motion"))


def test_one_that_every_agent_runs_drives_several(files):
    driven = replace(SEEN, body=TRIO, partner=files["shared"], partner_agents=(0, 2))
    core = Transport(config=driven)
    core.reset(seed=0)
    core.step(np.zeros((1, 1, 3)))
    assert core.transition is not None
    assert core.transition.applied[0, [0, 2]].all()
    assert not core.transition.applied[0, 1].any()


def test_a_policy_that_learns_on_changes_no_partner():
    model = trained("PPO", sb3.make_vec_env(SEEN, 2, control="shared"))
    core = Transport(config=replace(OTHER, partner=sb3.SB3Policy(model)))
    before = wrenches(core, episodes=1, seed=0)
    model.learn(8)
    np.testing.assert_array_equal(wrenches(core, episodes=1, seed=0), before)
    later = Transport(config=replace(OTHER, partner=sb3.SB3Policy(model)))
    assert (wrenches(later, episodes=1, seed=0) != before).any()


@pytest.mark.parametrize("action", ["wrench", "discrete"])
def test_a_policy_that_chooses_pushes_does_here_what_they_stood_for_in_its_training(
    action, tmp_path
):
    learned = replace(SEEN, action="discrete", pushes="compass", bounded=True)
    venv = sb3.make_vec_env(learned, 2, control="shared")
    path = tmp_path / "policy.zip"
    sb3.SB3Policy(untrained(sb3_ppo(), venv), notes=venv.to_notes()).save(path)
    core = Transport(num_worlds=40, config=replace(OTHER, action=action, partner=str(path)))
    core.reset(seed=0)
    assert core.transition is not None
    policy = sb3.SB3Policy.load(path)
    seen = Transport(num_worlds=40, config=learned)
    given = policy(seen.reset(seed=0)[0], core.transition)[:, 1]
    core.step(np.zeros(core.action_shape, dtype=np.float64 if action == "wrench" else np.int64))
    np.testing.assert_array_equal(core.transition.action[:, 1], np.array(PUSHES["compass"])[given])
    with pytest.raises(InvalidInput, match="action must be 'wrench' or 'discrete' beside a"):
        Transport(config=replace(OTHER, action="force", partner=str(path)))
