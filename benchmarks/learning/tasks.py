"""Every environment with its default reward: ``python -m benchmarks.learning.tasks [--write]``.

The scripted controller and PPO (`benchmarks.learning.settings.of_tables`, several seeds)
on the same held-out episodes. ``--write`` puts the table into ``docs/tasks.md``; rows of
environments that were not asked for stay as they are there.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import gymnasium
import numpy as np
import tyro
from rich.console import Console
from rich.progress import track

from benchmarks.learning.settings import of_tables
from benchmarks.pages import DOCS, cells, fill, markdown
from coopenv.agents.controllers import find_controller
from coopenv.agents.curves import Row
from coopenv.agents.evaluate import Evaluation, evaluate
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.envs.registry import PREFIX

PAGE = DOCS / "tasks.md"
COLUMNS = ("environment", "policy", "success", "time [s]", "γ", "F_I [N]", "T_I [N·m]")
LEARNING = ("control steps", "training, CPU s", "to 90 %, CPU s")
STEPS = {  # where the default number of steps is too few
    "coopenv/BeamDoorway-v0": 1_200_000,
    "coopenv/WalkerAvoid-v0": 1_200_000,
    "coopenv/BeamLift-v0": 1_200_000,
}
REACHED = 0.9  # success rate during training, exploration noise included


@dataclass(frozen=True, kw_only=True)
class Tasks:
    """Train and evaluate every environment."""

    envs: tuple[str, ...] = ()
    """Gymnasium ids; none: all of coopenv."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Training runs of each."""
    episodes: int = 500
    """Held-out episodes for each policy."""
    write: bool = False
    """Put the table into docs/tasks.md."""
    out: Path = Path("runs/tasks")
    """Folder for the policies."""
    training: TrainConfig = field(default_factory=of_tables)


@dataclass(frozen=True, kw_only=True)
class Learned:
    """One training run: its policy's evaluation, and the processor time it took to get there."""

    evaluation: Evaluation
    seconds: float
    reached: float  # [s] until `REACHED`; NaN where it never was


def learn(tasks: Tasks, env: str, seed: int) -> Learned:
    """Train one policy and evaluate it."""
    environment = replace(tasks.training.environment, env=env)
    out = tasks.out / f"{env.removeprefix(PREFIX)}_{seed}"
    config = replace(
        tasks.training,
        environment=environment,
        seed=seed,
        steps=STEPS.get(env, tasks.training.steps),
        out=out,
        fresh=True,
    )
    moments: list[tuple[float, Row]] = []
    began = time.process_time()
    policy = train(config, report=lambda row: moments.append((time.process_time() - began, row)))
    seconds = time.process_time() - began
    reached = [after for after, row in moments if row.get("success", 0.0) >= REACHED]
    return Learned(
        evaluation=evaluate(policy, environment.config(), episodes=tasks.episodes),
        seconds=seconds,
        reached=min(reached, default=np.nan),
    )


def rows(tasks: Tasks, tell: Callable[[str], None] = print) -> list[tuple[str, ...]]:
    """One row a policy, PPO's seeds side by side in one cell."""
    envs = tasks.envs or tuple(name for name in gymnasium.registry if name.startswith(PREFIX))
    made = []
    for env in envs:
        config = replace(tasks.training.environment, env=env).config()
        scripted = evaluate(find_controller(config), config, episodes=tasks.episodes)
        name = env.removeprefix(PREFIX).partition("-")[0]
        made.append((name, "scripted", *_cells([scripted]), "", "", ""))
        learned = [learn(tasks, env, seed) for seed in track(tasks.seeds, name, transient=True)]
        made.append(
            (
                name,
                f"PPO, seeds {', '.join(map(str, tasks.seeds))}",
                *_cells([one.evaluation for one in learned]),
                f"{STEPS.get(env, tasks.training.steps):,}",
                _joined(f"{one.seconds:.0f}" for one in learned),
                _joined("–" if np.isnan(one.reached) else f"{one.reached:.0f}" for one in learned),
            )
        )
        tell(" | ".join(made[-2]))
        tell(" | ".join(made[-1]))
    return made


def with_others(made: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """The page's rows with those that were ``made`` in place of their environments'."""
    before = cells(PAGE, "learning")[1:]
    names = dict.fromkeys(row[0] for row in [*before, *made])
    anew = {row[0] for row in made}
    return [row for name in names for row in (made if name in anew else before) if row[0] == name]


def _cells(seen: Sequence[Evaluation]) -> tuple[str, ...]:
    return (
        _joined(f"{100 * one.success_rate:.1f} %" for one in seen),
        _joined("–" if not one.success_rate else f"{one.success_time:.1f}" for one in seen),
        _joined(f"{one.relative_cost:.3f}" for one in seen),
        _joined(f"{one.internal_force_level:.2f}" for one in seen),
        _joined(f"{one.internal_torque_level:.2f}" for one in seen),
    )


def _joined(values) -> str:
    return ", ".join(values)


def main() -> None:
    """Run what the command line asks for."""
    tasks, console = tyro.cli(Tasks), Console()
    table = markdown((*COLUMNS, *LEARNING), with_others(rows(tasks, console.print)))
    console.print(table, markup=False, soft_wrap=True)
    if tasks.write:
        fill(PAGE, {"learning": table})


if __name__ == "__main__":
    main()
