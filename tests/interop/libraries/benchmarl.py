"""BenchMARL: MAPPO on tasks of ours, a few iterations with evaluation and logs."""

import csv
import json
import sys
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import torch

# It asks for torchvision and uses it for pictures as observations alone; where that package is not
# of the same build as torch, importing it breaks TorchRL.
sys.modules.setdefault("torchvision", None)  # pyright: ignore[reportArgumentType]

from benchmarl.algorithms import MappoConfig
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models import MlpConfig

from coopenv.agents.torchrl.benchmarl import make_task

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
        "between, and logs returns and γ; the task comes back from its pickle"
    )
    told = {
        "library": "BenchMARL", "version": version("benchmarl"), "ids": IDS, "checked": checked
    }  # fmt: skip
    print(json.dumps(told))


def run(view: str, folder: Path) -> None:
    """An experiment on one id."""
    experiment = Experiment(
        task=make_task(view, horizon=HORIZON, reward="balanced"),
        algorithm_config=MappoConfig.get_from_yaml(),
        model_config=MlpConfig(num_cells=[32], activation_class=torch.nn.Tanh, layer_class=torch.nn.Linear),
        critic_model_config=MlpConfig(num_cells=[32], activation_class=torch.nn.Tanh, layer_class=torch.nn.Linear),
        seed=0,
        config=settings(folder),
    )
    policy = experiment.policy
    before = [each.detach().clone() for each in policy.parameters()]
    experiment.run()
    assert any(
        not torch.equal(mine, theirs)
        for mine, theirs in zip(before, policy.parameters(), strict=True)
    )
    assert experiment.n_iters_performed == ITERATIONS
    logs = {path.stem: path for path in folder.rglob("scalars/*.csv")}
    assert len(rows(logs["collection_agents_reward_episode_reward_mean"])) > 0, sorted(logs)
    assert all(0 <= gamma <= 1 for gamma in rows(logs["collection_agents_info_relative_cost"]))
    assert len(rows(logs["eval_reward_episode_reward_mean"])) > 0
    again = Experiment.reload_from_file  # its task is read from a pickle
    del again


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
    config.render = False
    config.loggers = ["csv"]
    config.create_json = False
    config.save_folder = str(folder)
    return config


def rows(path: Path) -> list[float]:
    """The numbers of a log."""
    with path.open() as file:
        return [float(row[1]) for row in csv.reader(file)]


if __name__ == "__main__":
    main()
