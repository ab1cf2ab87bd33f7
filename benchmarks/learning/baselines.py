"""Baselines of every environment: ``python -m benchmarks.learning.baselines [--write]``.

PPO with one policy for the team (joint) and with one for every agent alike (shared), as ``coopenv
train --env ID --control CONTROL --seed N`` trains it, five seeds each. Every policy is tested on
the same held-out episodes, by its mean actions and by sampled ones. Runs that
docs/training/baselines holds are not run again, unless the settings are others now. Two processes
may run at a time if no environment with a control is of both.
``--write`` puts the table of all of them into docs/training.md.
"""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gymnasium
import tyro
from rich.console import Console

from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.curves import Row
from coopenv.agents.evaluate import evaluate
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.presets import train_config
from coopenv.agents.training.threads import torch_threads
from coopenv.envs.registry import PREFIX
from coopenv.files import written

FOLDER, PAGE = DOCS / "training" / "baselines", DOCS / "training.md"
EPISODES = 500  # held-out ones of each policy
NONE = "None of these runs is finished yet."  # in the place of a table without rows
LEVELS = (0.9, 0.98)  # success rates of the exploring policy whose time is told
COLUMNS = (
    *("environment", "policy", "seed", "success", "sampled", "time [s]", "γ"),
    *("control steps", "CPU s", "to 90 %", "to 98 %"),
)
APART = ("environment", "control", "seed", "threads", "checkpoint_every", "out")


@dataclass(frozen=True, kw_only=True)
class Run:
    """A training, and what its policy does."""

    env: str  # without "coopenv/" and version
    control: str
    seed: int
    settings: Mapping[str, Any]  # of `TrainConfig`
    steps: int  # that were done
    seconds: float  # of the processor, imports aside
    reached: tuple[float | None, ...]  # [s] until each of `LEVELS`; None where it never was
    success: float  # of its mean actions
    sampled: float  # of sampled ones
    time: float | None  # [s] of the episodes that succeed
    relative_cost: float  # γ


@dataclass(frozen=True, kw_only=True)
class Baselines:
    """Run what is lacking of the baselines."""

    envs: tuple[str, ...] = ()
    """Names such as BeamLift; none: all."""
    controls: tuple[str, ...] = ("joint", "shared")
    """Who has a policy."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Training runs of each."""
    minutes: float = 60.0
    """Of the processor, after which no further training begins."""
    out: Path = Path("runs/baselines")
    """Folder for the runs."""
    write: bool = False
    """Put the table into docs/training.md."""


def names() -> list[str]:
    """Of all environments, without prefix and version."""
    mine = (name for name in gymnasium.registry if name.startswith(PREFIX))
    return [name.removeprefix(PREFIX).partition("-")[0] for name in mine]


def configured(env: str, control: str, seed: int, out: Path) -> TrainConfig:
    """A run as ``coopenv train`` has it, from its start, since its seconds count."""
    given = {"control": control, "seed": seed, "out": out / f"{env}_{control}_{seed}"}
    return train_config(f"{PREFIX}{env}-v0", **given, fresh=True)


def settings_of(config: TrainConfig) -> dict[str, Any]:
    """What the runs of an environment and a control have in common."""
    return {name: value for name, value in config.to_dict().items() if name not in APART}


def learn(config: TrainConfig, env: str) -> Run:
    """Train and evaluate."""
    curve: list[tuple[float, Row]] = []
    environment = config.environment.config()
    began = time.process_time()
    policy = train(config, report=lambda row: curve.append((time.process_time() - began, row)))
    seconds = time.process_time() - began
    with torch_threads(1):
        seen = evaluate(policy, environment, episodes=EPISODES)
    whole = config.num_worlds * environment.horizon  # control steps of one episode of each world
    return Run(
        env=env,
        control=config.control,
        seed=config.seed,
        settings=settings_of(config),
        steps=int(curve[-1][1]["steps"]),
        seconds=round(seconds, 1),
        reached=tuple(reached(curve, level, whole) for level in LEVELS),
        success=seen.success_rate,
        sampled=seen.sampled_success_rate,
        time=round(seen.success_time, 2) if seen.success_rate else None,
        relative_cost=round(seen.relative_cost, 4),
    )


def reached(curve: Sequence[tuple[float, Row]], level: float, after: int) -> float | None:
    """When the exploring policy first succeeded so often [s], ``after`` so many control steps.

    Before the longest of the first episodes may have ended, those that have are mostly the short
    ones, which succeeded.
    """
    fair = ((at, row) for at, row in curve if row["steps"] >= after)
    times = (at for at, row in fair if row.get("success", 0.0) >= level)
    first = next(times, None)
    return None if first is None else round(first, 1)


def saved(pattern: str = "*") -> list[Run]:
    """What was run so far, of the files whose stem fits a pattern."""
    given = [
        each
        for file in sorted(FOLDER.glob(f"{pattern}.json"))
        for each in json.loads(file.read_text(encoding="utf-8"))
    ]
    return [Run(**{**each, "reached": tuple(each["reached"])}) for each in given]


def save(run: Run) -> None:
    """Write a run among those of its environment and control, one a line."""
    name = f"{run.env}_{run.control}"
    runs = [run, *(other for other in saved(name) if other.seed != run.seed)]
    runs.sort(key=lambda one: one.seed)
    lines = ",\n".join(json.dumps(asdict(one)) for one in runs)
    with written(FOLDER / f"{name}.json") as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def planned(asked: Baselines) -> Iterator[tuple[str, TrainConfig]]:
    """Environment and settings of every run, the first seed of all before the second."""
    for control in asked.controls:
        for seed in asked.seeds:
            for env in asked.envs or names():
                yield env, configured(env, control, seed, asked.out)


def run_all(asked: Baselines, tell: Callable[[str], None] = print) -> list[Run]:
    """Run what is lacking, until so many minutes of the processor are spent."""
    began = time.process_time()
    for env, config in planned(asked):
        if any(is_of(run, env, config) for run in saved()):
            continue
        if time.process_time() - began >= 60 * asked.minutes:
            tell("the budget is spent; the same command goes on")
            break
        made = learn(config, env)
        save(made)
        tell(json.dumps(asdict(made)))
    return saved()


def is_of(run: Run, env: str, config: TrainConfig) -> bool:
    """Whether a run is the one that is asked for, with the settings of today."""
    mine = run.env, run.control, run.seed, dict(run.settings)
    return mine == (env, config.control, config.seed, settings_of(config))


def placed(runs: Sequence[Run]) -> list[Run]:
    """Runs by environment, control and seed."""
    order = names()
    return sorted(runs, key=lambda run: (order.index(run.env), run.control, run.seed))


def table(runs: Sequence[Run]) -> str:
    """One row a run; a sentence where there is none."""
    return markdown(COLUMNS, [row(run) for run in placed(runs)]) if runs else NONE


def row(run: Run) -> tuple[str, ...]:
    """Cells of a run."""
    return (
        run.env,
        run.control,
        f"{run.seed}",
        f"{run.success:.1%}",
        f"{run.sampled:.1%}",
        "–" if run.time is None else f"{run.time:.1f}",
        f"{run.relative_cost:.3f}",
        f"{run.steps:,}",
        f"{run.seconds:.0f}",
        *("–" if at is None else f"{at:.0f}" for at in run.reached),
    )


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Baselines), Console()
    made = table(run_all(asked, lambda line: console.print(line, markup=False, soft_wrap=True)))
    console.print(made, markup=False, soft_wrap=True)
    if asked.write:
        fill(PAGE, {"baselines": made})


if __name__ == "__main__":
    main()
