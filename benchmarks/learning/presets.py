"""Comparison of reward presets: what PPO learns under each, with several training seeds.

``python -m benchmarks.learning.presets``.

Every policy is trained with `benchmarks.learning.settings.of_tables` and evaluated on the same
held-out episodes.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console

from benchmarks.learning.settings import of_tables
from coopenv.agents.curves import Row, draw
from coopenv.agents.evaluate import Evaluation, evaluate, save, table
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train


@dataclass(frozen=True, kw_only=True)
class Study:
    """Train every reward with every seed."""

    rewards: tuple[str, ...] = ("task", "harmony")
    """Presets of coopenv.rewards."""
    seeds: tuple[int, ...] = (3, 4, 5)
    """Training runs; the presets' weights were chosen on 0 to 2."""
    evaluation: int = 1
    """Number of the evaluation, which has episodes of its own; weights were chosen on 0."""
    episodes: int = 500
    """Held-out episodes for each policy."""
    out: Path = Path("runs/learning")
    """Folder for policies, table and curves."""
    training: TrainConfig = field(default_factory=of_tables)


def run(study: Study, tell: Callable[[str], None] = print) -> list[Evaluation]:
    """Train, evaluate, and write ``table.csv``, ``table.json`` and ``curves.png``."""
    seen: list[Evaluation] = []
    histories: dict[str, list[list[Row]]] = {reward: [] for reward in study.rewards}
    for reward in study.rewards:
        for seed in study.seeds:
            name = f"{reward} {seed}"
            rows: list[Row] = []
            environment = replace(study.training.environment, reward=reward)
            config = replace(
                study.training,
                environment=environment,
                seed=seed,
                out=study.out / f"{reward}_{seed}",
                fresh=True,
            )
            began = time.perf_counter()
            policy = train(config, report=rows.append)
            tell(f"{name}: trained in {time.perf_counter() - began:.0f} s")
            there = environment.config()
            seen.append(
                evaluate(policy, there, episodes=study.episodes, seed=study.evaluation, name=name)
            )
            histories[reward].append(rows)
    for file in ("table.csv", "table.json"):
        save(seen, study.out / file)
    draw(histories, study.out / "curves.png")
    return seen


def mean_relative_cost(seen: list[Evaluation], reward: str) -> float:
    """γ of a reward, averaged over its training seeds."""
    return float(
        np.mean([one.relative_cost for one in seen if one.policy.startswith(f"{reward} ")])
    )


def main() -> None:
    """Run the study that the command line describes and print its table."""
    console = Console()
    study = tyro.cli(Study)
    console.print(table(run(study, console.print)))


if __name__ == "__main__":
    main()
