"""One, three, four and eight agents: every view, block, reward and measure."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test

import coopenv
from coopenv import Body, Transport, TransportConfig
from coopenv.agents.controllers.impedance import ImpedanceController
from coopenv.agents.evaluate import compare
from coopenv.rewards import PRESETS
from coopenv.wrench import Settings
from tests.helpers import BLIND_TO_HANDS, leaves

COUNTS = (1, 3, 4, 8)
ID = "coopenv/BeamTransport-v0"
FAST = Settings(method="moore_penrose")  # where the solver is not what is tested


@pytest.mark.parametrize("count", COUNTS)
def test_the_checkers_of_every_view_take_any_team(count):
    keywords = {"body": Body.plate(count), "observe": BLIND_TO_HANDS, "horizon": 6}
    check_env(gymnasium.make(ID, **keywords).unwrapped, skip_render_check=True)
    parallel_api_test(coopenv.beam_transport_v0.parallel_env(**keywords), num_cycles=10)
    env = gymnasium.make_vec(ID, num_envs=2, **keywords)
    obs, _ = env.reset(seed=0)
    assert env.action_space.shape == (2, 3 * count)
    assert obs.shape == env.observation_space.shape


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("reward", PRESETS)
def test_rewards_and_infos_have_a_row_an_agent(count, reward):
    core = Transport(num_worlds=2, body=Body.plate(count, size=(1.2, 1.0)), reward=reward)
    core.reset(seed=0)
    _, total, *_, info = core.step(np.random.default_rng(0).uniform(-1, 1, (2, count, 3)))
    assert total.shape == (2, count)
    for name in ("internal_wrench", "manipulation_wrench", "force_load_share"):
        assert info[name].shape[:2] == (2, count)
    for path, value in leaves(info):
        assert np.isfinite(value).all(), path


@pytest.mark.parametrize("count", COUNTS)
def test_the_general_solver_splits_what_any_team_applies(count):
    core = Transport(num_worlds=3, body=Body.plate(count))
    core.reset(seed=0)
    core.step(np.random.default_rng(1).uniform(-1, 1, (3, count, 3)))
    assert core.transition is not None
    split = core.transition.decomposition
    assert max(residual.max() for residual in split.residuals()) < 1e-6
    np.testing.assert_allclose(split.object_wrench, split.applied.sum(axis=1), atol=20)
    if count == 1:
        np.testing.assert_allclose(split.internal, 0.0, atol=1e-9)
    else:
        assert (split.relative_cost > 0.01).all()


@pytest.mark.parametrize("count", COUNTS)
def test_the_scripted_controller_carries_a_plate(count):
    config = TransportConfig(body=Body.plate(count), decomposition=FAST)
    seen = compare({"scripted": ImpedanceController(config)}, config, episodes=60, num_worlds=60)
    assert seen[0].success_rate >= 0.95
    assert seen[0].relative_cost < 0.2


def test_ppo_takes_a_plate_of_four_under_one_shared_policy():
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    from coopenv.agents.sb3 import SB3Policy, feature_scale, make_vec_env

    config = TransportConfig(
        body=Body.plate(4), decomposition=FAST, horizon=20, observe=("goal", "twist", "body")
    )
    venv = make_vec_env(config, 4, control="shared", seed=0)
    assert venv.num_envs == 16
    seen = venv.reset() * feature_scale(venv)
    assert np.abs(seen).max() < 10
    model = stable_baselines3.PPO("MlpPolicy", venv, n_steps=16, batch_size=64, n_epochs=1)
    policy = SB3Policy(model.learn(256))
    core = Transport(num_worlds=3, config=config)
    obs, _ = core.reset(seed=0)
    assert core.transition is not None
    assert policy(obs, core.transition).shape == (3, 4, 3)
