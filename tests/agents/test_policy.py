"""Policies that are not learned: the random one."""

import numpy as np

from coopenv import Transport, TransportConfig
from coopenv.agents.evaluate import evaluate
from coopenv.agents.policy import RandomPolicy


def test_the_random_policy_does_not_arrive_and_repeats_with_its_seed():
    config = TransportConfig()
    assert evaluate(RandomPolicy(config), config, episodes=500).success_rate < 0.05
    core = Transport(num_worlds=50, config=config)
    obs, _ = core.reset(seed=0)
    start = core.transition
    assert start is not None
    first = RandomPolicy(config, seed=3)(obs, start)
    np.testing.assert_array_equal(first, RandomPolicy(config, seed=3)(obs, start))
    assert (first != RandomPolicy(config, seed=4)(obs, start)).all()
    assert first.shape == (50, 2, 3)
    assert -1 <= first.min() < -0.9 < 0.9 < first.max() <= 1


def test_random_actions_are_new_in_every_world_step_and_episode_and_uniform():
    config = TransportConfig(horizon=5)
    core = Transport(num_worlds=40, config=config)
    policy = RandomPolicy(config)
    drawn = []
    for episode in range(4):
        obs, _ = core.reset(seed=0 if episode == 0 else None)
        for _ in range(5):
            assert core.transition is not None
            drawn.append(policy(obs, core.transition))
            obs, *_ = core.step(drawn[-1])
    numbers = np.array(drawn).ravel()
    assert len(set(numbers.tolist())) == len(numbers)
    assert abs(numbers.mean()) < 0.03
    np.testing.assert_allclose(np.quantile(numbers, [0.1, 0.5, 0.9]), [-0.8, 0, 0.8], atol=0.04)
