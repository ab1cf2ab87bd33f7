"""TorchRL: its check of specs, its collector, PPO from its parts, and a replay buffer."""

import json

import torch
import torchrl
from torchrl.collectors import Collector
from torchrl.data import LazyTensorStorage, ReplayBuffer
from torchrl.envs import RewardSum, StepCounter, TransformedEnv
from torchrl.envs.utils import check_env_specs

import coopenv
from coopenv.agents.torchrl import make_env
from examples.train_torchrl import Config, success_rate, train

IDS = ["coopenv/BeamTransport-v0", "coopenv/WalkerAvoid-v0"]
EASY = coopenv.TransportTask(position_tolerance=0.5, angle_tolerance=0.6, speed_tolerance=1.0)
LEARNING = Config(total_steps=65_536, epochs=6)
AT_LEAST = 0.2  # by which the share of successes rises


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for view in IDS:
        collect(view)
    before, after = learn()
    assert after > before + AT_LEAST, (before, after)
    checked = (
        "check_env_specs; the collector's episodes end at the horizon and their returns are the "
        "sums of their rewards, through a replay buffer; PPO from TorchRL's parts learns: success "
        f"{before:.2f} before, {after:.2f} after {LEARNING.total_steps:,} steps"
    )
    told = {
        "library": "TorchRL", "version": torchrl.__version__, "ids": IDS, "checked": checked
    }  # fmt: skip
    print(json.dumps(told))


def collect(view: str) -> None:
    """Episodes of 5 steps, collected with TorchRL's own transforms and stored."""
    env = make_env(view, 8, horizon=5, info=True, return_state=True, seed=0)
    check_env_specs(env, break_when_any_done="both")
    transforms = StepCounter(), RewardSum(reset_keys=["_reset"])
    counted = TransformedEnv(env).append_transform(transforms[0]).append_transform(transforms[1])
    (batch,) = Collector(counted, None, frames_per_batch=80, total_frames=80)
    ends = batch["next", "done"].squeeze(-1)
    assert ends[:, 4::5].all()
    assert batch["next", "step_count"][:, 4].eq(5).all()
    reward, total = (batch["next", "agents", name] for name in ("reward", "episode_reward"))
    torch.testing.assert_close(total[:, 4], reward[:, :5].sum(dim=1))
    buffer = ReplayBuffer(storage=LazyTensorStorage(80), batch_size=32)
    buffer.extend(batch.reshape(-1))
    assert buffer.sample()["agents", "action"].shape[0] == 32


def learn() -> tuple[float, float]:
    """Share of successes before and after the training of the example, on an easy task."""
    untrained = Config(total_steps=1, rollout=1, epochs=0)
    rates = []
    for config in (untrained, LEARNING):
        policy = train(make_env(IDS[0], 64, task=EASY, seed=0), config)
        rates.append(success_rate(make_env(IDS[0], 100, task=EASY, seed=10**6), policy))
    return rates[0], rates[1]


if __name__ == "__main__":
    main()
