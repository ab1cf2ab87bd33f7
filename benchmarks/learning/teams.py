"""One policy for any size of team: ``python -m benchmarks.learning.teams [--write]``.

PPO with one policy that every agent runs by itself, on plates, as ``coopenv train --control shared
--teams SIZES --steps 300000 --seed N`` trains it, and what it does in teams of 2 to 6. Beside teams
of several sizes, one size alone, and sizes without the blocks about the team. Runs that
docs/training/teams holds are not run again, unless the settings are others now. Several processes
may run at a time if no training with a seed is of two. ``--write`` puts the tables into
docs/training/teams.md.
"""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.console import Console

from benchmarks.learning.budget import lacking
from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.environment import with_team
from coopenv.agents.environment.teams import OF_ANY_TEAM
from coopenv.agents.evaluate import Evaluation, evaluate
from coopenv.agents.policy import Policy
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.presets import observing
from coopenv.agents.training.threads import torch_threads
from coopenv.config import TransportConfig
from coopenv.files import written

FOLDER, PAGE = DOCS / "training" / "teams", DOCS / "training" / "teams.md"
EPISODES, STEPS = 500, 300_000  # held-out ones of each policy and size; of a training
SIZES = (2, 3, 4, 5, 6)  # of the teams that are tested
TRAININGS: Mapping[str, tuple[int, ...]] = {
    "2_6": (2, 6),
    "2_4": (2, 4),
    "3": (3,),
    "2_6_plain": (2, 6),
}
PLAIN = "_plain"  # at the end of a name: without the blocks about the team
APART = ("environment", "seed", "threads", "checkpoint_every", "out")
NONE = "None of these runs is finished yet."  # in the place of a table without rows


@dataclass(frozen=True, kw_only=True)
class Run:
    """A training, and what its policy does in teams of every size."""

    training: str  # one of `TRAININGS`
    seed: int
    settings: Mapping[str, Any]  # of `TrainConfig`
    observe: Sequence[str]
    seconds: float  # of the processor, imports aside
    seen: Mapping[str, Mapping[str, float]]  # size of the team -> figures


@dataclass(frozen=True, kw_only=True)
class Teams:
    """Run what is lacking."""

    trainings: tuple[str, ...] = tuple(TRAININGS)
    """Which."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Training runs of each."""
    minutes: float = 30.0
    """Of the processor, after which no further training begins."""
    out: Path = Path("runs/teams")
    """Folder for the runs."""
    write: bool = False
    """Put the tables into docs/training/teams.md."""


def configured(training: str, seed: int, out: Path) -> TrainConfig:
    """A run as ``coopenv train`` has it, from its start, since its seconds count."""
    config = observing(
        TrainConfig(
            control="shared",
            teams=TRAININGS[training],
            steps=STEPS,
            seed=seed,
            out=out / f"{training}_{seed}",
            fresh=True,
        )
    )
    if not training.endswith(PLAIN):
        return config
    left = set(OF_ANY_TEAM[1:])
    observe = tuple(name for name in config.environment.observe or () if name not in left)
    chosen = EnvironmentChoice(team=config.teams[0], observe=observe, also_observe=())
    return replace(config, environment=chosen)


def settings_of(config: TrainConfig) -> dict[str, Any]:
    """What the runs of a training have in common."""
    return {name: value for name, value in config.to_dict().items() if name not in APART}


def figures(seen: Evaluation) -> dict[str, float]:
    """What the tables say of a policy in teams of a size."""
    return {
        "success": seen.success_rate,
        "sampled": seen.sampled_success_rate,
        "time": round(seen.success_time, 3),
        "relative_cost": round(seen.relative_cost, 4),
        "load_imbalance": round(seen.load_imbalance, 4),
    }


def tested(policy: Policy, environment: TransportConfig) -> dict[str, dict[str, float]]:
    """Figures in teams of every size."""
    with torch_threads(1):
        return {
            f"{size}": figures(evaluate(policy, with_team(environment, size), episodes=EPISODES))
            for size in SIZES
        }


def learn(config: TrainConfig, training: str) -> Run:
    """Train and evaluate."""
    environment = config.environment.config()
    began = time.process_time()
    policy = train(config)
    return Run(
        training=training,
        seed=config.seed,
        settings=settings_of(config),
        observe=[str(name) for name in environment.observe],
        seconds=round(time.process_time() - began, 1),
        seen=tested(policy, environment),
    )


def saved(pattern: str = "*") -> list[Run]:
    """What was run so far, of the files whose stem fits a pattern."""
    files = sorted(FOLDER.glob(f"{pattern}.json"))
    return [Run(**json.loads(file.read_text(encoding="utf-8"))) for file in files]


def save(run: Run) -> None:
    """Write a run into a file of its own."""
    with written(FOLDER / f"{run.training}_{run.seed}.json") as part:
        part.write_text(json.dumps(asdict(run), indent=1) + "\n", encoding="utf-8")


def planned(asked: Teams) -> Iterator[tuple[str, TrainConfig]]:
    """Name and settings of every run, the first seed of all before the second."""
    for seed in asked.seeds:
        for training in asked.trainings:
            yield training, configured(training, seed, asked.out)


def run_all(asked: Teams, tell: Callable[[str], None] = print) -> list[Run]:
    """Run what is lacking, until so many minutes of the processor are spent."""

    def is_done(piece: tuple[str, TrainConfig]) -> bool:
        training, config = piece
        return any(is_of(run, training, config) for run in saved(f"{training}_{config.seed}"))

    for training, config in lacking(planned(asked), is_done, asked.minutes, tell):
        made = learn(config, training)
        save(made)
        tell(json.dumps(asdict(made)))
    return saved()


def is_of(run: Run, training: str, config: TrainConfig) -> bool:
    """Whether a run is the one that is asked for, with the settings of today."""
    mine = run.training, run.seed, dict(run.settings), [*run.observe]
    observe = [*(config.environment.observe or ())]
    return mine == (training, config.seed, settings_of(config), observe)


def summary(runs: Sequence[Run]) -> str:
    """One row a training and size of team: mean over seeds, of success the worst seed too."""
    made = [
        cells(name, size, [run for run in runs if run.training == name])
        for name in TRAININGS
        for size in SIZES
        if any(run.training == name for run in runs)
    ]
    columns = (
        "trained on",
        "seeds",
        "team of",
        "",
        "success",
        "worst seed",
        "sampled",
        "time [s]",
        "γ",
    )
    return markdown((*columns, "skew"), made) if made else NONE


def cells(training: str, size: int, runs: Sequence[Run]) -> tuple[str, ...]:
    """A row of `summary`."""
    found = [run.seen[f"{size}"] for run in runs]
    mean = {name: float(np.mean([each[name] for each in found])) for name in found[0]}
    return (
        named(training),
        f"{len(runs)}",
        f"{size}",
        "seen" if size in TRAININGS[training] else "never seen",
        f"{mean['success']:.1%}",
        f"{min(each['success'] for each in found):.1%}",
        f"{mean['sampled']:.1%}",
        f"{mean['time']:.2f}",
        f"{mean['relative_cost']:.3f}",
        f"{mean['load_imbalance']:.2f}",
    )


def named(training: str) -> str:
    """What a training is called in the tables."""
    sizes = " and ".join(map(str, TRAININGS[training]))
    return f"{sizes}, without the two blocks" if training.endswith(PLAIN) else sizes


def single(runs: Sequence[Run]) -> str:
    """One row a run: its seconds, then success and γ in each size."""
    columns = ("trained on", "seed", "CPU s", *(f"success, γ of {size}" for size in SIZES))
    ordered = sorted(runs, key=lambda run: ([*TRAININGS].index(run.training), run.seed))
    made = [
        (
            named(run.training),
            f"{run.seed}",
            f"{run.seconds:.0f}",
            *(
                f"{run.seen[f'{size}']['success']:.1%}, {run.seen[f'{size}']['relative_cost']:.3f}"
                for size in SIZES
            ),
        )
        for run in ordered
    ]
    return markdown(columns, made) if made else NONE


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Teams), Console()
    runs = run_all(asked, lambda line: console.print(line, markup=False, soft_wrap=True))
    tables = {"teams": summary(runs), "teams-runs": single(runs)}
    console.print("\n\n".join(tables.values()), markup=False, soft_wrap=True)
    if asked.write:
        fill(PAGE, tables)


if __name__ == "__main__":
    main()
