"""Learned policies in many worlds: memory, sampled actions, evaluation."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

import torch
from stable_baselines3.common.save_util import recursive_getattr

from coopenv import Transport
from coopenv.agents.evaluate import evaluate, run_episodes
from coopenv.agents.policy import forget
from coopenv.agents.sb3 import SB3Policy
from tests.agents.learned.cases import (
    ALGORITHMS,
    CONFIG,
    SPREADLESS,
    normalized,
    small,
    start,
    trained,
)


def forgetful(model):
    """A recurrent policy with large weights, so that its memory matters."""
    with torch.no_grad():
        for value in recursive_getattr(model, "policy").parameters():
            value.mul_(3.0)
    return model


def alone(model, seen, venv=None):
    """Actions in one episode by SB3's own loop: states and episode starts handed on."""
    size = model.observation_space.shape[0]
    rows = seen[0].size // size
    state, starts, taken = None, np.ones(rows, dtype=bool), []
    for obs in seen:
        given = obs.reshape(rows, size)
        given = venv.normalize_obs(given) if venv is not None else given
        action, state = model.predict(given, state, starts, deterministic=True)
        starts = np.zeros(rows, dtype=bool)
        taken.append(action.reshape(len(obs), -1))
    return taken


def episodes_of(policy, num_worlds, steps):
    """What was seen and done in every episode of a batch whose worlds restart as they end."""
    core = Transport(num_worlds=num_worlds, config=CONFIG)
    obs, _ = core.reset(seed=0)
    forget(policy, np.ones(num_worlds, dtype=bool))
    rng = np.random.default_rng(2)
    running, ended = [([], []) for _ in range(num_worlds)], []
    for _ in range(steps):
        assert core.transition is not None
        action = policy(obs, core.transition)
        for k, (seen, done) in enumerate(running):
            seen.append(obs[k])
            done.append(action[k])
        obs, _, terminated, truncated, _ = core.step(action)
        over = terminated | truncated | (rng.random(num_worlds) < 0.2)
        for k in np.flatnonzero(over):
            ended.append(running[k])
            running[k] = ([], [])
        if over.any():
            obs, _ = core.reset(mask=over)
            forget(policy, over)
    return ended


@pytest.mark.parametrize("control", ["joint", "shared"])
@pytest.mark.parametrize("with_statistics", [False, True])
def test_a_recurrent_policy_acts_in_a_batch_as_in_each_episode_alone(control, with_statistics):
    venv = normalized(control) if with_statistics else None
    model = forgetful(trained("RecurrentPPO", venv or small(control)))
    episodes = episodes_of(SB3Policy(model), num_worlds=3, steps=40)
    assert len({len(seen) for seen, _ in episodes}) > 1  # worlds restart at different times
    for seen, done in episodes:
        np.testing.assert_allclose(done, alone(model, seen, venv), atol=1e-5)


def test_a_recurrent_policy_remembers_and_forgets():
    model = forgetful(trained("RecurrentPPO", small()))
    policy = SB3Policy(model)
    core = Transport(num_worlds=2, config=CONFIG)
    obs, _ = core.reset(seed=0)
    assert core.transition is not None
    first = policy(obs, core.transition)
    obs, *_ = core.step(first)
    later = policy(obs, core.transition)
    policy.reset(np.array([True, False]))
    again = policy(obs, core.transition)
    fresh, _ = model.predict(obs.reshape(2, -1), deterministic=True)
    np.testing.assert_allclose(again[0].ravel(), fresh[0], atol=1e-6)
    assert not np.allclose(again[1].ravel(), fresh[1])
    assert not np.allclose(later, again)
    other, transition = start(3)  # another batch: nothing is remembered of the first
    fresh, _ = model.predict(other.reshape(3, -1), deterministic=True)
    np.testing.assert_allclose(policy(other, transition).reshape(3, -1), fresh, atol=1e-6)


@pytest.mark.parametrize("name", ALGORITHMS)
def test_sampled_actions_repeat_and_do_not_depend_on_the_number_of_worlds(name):
    policy = SB3Policy(trained(name, small())).sampled()
    if name in SPREADLESS:
        assert policy is None
        return
    assert policy is not None
    torch.manual_seed(0)
    many = run_episodes(policy, CONFIG, episodes=6, num_worlds=6)
    few = run_episodes(policy, CONFIG, episodes=6, num_worlds=1)
    np.testing.assert_array_equal(many.length, few.length)
    np.testing.assert_allclose(many.relative_cost, few.relative_cost, atol=1e-5)
    other = run_episodes(SB3Policy(policy.model, deterministic=False, seed=1), CONFIG, episodes=6)
    assert not np.allclose(many.relative_cost, other.relative_cost)
    mean = run_episodes(SB3Policy(policy.model), CONFIG, episodes=6)
    assert not np.allclose(many.relative_cost, mean.relative_cost)


@pytest.mark.parametrize("name", ["PPO", "SAC"])
def test_exploration_that_depends_on_the_state_is_drawn_once_an_episode(name):
    policy = SB3Policy(trained(name, small(), use_sde=True)).sampled()
    assert policy is not None
    many = run_episodes(policy, CONFIG, episodes=4, num_worlds=4)
    few = run_episodes(policy, CONFIG, episodes=4, num_worlds=1)
    np.testing.assert_allclose(many.relative_cost, few.relative_cost, atol=1e-5)
    mean = run_episodes(SB3Policy(policy.model), CONFIG, episodes=4)
    assert not np.allclose(many.relative_cost, mean.relative_cost)


def test_sampled_actions_have_the_spread_of_the_policy():
    model = trained("PPO", small())
    spread = recursive_getattr(model, "policy.log_std").exp().detach().numpy()
    with torch.no_grad():
        recursive_getattr(model, "policy.log_std").fill_(-2.0)
    assert spread.shape == (6,)
    obs, transition = start(4000)
    mean = SB3Policy(model)(obs, transition)
    drawn = SB3Policy(model, deterministic=False)(obs, transition)
    noise = (drawn - mean).reshape(4000, 6)
    np.testing.assert_allclose(noise.std(axis=0), np.exp(-2.0), rtol=0.05)
    np.testing.assert_allclose(noise.mean(axis=0), 0, atol=0.01)
    np.testing.assert_allclose(np.corrcoef(noise.T), np.eye(6), atol=0.06)


def test_sampling_leaves_torchs_own_generator_alone():
    policy = SB3Policy(trained("PPO", small()), deterministic=False)
    obs, transition = start()
    before = torch.get_rng_state()
    policy(obs, transition)
    torch.testing.assert_close(torch.get_rng_state(), before)


def test_an_evaluation_reports_both_ways_of_acting():
    policy = SB3Policy(trained("PPO", small()))
    seen = evaluate(policy, CONFIG, episodes=20, name="learned")
    drawn = run_episodes(SB3Policy(policy.model, deterministic=False), CONFIG, episodes=20)
    assert seen.sampled_success_rate == drawn.success.mean()
    low, high = seen.sampled_success_interval
    assert 0 <= low <= seen.sampled_success_rate <= high <= 1
    again = evaluate(policy, CONFIG, episodes=20, name="learned", num_worlds=7)
    assert seen == replace(again, reward=seen.reward)  # which differs by rounding
    assert again.reward == pytest.approx(seen.reward, abs=1e-9)
    itself = evaluate(SB3Policy(policy.model, deterministic=False), CONFIG, episodes=20)
    assert itself.success_rate == itself.sampled_success_rate == seen.sampled_success_rate
    assert np.isnan(evaluate(SB3Policy(trained("TD3", small())), CONFIG).sampled_success_rate)
