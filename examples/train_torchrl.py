"""PPO from TorchRL's own parts learns to carry a beam: one policy for all agents, one critic."""

from collections.abc import Callable
from dataclasses import dataclass

import torch
import tyro
from tensordict import TensorDictBase
from tensordict.nn import TensorDictModule
from tensordict.nn.distributions import AddStateIndependentNormalScale
from torch import nn
from torchrl.collectors import Collector
from torchrl.envs.utils import ExplorationType, set_exploration_type
from torchrl.modules import IndependentNormal, MultiAgentMLP, ProbabilisticActor
from torchrl.objectives import ClipPPOLoss, ValueEstimators

from coopenv.agents import torchrl


@dataclass
class Config:
    """What can be changed: ``python examples/train_torchrl.py --num-worlds 256``."""

    env: str = "coopenv/BeamTransport-v0"  # any id
    total_steps: int = 200_000  # control steps over all worlds
    num_worlds: int = 64  # stepped together
    rollout: int = 128  # control steps of each world between two updates
    minibatch: int = 2048  # control steps in a gradient step
    epochs: int = 10  # times each control step is used
    learning_rate: float = 1e-3  # of Adam
    episodes: int = 200  # other ones, by which the policy is judged
    seed: int = 0  # world k is seeded with seed + k


class Scaled(nn.Module):
    """Brings observations, which are in SI units, to order one."""

    def __init__(self, env: torchrl.TransportTorchEnv):
        super().__init__()
        self.scale = nn.Buffer(torch.tensor(torchrl.feature_scale(env)))

    def forward(self, observation: torch.Tensor) -> torch.Tensor:
        """Observations times the factors."""
        return observation * self.scale


def network(env: torchrl.TransportTorchEnv, outputs: int, *, centralised: bool) -> nn.Module:
    """The same network for every agent; a centralised one sees what all agents see."""
    *_, agents, features = env.observation_spec["agents", "observation"].shape
    learned = MultiAgentMLP(
        n_agent_inputs=features,
        n_agent_outputs=outputs,
        n_agents=agents,
        centralized=centralised,
        share_params=True,
        num_cells=[64, 64],
        activation_class=nn.Tanh,
    )
    return nn.Sequential(Scaled(env), learned)


def make_policy(env: torchrl.TransportTorchEnv) -> ProbabilisticActor:
    """What each agent does, from what it sees itself."""
    size = env.full_action_spec["agents", "action"].shape[-1]
    return ProbabilisticActor(
        TensorDictModule(
            nn.Sequential(
                network(env, size, centralised=False),
                AddStateIndependentNormalScale(size, init_value=-0.5),  # log of the deviation
            ),
            in_keys=[("agents", "observation")],
            out_keys=[("agents", "loc"), ("agents", "scale")],
        ),
        in_keys=[("agents", "loc"), ("agents", "scale")],
        out_keys=[("agents", "action")],
        distribution_class=IndependentNormal,  # the core clips actions to [−1, 1]
        return_log_prob=True,
        log_prob_key=("agents", "sample_log_prob"),
    )


def make_loss(env: torchrl.TransportTorchEnv, policy: ProbabilisticActor) -> ClipPPOLoss:
    """PPO's loss and advantages, each agent's from its own reward."""
    critic = TensorDictModule(
        network(env, 1, centralised=True),
        in_keys=[("agents", "observation")],
        out_keys=[("agents", "state_value")],
    )
    loss = ClipPPOLoss(policy, critic, entropy_coeff=0.0)
    names = ("action", "sample_log_prob", "reward", "done", "terminated")
    loss.set_keys(value=("agents", "state_value"), **{name: ("agents", name) for name in names})
    loss.make_value_estimator(ValueEstimators.GAE, gamma=0.99, lmbda=0.95)
    return loss


def update(
    loss: ClipPPOLoss, optimiser: torch.optim.Optimizer, batch: TensorDictBase, config: Config
) -> None:
    """Learn from what was collected."""
    after = batch.get("next")
    for name in ("done", "terminated"):  # the agents of a world end together
        ends = after.get(name).unsqueeze(-2).expand_as(after.get(("agents", "reward")))
        after.set(("agents", name), ends)
    with torch.no_grad():
        loss.value_estimator(batch)
    advantage = batch["advantage"]
    batch["advantage"] = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
    steps = batch.reshape(-1)
    for _ in range(config.epochs):
        for chosen in torch.randperm(len(steps)).split(config.minibatch):
            losses = loss(steps[chosen])
            optimiser.zero_grad()
            (losses["loss_objective"] + losses["loss_critic"]).backward()
            nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
            optimiser.step()


def train(
    env: torchrl.TransportTorchEnv,
    config: Config,
    watch: Callable[[TensorDictBase], object] = lambda batch: None,
) -> ProbabilisticActor:
    """The policy after ``total_steps`` in ``env``; ``watch`` is shown what was collected."""
    torch.manual_seed(config.seed)
    policy = make_policy(env)
    loss = make_loss(env, policy)
    optimiser = torch.optim.Adam(loss.parameters(), lr=config.learning_rate)
    frames = env.batch_size.numel() * config.rollout
    updates = max(1, config.total_steps // frames)
    for batch in Collector(env, policy, frames_per_batch=frames, total_frames=updates * frames):
        watch(batch)
        update(loss, optimiser, batch, config)
    return policy


def success_rate(env: torchrl.TransportTorchEnv, policy: ProbabilisticActor) -> float:
    """Of an episode in each world, with the policy's mean actions."""
    horizon = env.transport.horizon
    with torch.no_grad(), set_exploration_type(ExplorationType.DETERMINISTIC):
        steps = env.rollout(horizon, policy, break_when_any_done=False, break_when_all_done=True)
    return steps["next", "terminated"].any(dim=1).float().mean().item()


def main(config: Config) -> None:
    """Train, and print how well it went."""
    torch.set_num_threads(1)  # more are slower at this size
    policy = train(torchrl.make_env(config.env, config.num_worlds, seed=config.seed), config)
    others = torchrl.make_env(config.env, config.episodes, seed=config.seed + 10**6)
    print(f"success {success_rate(others, policy):.2f} in {config.episodes} other episodes")


if __name__ == "__main__":
    main(tyro.cli(Config))
