"""CleanRL's way of PPO: one file and one loop over ``gymnasium.make_vec``, written anew."""

import json
from itertools import chain
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.wrappers.vector import NormalizeObservation, RecordEpisodeStatistics
from torch import nn
from torch.distributions import Normal

import coopenv

IDS = ["coopenv/BeamTransport-v0", "coopenv/BeamTracking-v0"]
WORLDS, STEPS, EPOCHS, BATCH = 64, 32, 4, 512
DISCOUNT, TRACE, CLIP, RATE = 0.98, 0.95, 0.2, 1e-3


class Agent(nn.Module):
    """A Gaussian over the joint action, and a value."""

    def __init__(self, seen: int, done: int):
        super().__init__()
        self.mean = nn.Sequential(nn.Linear(seen, 64), nn.Tanh(), nn.Linear(64, done))
        self.value = nn.Sequential(nn.Linear(seen, 64), nn.Tanh(), nn.Linear(64, 1))
        self.log_std = nn.Parameter(torch.full((done,), -0.5))

    def policy(self, obs: torch.Tensor) -> Normal:
        return Normal(self.mean(obs), self.log_std.exp())


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    torch.manual_seed(0)
    easy = coopenv.TransportTask(position_tolerance=0.5, angle_tolerance=0.6, speed_tolerance=1.0)
    returns = train(IDS[0], updates=25, task=easy)
    first, last = (float(np.mean([*chain(*part)])) for part in (returns[:8], returns[-8:]))
    assert last > first, (first, last)
    train(IDS[1], updates=4)
    told = {
        "library": "CleanRL's loop",
        "version": "ours, on Gymnasium " + gymnasium.__version__,
        "ids": IDS,
        "checked": "PPO in one file on make_vec with 64 worlds: returns rise in 51,200 steps, "
        "weights stay finite and come back from a file",
    }
    print(json.dumps(told))


def train(view: str, updates: int, **keywords: Any) -> list[list[float]]:
    """Returns of the episodes that ended before each update."""
    envs = gymnasium.make_vec(view, WORLDS, horizon=60, autoreset_mode="NextStep", **keywords)
    envs = NormalizeObservation(RecordEpisodeStatistics(envs))
    agent = Agent(*(space.shape[1] for space in (envs.observation_space, envs.action_space)))
    optimizer = torch.optim.Adam(agent.parameters(), lr=RATE, eps=1e-5)
    obs, begun = tensor(envs.reset(seed=0)[0]), torch.zeros(WORLDS)
    returns: list[list[float]] = []
    for _ in range(updates):
        batch, obs, begun, ended = roll_out(envs, agent, obs, begun)
        returns.append(ended)
        learn(agent, optimizer, batch)
    with TemporaryDirectory() as folder:
        torch.save(agent.state_dict(), f"{folder}/agent.pt")
        again = torch.load(f"{folder}/agent.pt", weights_only=True)
    for name, weight in agent.state_dict().items():
        assert torch.isfinite(weight).all()
        assert torch.equal(weight, again[name])
    return returns


def roll_out(envs: Any, agent: Agent, obs: torch.Tensor, begun: torch.Tensor) -> Any:
    """``STEPS`` of every world, with advantages; returns of the episodes that ended."""
    seen, done, chance, reward, begins, value = ([] for _ in range(6))
    ended: list[float] = []
    for _ in range(STEPS):
        with torch.no_grad():
            policy = agent.policy(obs)
            action = policy.sample()
            value.append(agent.value(obs)[:, 0])
        seen.append(obs)
        done.append(action)
        chance.append(policy.log_prob(action).sum(-1))
        begins.append(begun)
        next_obs, earned, terminated, truncated, info = envs.step(action.numpy())
        reward.append(tensor(earned))
        obs, begun = tensor(next_obs), tensor(terminated | truncated)
        if "episode" in info:
            ended += info["episode"]["r"][info["_episode"]].tolist()
    with torch.no_grad():
        after, advantage, trace = agent.value(obs)[:, 0], [], torch.zeros(WORLDS)
    for k in reversed(range(STEPS)):  # the step after an end resets: it is no experience
        on = 1 - (begins[k + 1] if k + 1 < STEPS else begun)
        trace = reward[k] + DISCOUNT * on * after - value[k] + DISCOUNT * TRACE * on * trace
        advantage.insert(0, trace)
        after = value[k]
    lists = (seen, done, chance, advantage, [a + v for a, v in zip(advantage, value, strict=True)])
    keep = torch.stack(begins).reshape(-1) == 0
    return [torch.cat(one)[keep] for one in lists], obs, begun, ended


def learn(agent: Agent, optimizer: torch.optim.Optimizer, batch: list[torch.Tensor]) -> None:
    """A few epochs of the clipped objective."""
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(batch[0])).split(BATCH):
            obs, action, chance, advantage, target = (one[rows] for one in batch)
            policy = agent.policy(obs)
            ratio = (policy.log_prob(action).sum(-1) - chance).exp()
            advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
            gain = torch.min(ratio * advantage, ratio.clamp(1 - CLIP, 1 + CLIP) * advantage)
            loss = ((agent.value(obs)[:, 0] - target) ** 2).mean() / 2 - gain.mean()
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimizer.step()


def tensor(array: Any) -> torch.Tensor:
    return torch.as_tensor(np.asarray(array), dtype=torch.float32)


if __name__ == "__main__":
    main()
