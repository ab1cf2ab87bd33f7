"""Learned policies that act by numbers of pushes: as those that act in a box, in file and deed."""

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

import stable_baselines3
import torch

from coopenv import TransportConfig
from coopenv.agents import sb3
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.trained.spaces import NotPlain, plain_space, space_of, spaces_of
from coopenv.errors import InvalidInput
from tests.agents.learned.cases import OFF_POLICY, ON_POLICY
from tests.helpers import EASY

BOUNDS = [-np.inf, 0, -np.inf, 0], [np.inf, np.inf, 1, 1]  # low and high
CONFIG = TransportConfig(task=EASY, horizon=6, action="discrete", pushes="compass")
LEARNERS: dict[str, tuple[Any, str, dict[str, Any]]] = {
    "a team": (stable_baselines3.PPO, "joint", ON_POLICY),
    "each agent": (stable_baselines3.PPO, "shared", ON_POLICY),
    "Q-learning": (stable_baselines3.DQN, "shared", OFF_POLICY),
}


def trained(name):
    torch.set_num_threads(1)
    algorithm, control, given = LEARNERS[name]
    venv = sb3.make_vec_env(CONFIG, 2, control=control, seed=5)
    return algorithm("MlpPolicy", venv, device="cpu", seed=1, **given).learn(12)


@pytest.mark.parametrize("name", LEARNERS)
def test_a_policy_comes_back_from_its_file_without_trust_and_acts_as_it_did(name, tmp_path):
    policy = sb3.SB3Policy(trained(name))
    policy.save(tmp_path / "policy.zip")
    again = sb3.SB3Policy.load(tmp_path / "policy.zip")
    mine, theirs = (run_episodes(each, CONFIG, episodes=6) for each in (policy, again))
    np.testing.assert_array_equal(mine.reward, theirs.reward)


@pytest.mark.parametrize("name", ["a team", "each agent"])
def test_sampled_pushes_do_not_depend_on_the_worlds_beside(name):
    sampled = sb3.SB3Policy(trained(name)).sampled()
    assert sampled is not None
    many, few = (run_episodes(sampled, CONFIG, episodes=8, num_worlds=n) for n in (8, 3))
    np.testing.assert_allclose(many.reward, few.reward, rtol=0, atol=1e-9)


def test_the_agents_of_a_team_choose_independently():
    policy = sb3.SB3Policy(trained("a team"), deterministic=False)
    core = sb3.make_vec_env(CONFIG, 300).transport
    obs, _ = core.reset(seed=0)
    chosen = policy(obs, core.transition)  # pyright: ignore[reportArgumentType]
    assert chosen.shape == (300, 2)
    assert set(chosen.ravel()) == set(range(11))
    assert 5 < (chosen[:, 0] == chosen[:, 1]).sum() < 80  # 27 by chance


@pytest.mark.parametrize("other", [{"pushes": "axes"}, {"action": "wrench"}])
def test_a_policy_of_other_pushes_is_refused(other):
    policy = sb3.SB3Policy(trained("each agent"))
    with pytest.raises(InvalidInput, match="trained with, numbers of 11 pushes, got"):
        run_episodes(policy, replace(CONFIG, **other), episodes=2)


def test_spaces_of_pushes_go_through_json_and_others_do_not():
    for space in (gymnasium.spaces.Discrete(5), gymnasium.spaces.MultiDiscrete([4, 4, 4])):
        assert space_of(plain_space(space)) == space
    uneven = gymnasium.spaces.MultiDiscrete([4, 3])
    for space in (gymnasium.spaces.Discrete(5, start=1), uneven):
        with pytest.raises(NotPlain):
            plain_space(space)
    for given in ({"pushes": 10**9}, {"pushes": 3, "agents": 10**9}, {"pushes": 0}):
        with pytest.raises(ValueError, match="a space of"):
            space_of(given)


def test_one_agent_of_its_own_has_a_row_of_one_push():
    seen = gymnasium.spaces.Box(-1.0, 1.0, (4,))
    for done in (gymnasium.spaces.MultiDiscrete([7]), gymnasium.spaces.Discrete(7)):
        made = spaces_of(seen, done, "PPO")
        assert (made.pushes, made.actions) == (7, 1)


def test_a_feature_is_bounded_that_has_a_bound_on_either_side():
    low, high = (np.array(each, dtype=np.float32) for each in BOUNDS)
    seen = gymnasium.spaces.Box(low, high)
    made = spaces_of(seen, gymnasium.spaces.Discrete(7), "PPO")
    assert made.bounded.tolist() == [False, True, True, True]
