"""skrl: PPO on our Gymnasium vectors, and its view of our PettingZoo environments."""

import json
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import torch
from skrl.agents.torch.ppo import PPO, PPO_CFG
from skrl.envs.wrappers.torch import wrap_env
from skrl.memories.torch import RandomMemory
from skrl.models.torch import DeterministicMixin, GaussianMixin, Model
from skrl.trainers.torch import SequentialTrainer
from torch import nn

import coopenv

MODULES = {
    "coopenv/BeamTransport-v0": coopenv.beam_transport_v0,
    "coopenv/BeamDoorway-v0": coopenv.beam_doorway_v0,
}
IDS = list(MODULES)
WORLDS, STEPS, HORIZON = 8, 64, 20


class Policy(GaussianMixin, Model):
    """A Gaussian over the joint action."""

    def __init__(self, env: Any):
        spaces = {"observation_space": env.observation_space, "action_space": env.action_space}
        Model.__init__(self, **spaces, device=env.device)
        GaussianMixin.__init__(self)
        self.net = nn.Linear(self.num_observations, self.num_actions)
        self.log_std = nn.Parameter(torch.zeros(self.num_actions))

    def compute(self, inputs: dict[str, Any], role: str = "") -> Any:
        return self.net(inputs["observations"]), {"log_std": self.log_std}


class Value(DeterministicMixin, Model):
    """What an observation is worth."""

    def __init__(self, env: Any):
        spaces = {"observation_space": env.observation_space, "action_space": env.action_space}
        Model.__init__(self, **spaces, device=env.device)
        DeterministicMixin.__init__(self)
        self.net = nn.Linear(self.num_observations, 1)

    def compute(self, inputs: dict[str, Any], role: str = "") -> Any:
        return self.net(inputs["observations"]), {}


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for view, module in MODULES.items():
        with TemporaryDirectory() as folder:
            learn(view, Path(folder))
        look(module)
    checked = (
        "PPO with the SequentialTrainer on make_vec changes finite weights, which come back from "
        "its file; the PettingZoo wrapper's shapes, state and ends"
    )
    told = {"library": "skrl", "version": version("skrl"), "ids": IDS, "checked": checked}
    print(json.dumps(told))


def learn(view: str, folder: Path) -> None:
    """PPO for a few updates."""
    env = wrap_env(gymnasium.make_vec(view, num_envs=WORLDS, horizon=HORIZON), verbose=False)
    agent = made(env, folder)
    before = [weight.detach().clone() for weight in agent.policy.parameters()]
    plan = {"timesteps": STEPS, "headless": True, "disable_progressbar": True}
    SequentialTrainer(env=env, agents=agent, cfg=plan).train()
    after = list(agent.policy.parameters())
    assert any(not torch.equal(a, b) for a, b in zip(before, after, strict=True))
    assert all(torch.isfinite(weight).all() for weight in after)
    agent.save(str(folder / "agent.pt"))
    again = made(env, folder)
    again.load(str(folder / "agent.pt"))
    pairs = zip(after, again.policy.parameters(), strict=True)
    assert all(torch.equal(a, b) for a, b in pairs)


def made(env: Any, folder: Path) -> PPO:
    """A new agent."""
    cfg = PPO_CFG(rollouts=16, learning_epochs=2, mini_batches=2)
    cfg.experiment.directory = str(folder)
    cfg.experiment.write_interval = cfg.experiment.checkpoint_interval = 0
    return PPO(
        models={"policy": Policy(env), "value": Value(env)},
        memory=RandomMemory(memory_size=16, num_envs=env.num_envs, device=env.device),
        observation_space=env.observation_space,
        action_space=env.action_space,
        device=env.device,
        cfg=cfg,
    )


def look(module: Any) -> None:
    """An episode of the multi-agent view."""
    env = wrap_env(module.parallel_env(horizon=HORIZON), verbose=False)
    obs, _ = env.reset()
    for _ in range(HORIZON):
        plan = {
            agent: 2 * torch.rand(1, *env.action_space(agent).shape) - 1 for agent in env.agents
        }
        obs, reward, terminated, truncated, _ = env.step(plan)
        for agent in env.possible_agents:
            assert obs[agent].shape == (1, *env.observation_space(agent).shape)
            assert torch.isfinite(reward[agent]).all()
        states = env.state()
        assert torch.equal(states["agent_0"], states["agent_1"])
        if terminated["agent_0"].any():
            return
    assert truncated["agent_0"].all()


if __name__ == "__main__":
    main()
