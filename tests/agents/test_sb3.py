"""The native Stable-Baselines3 VecEnv, and trained models as policies."""

import pickle
import warnings
from typing import Any

import numpy as np
import pytest

from tests.helpers import EASY, TRIO, actions

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO, SAC
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from coopenv import Sensor, Transport, TransportConfig
from coopenv.agents import sb3
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import ppo_settings
from coopenv.errors import InvalidInput, UnknownName
from coopenv.observation import ranges

CONTROLS = ("joint", "shared")


def small(control, **keywords):
    """Two worlds whose episodes end soon, one way or the other."""
    return sb3.make_vec_env(
        num_worlds=2, control=control, seed=5, **{"task": EASY, "horizon": 6, **keywords}
    )


def tiny_model(venv, algorithm=PPO, **keywords):
    return algorithm(
        "MlpPolicy",
        venv,
        policy_kwargs={"net_arch": [8]},
        device="cpu",
        **{"n_steps": 4, "batch_size": 4, "n_epochs": 1, **keywords},
    )


def test_rows_are_worlds_under_joint_and_agents_under_shared_control():
    joint, shared = (sb3.make_vec_env(num_worlds=3, control=control) for control in CONTROLS)
    size = joint.transport.observation.size
    assert (joint.num_envs, shared.num_envs) == (3, 6)
    assert joint.observation_space.shape == (2 * size,)
    assert shared.observation_space.shape == (size,)
    assert joint.action_space.shape == (6,)
    assert shared.action_space.shape == (3,)
    for venv in (joint, shared):
        obs = venv.reset()
        assert obs.shape[0] == venv.num_envs
        assert obs.shape[1:] == venv.observation_space.shape
        assert obs.dtype == np.float32
        assert all(venv.observation_space.contains(row) for row in obs)


def test_a_row_is_the_one_who_learns_under_partner_control():
    venv = sb3.make_vec_env(
        num_worlds=3, control="partner", seed=5, partner="stubborn", task=EASY, horizon=6
    )
    core = Transport(config=venv.transport.config, num_worlds=3)
    expected, _ = core.reset(seed=5)
    assert venv.num_envs == 3
    assert (venv.observation_space.shape, venv.action_space.shape) == ((22,), (3,))
    np.testing.assert_array_equal(venv.reset(), expected[:, 0])
    for action in actions(0, 8, 3, 3):
        obs, reward, done, infos = venv.step(action)
        expected, earned, terminated, truncated, _ = core.step(action[:, None])
        np.testing.assert_array_equal(done, terminated | truncated)
        np.testing.assert_allclose(reward, earned[:, 0], atol=1e-6)
        for k in np.flatnonzero(done):
            np.testing.assert_array_equal(infos[k]["terminal_observation"], expected[k, 0])
            assert infos[k]["episode"]["l"] <= 6
        if done.any():
            expected, _ = core.reset(mask=done)
        np.testing.assert_array_equal(obs, expected[:, 0])


def test_partner_control_brings_a_partner_and_leaves_one_agent():
    assert sb3.make_vec_env(num_worlds=1, control="partner").transport.learners == (0,)
    with pytest.raises(InvalidInput, match="partner_agents must leave one agent to learn"):
        sb3.make_vec_env(num_worlds=1, control="partner", body=TRIO)
    venv = sb3.make_vec_env(num_worlds=2, body=TRIO, partner="noisy", control="shared")
    assert venv.num_envs == 4  # the two who are not driven, in two worlds


@pytest.mark.parametrize("control", CONTROLS)
def test_it_moves_as_the_core_does(control: str):
    venv = sb3.make_vec_env(num_worlds=3, control=control, seed=7, reward="balanced")
    core = Transport(num_worlds=3, reward="balanced")
    expected, _ = core.reset(seed=7)
    obs = venv.reset()
    for joint in actions(0, 20, 3, 2, 3):
        np.testing.assert_array_equal(np.ravel(np.asarray(obs)), expected.ravel())
        obs, reward, done, infos = venv.step(joint.reshape(venv.num_envs, -1))
        expected, own, *_ = core.step(joint)
        wanted = own.mean(axis=1) if control == "joint" else own.reshape(-1)
        np.testing.assert_array_equal(reward, wanted.astype(np.float32))
        assert not done.any()
        assert infos == [{}] * venv.num_envs


@pytest.mark.parametrize("control", CONTROLS)
def test_infos_speak_only_where_an_episode_ended(control: str):
    venv = small(control)
    rows = venv.num_envs // 2
    venv.reset()
    total, lengths, ends = np.zeros(venv.num_envs), np.zeros(venv.num_envs, dtype=int), []
    for joint in actions(1, 60, 2, 2, 3):
        obs, reward, done, infos = venv.step(joint.reshape(venv.num_envs, -1))
        total += reward
        lengths += 1
        assert [bool(info) for info in infos] == done.tolist()
        assert done.reshape(2, rows).all(axis=1).tolist() == done.reshape(2, rows)[:, 0].tolist()
        for row in np.flatnonzero(done):
            info = infos[row]
            assert info["is_success"] != info["TimeLimit.truncated"]
            assert info["episode"]["r"] == pytest.approx(total[row], rel=1e-5, abs=1e-5)
            assert info["episode"]["l"] == lengths[row]
            parts = sum(v for name, v in info["episode"].items() if name.startswith("reward/"))
            assert parts == pytest.approx(info["episode"]["r"])
            assert info["terminal_observation"].shape == venv.observation_space.shape
            assert not np.array_equal(info["terminal_observation"], np.asarray(obs)[row])
            ends.append(info["is_success"])
            total[row], lengths[row] = 0, 0
        assert len({id(info) for info in infos}) == venv.num_envs
    assert {True, False} == set(ends)


def test_the_last_observation_and_the_first_are_those_of_the_core():
    venv = sb3.make_vec_env(num_worlds=2, seed=0, horizon=3)
    core = Transport(num_worlds=2, horizon=3)
    core.reset(seed=0)
    venv.reset()
    plan = actions(2, 3, 2, 2, 3)
    for joint in plan[:2]:
        venv.step(joint.reshape(2, -1))
        core.step(joint)
    obs, _, done, infos = venv.step(plan[2].reshape(2, -1))
    last, *_ = core.step(plan[2])
    first, _ = core.reset(mask=done)
    assert done.all()
    np.testing.assert_array_equal(infos[1]["terminal_observation"], last[1].ravel())
    np.testing.assert_array_equal(obs, first.reshape(2, -1))


def test_episode_means_are_those_of_the_steps():
    venv = sb3.make_vec_env(num_worlds=2, seed=0, horizon=4)
    core = Transport(num_worlds=2, horizon=4)
    core.reset(seed=0)
    venv.reset()
    costs, levels, infos = [], [], []
    for joint in actions(3, 4, 2, 2, 3):
        *_, infos = venv.step(joint.reshape(2, -1))
        *_, info = core.step(joint)
        costs.append(info["relative_cost"])
        levels.append(info["internal_force_level"])
    for k in range(2):
        episode = infos[k]["episode"]
        assert episode["relative_cost"] == pytest.approx(np.mean(costs, axis=0)[k])
        assert episode["internal_force_level"] == pytest.approx(np.mean(levels, axis=0)[k])


def test_a_seed_gives_every_world_its_own_and_is_used_once():
    venv = sb3.make_vec_env(num_worlds=3, control="shared")
    assert list(venv.seed(11)) == [11, 11, 12, 12, 13, 13]
    first = venv.reset()
    second = venv.reset()
    assert not np.array_equal(first, second)
    venv.seed(11)
    np.testing.assert_array_equal(venv.reset(), first)
    assert len(venv.seed()) == 6


def test_start_and_goal_can_be_given():
    venv = sb3.make_vec_env(num_worlds=2, seed=0)
    venv.set_options({"pose": (1.0, 0.5, 0.2), "goal": (-1.0, 0.0, 0.0)})
    venv.reset()
    transition = venv.transport.transition
    assert transition is not None
    np.testing.assert_allclose(transition.next_state.pose, [[1.0, 0.5, 0.2]] * 2)
    np.testing.assert_allclose(transition.next_state.goal, [[-1.0, 0.0, 0.0]] * 2)
    venv.reset()
    transition = venv.transport.transition
    assert transition is not None
    assert not np.allclose(transition.next_state.pose, [[1.0, 0.5, 0.2]] * 2)
    with pytest.raises(InvalidInput, match="one dict"):
        venv.set_options([{}, {}])
    with pytest.warns(UserWarning, match="reset options"):
        venv.set_options({"poes": (0, 0, 0)})


def test_actions_of_another_shape_are_refused():
    venv = sb3.make_vec_env(num_worlds=2, control="shared")
    venv.reset()
    with pytest.raises(InvalidInput, match=r"\(4, 3\)"):
        venv.step(np.zeros((2, 6)))


def test_attributes_and_methods_reach_the_core():
    venv = sb3.make_vec_env(num_worlds=2, control="shared")
    assert venv.get_attr("horizon") == [200] * 4
    assert venv.get_attr("horizon", indices=1) == [200]
    assert venv.get_attr("control", indices=[0, 2]) == ["shared"] * 2
    assert venv.has_attr("transport")
    assert not venv.has_attr("no_such_attribute")
    venv.set_attr("horizon", 3)
    assert venv.transport.horizon == 3
    assert len(venv.env_method("reset", seed=1)) == 4
    assert venv.env_is_wrapped(Monitor) == [True] * 4
    assert venv.env_is_wrapped(VecMonitor) == [False] * 4
    assert venv.unwrapped is venv


def test_videos_of_it_run_at_the_pace_of_its_steps():
    venv = sb3.make_vec_env("coopenv/BeamTransport-v0", 2, dt=0.1)
    assert venv.metadata == {"render_modes": ["rgb_array"], "render_fps": 10}


def test_it_draws_every_world():
    pytest.importorskip("pygame")
    venv = sb3.make_vec_env(num_worlds=2, render_mode="rgb_array")
    venv.reset()
    assert len(venv.get_images()) == 2
    picture = venv.render()
    assert picture is not None
    assert picture.ndim == 3
    venv.close()
    with pytest.raises(UnknownName, match="rgb_array"):
        sb3.make_vec_env(num_worlds=2, render_mode="human")


@pytest.mark.parametrize("control", [*CONTROLS, "partner"])
def test_ppo_learns_and_is_evaluated_without_a_warning(control: str):
    venv = small(control)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = tiny_model(venv).learn(32)
        mean, _ = evaluate_policy(model, venv, n_eval_episodes=4)
    assert np.isfinite(mean)
    assert model.ep_info_buffer
    assert "relative_cost" in model.ep_info_buffer[0]


@pytest.mark.parametrize("control", [*CONTROLS, "partner"])
def test_the_recommended_keywords_are_those_of_a_run_whatever_the_number_of_worlds(control: str):
    config = TrainConfig(num_worlds=8, rollout=16, batch_size=64, epochs=3, steps=1024, seed=7)
    few, many = small(control), sb3.make_vec_env(num_worlds=32, control=control)
    rows = few.num_envs // few.transport.num_worlds  # of a world
    model = PPO("MlpPolicy", few, seed=7, **sb3.recommended(few, config))
    assert model.n_steps * few.transport.num_worlds == 8 * 16
    assert (model.n_epochs, model.batch_size, model.seed) == (3, 64, 7)
    assert model.lr_schedule(0.5) == pytest.approx(0.5 * config.learning_rate)
    extractor: Any = model.policy.features_extractor
    assert extractor.scale.tolist() == pytest.approx(sb3.feature_scale(few))
    assert sb3.recommended(many, config)["n_steps"] == 4
    small_updates = TrainConfig(num_worlds=8, rollout=2, batch_size=64, steps=1024)
    assert sb3.recommended(few, small_updates)["batch_size"] == min(64, 16 * rows)
    assert sb3.recommended(many, small_updates)["n_steps"] == 2  # or no advantage is estimated


def test_the_recommended_keywords_are_the_defaults_of_a_run():
    venv, config = sb3.make_vec_env(), TrainConfig()
    wanted = ppo_settings(config, rows=config.num_worlds, scale=sb3.feature_scale(venv))
    wanted.pop("seed")
    worlds = venv.num_envs
    rollout = config.rollout * config.num_worlds // worlds
    assert sb3.recommended(venv) == {**wanted, "n_steps": rollout}


def test_it_can_be_wrapped_and_used_off_policy():
    venv = VecNormalize(small("joint"))
    model = SAC("MlpPolicy", venv, policy_kwargs={"net_arch": [8]}, learning_starts=8, batch_size=4)
    model.learn(24)
    assert model.replay_buffer is not None


def test_wrong_names_are_refused_with_a_suggestion():
    with pytest.raises(UnknownName, match="BeamTransport-v0"):
        sb3.make_vec_env("coopenv/BeamTransport-v1")
    with pytest.raises(UnknownName, match="CartPole"):
        sb3.make_vec_env("CartPole-v1")
    with pytest.raises(UnknownName, match="joint"):
        sb3.make_vec_env(control="joined")
    with pytest.raises(UnknownName, match="horizon"):
        sb3.make_vec_env(horizn=10)
    with pytest.raises(InvalidInput, match="replace"):
        sb3.make_vec_env(TransportConfig(), horizon=10)
    assert sb3.make_vec_env(TransportConfig(horizon=9), 2).transport.horizon == 9


@pytest.mark.parametrize("control", CONTROLS)
def test_a_model_acts_for_all_agents_and_survives_its_file(control: str, tmp_path):
    venv = small(control)
    policy = sb3.SB3Policy(tiny_model(venv))
    core = Transport(num_worlds=5)
    obs, _ = core.reset(seed=0)
    assert core.transition is not None
    action = policy(obs, core.transition)
    assert action.shape == (5, 2, 3)
    path = tmp_path / "deep" / "policy.zip"
    policy.save(path)
    np.testing.assert_array_equal(sb3.SB3Policy.load(path)(obs, core.transition), action)
    assert PPO.load(path).observation_space == venv.observation_space
    assert [file.name for file in path.parent.iterdir()] == ["policy.zip"]
    if control == "shared":  # each agent's action depends on its own row alone
        changed = obs.copy()
        changed[:, 1] += 1.0
        np.testing.assert_array_equal(policy(changed, core.transition)[:, 0], action[:, 0])


def test_a_policy_refuses_observations_it_was_not_trained_on():
    policy = sb3.SB3Policy(tiny_model(small("joint")))
    core = Transport(num_worlds=2, observe=("goal", "twist"))
    obs, _ = core.reset(seed=0)
    assert core.transition is not None
    with pytest.raises(InvalidInput, match="observe="):
        policy(obs, core.transition)


def test_a_failed_save_leaves_the_old_policy(tmp_path, monkeypatch):
    policy = sb3.SB3Policy(tiny_model(small("joint")))
    path = tmp_path / "policy.zip"
    policy.save(path)
    before = path.read_bytes()

    def breaks(file):
        file.write(b"half")
        raise OSError("disk full")

    monkeypatch.setattr(policy.model, "save", breaks)
    with pytest.raises(OSError, match="disk full"):
        policy.save(path)
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["policy.zip"]


@pytest.mark.parametrize("control", CONTROLS)
def test_the_scale_touches_wrenches_only_and_brings_the_limits_to_one(control: str):
    venv = sb3.make_vec_env(num_worlds=2, control=control, force_limit=20.0, torque_limit=4.0)
    scale = np.array(sb3.feature_scale(venv)).reshape(-1, venv.transport.observation.size)
    blocks = venv.transport.observation.blocks
    for row in scale:
        for name in ("own_wrench", "partner_wrench", "own_internal", "partner_internal"):
            np.testing.assert_allclose(row[blocks[name]], [1 / 20, 1 / 20, 1 / 4])
        for name in ("goal", "twist", "load_share", "relative_cost"):
            assert (row[blocks[name]] == 1).all()


def test_what_is_bounded_is_scaled_to_one_by_its_bound():
    observe = ("known", ranges(num_rays=3, reach=4.0), "twist", Sensor("load_share", noise=0.1))
    venv = sb3.make_vec_env(num_worlds=2, control="shared", observe=observe)
    scale = sb3.feature_scale(venv)
    assert scale == [1.0] * 2 + [0.25] * 6 + [1.0] * 5


@pytest.mark.parametrize("name", ["FallingRate", "SB3Policy", "Scaled", "TransportVecEnv"])
def test_what_saved_policies_name_is_found_where_they_look_for_it(name):
    kind = getattr(sb3, name)
    assert kind.__module__ == "coopenv.agents.sb3"
    assert pickle.loads(pickle.dumps(kind)) is kind
