"""BenchMARL: MAPPO on tasks of ours, a few iterations with evaluation and logs."""

# pyright: reportMissingImports=false, reportAttributeAccessIssue=false

import csv
import json
import sys
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import torch
from torch import nn

# It asks for torchvision and uses it for pictures as observations alone; where that package is not
# of the same build as torch, importing it breaks TorchRL.
sys.modules.setdefault("torchvision", None)  # pyright: ignore[reportArgumentType]

from benchmarl.algorithms import MappoConfig  # noqa: E402
from benchmarl.experiment import Experiment, ExperimentConfig  # noqa: E402
from benchmarl.models import MlpConfig  # noqa: E402

from coopenv.agents.torchrl.benchmarl import make_task  # noqa: E402

IDS = ["coopenv/BeamTransport-v0", "coopenv/WalkerAvoid-v0"]
HORIZON = 30  # control steps
WORLDS = 16
ITERATIONS = 3


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    for view in IDS:
        with TemporaryDirectory() as folder:
            run(view, Path(folder))
    checked = (
        f"MAPPO changes its weights in {ITERATIONS} iterations of {WORLDS} worlds, evaluates in "
        "between and logs returns, success and γ; task and policy come back from a checkpoint"
    )
    told = {
        "library": "BenchMARL", "version": version("benchmarl"), "ids": IDS, "checked": checked
    }  # fmt: skip
    print(json.dumps(told))


def run(view: str, folder: Path) -> None:
    """An experiment on one id."""
    network = MlpConfig(num_cells=[32], activation_class=nn.Tanh, layer_class=nn.Linear)
    experiment = Experiment(
        task=make_task(view, horizon=HORIZON, reward="balanced"),
        algorithm_config=MappoConfig.get_from_yaml(),
        model_config=network,
        critic_model_config=network,
        seed=0,
        config=settings(folder),
    )
    before = weights(experiment)
    experiment.run()
    after = weights(experiment)
    assert any(not torch.equal(mine, theirs) for mine, theirs in zip(before, after, strict=True))
    assert experiment.n_iters_performed == ITERATIONS
    logs = {path.stem: path for path in folder.rglob("scalars/*.csv")}
    assert len(numbers(logs["collection_agents_reward_episode_reward_mean"])) > 0, sorted(logs)
    assert all(0 <= share <= 1 for share in numbers(logs["collection_success_rate"]))
    assert all(0 <= gamma <= 1 for gamma in numbers(logs["collection_agents_info_relative_cost"]))
    assert len(numbers(logs["eval_reward_episode_reward_mean"])) > 0
    (checkpoint,) = folder.rglob("checkpoint_*.pt")
    again = Experiment.reload_from_file(str(checkpoint))
    assert again.task == experiment.task
    assert all(torch.equal(a, b) for a, b in zip(weights(again), after, strict=True))


def settings(folder: Path) -> ExperimentConfig:
    """Small, on one processor, with logs as CSV."""
    config = ExperimentConfig.get_from_yaml()
    config.max_n_iters = ITERATIONS
    config.on_policy_n_envs_per_worker = WORLDS
    config.on_policy_collected_frames_per_batch = WORLDS * HORIZON
    config.on_policy_minibatch_size = 120
    config.on_policy_n_minibatch_iters = 2
    config.evaluation_interval = WORLDS * HORIZON
    config.evaluation_episodes = 4
    config.lr = 1e-3
    config.checkpoint_at_end = True
    config.render = False
    config.loggers = ["csv"]
    config.create_json = False
    config.save_folder = str(folder)
    return config


def weights(experiment: Experiment) -> list[torch.Tensor]:
    """Copies of the policy's weights."""
    return [each.detach().clone() for each in experiment.policy.parameters()]


def numbers(path: Path) -> list[float]:
    """Those of a log, one an iteration."""
    with path.open() as file:
        return [float(row[1]) for row in csv.reader(file)]


if __name__ == "__main__":
    main()
