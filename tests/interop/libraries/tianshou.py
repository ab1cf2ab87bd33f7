"""Tianshou: PPO over its own vector of Gymnasium views, infos in its buffer."""

import json
from tempfile import TemporaryDirectory

import gymnasium
import numpy as np
import tianshou
import torch
from tianshou.algorithm.modelfree.ppo import PPO
from tianshou.algorithm.modelfree.reinforce import ProbabilisticActorPolicy
from tianshou.algorithm.optim import AdamOptimizerFactory
from tianshou.data import Collector, CollectStats, VectorReplayBuffer
from tianshou.env import DummyVectorEnv
from tianshou.trainer import OnPolicyTrainerParams
from tianshou.utils.net.common import Net
from tianshou.utils.net.continuous import ContinuousActorProbabilistic, ContinuousCritic
from torch.distributions import Distribution, Independent, Normal

import coopenv  # noqa: F401 - whose ids Gymnasium then knows

IDS = ["coopenv/BeamTransport-v0", "coopenv/WalkerTurn-v0"]
WORLDS, HORIZON = 4, 20


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for view in IDS:
        learn(view)
    checked = (
        "a Collector's buffer holds every key of the infos; PPO changes finite weights, which come "
        "back from a file"
    )
    version = tianshou.__version__
    told = {"library": "Tianshou", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def learn(view: str) -> None:
    """A few updates of PPO."""
    single = gymnasium.make(view)
    algorithm = made(single)
    envs = DummyVectorEnv([lambda: gymnasium.make(view, horizon=HORIZON) for _ in range(WORLDS)])
    buffer = VectorReplayBuffer(1024, WORLDS)
    collector = Collector[CollectStats](algorithm, envs, buffer)
    collector.collect(n_step=40 * WORLDS, reset_before_collect=True)
    held, (_, told) = buffer[:], single.reset(seed=0)
    assert len(held) >= 40 * WORLDS
    assert set(told) <= set(held.info.keys())
    for name, value in told.items():
        assert held.info[name].shape == (len(held), *np.shape(value)), name
    assert held.truncated.sum() + held.terminated.sum() >= WORLDS
    collector.reset()
    before = [weight.detach().clone() for weight in algorithm.policy.parameters()]
    algorithm.run_training(
        OnPolicyTrainerParams(
            training_collector=collector,
            max_epochs=1,
            epoch_num_steps=256,
            collection_step_num_env_steps=128,
            batch_size=64,
            update_step_num_repetitions=2,
            verbose=False,
            show_progress=False,
        )
    )
    after = list(algorithm.policy.parameters())
    assert any(not torch.equal(a, b) for a, b in zip(before, after, strict=True))
    assert all(torch.isfinite(weight).all() for weight in after)
    again = made(single)
    with TemporaryDirectory() as folder:
        torch.save(algorithm.state_dict(), f"{folder}/ppo.pt")
        again.load_state_dict(torch.load(f"{folder}/ppo.pt", weights_only=False))
    pairs = zip(after, again.policy.parameters(), strict=True)
    assert all(torch.equal(a, b) for a, b in pairs)


def made(env: gymnasium.Env) -> PPO:
    """A new PPO with small networks."""
    seen, done = env.observation_space.shape, env.action_space.shape
    net = Net(state_shape=seen, hidden_sizes=[32])
    actor = ContinuousActorProbabilistic(preprocess_net=net, action_shape=done, unbounded=True)
    policy = ProbabilisticActorPolicy(
        actor=actor,
        dist_fn=gaussian,
        action_space=env.action_space,
        observation_space=env.observation_space,
    )
    critic = ContinuousCritic(preprocess_net=Net(state_shape=seen, hidden_sizes=[32]))
    return PPO(policy=policy, critic=critic, optim=AdamOptimizerFactory(lr=1e-3))


def gaussian(moments: tuple[torch.Tensor, torch.Tensor]) -> Distribution:
    """A distribution over the joint action."""
    return Independent(Normal(*moments), 1)


if __name__ == "__main__":
    main()
