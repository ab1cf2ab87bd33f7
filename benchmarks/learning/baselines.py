"""Baselines of every environment: ``python -m benchmarks.learning.baselines [--write]``.

PPO with one policy for the team (joint) and with one for every agent alike (shared), as ``coopenv
train --env ID --control CONTROL --seed N`` trains it, five seeds each. Every policy is tested on
the same held-out episodes, by its mean actions and by sampled ones. Runs that
docs/training/baselines holds are not run again, unless the settings are others now. Two processes
may run at a time if no environment with a control is of both.
``--write`` puts the tables of all of them into docs/training.md and docs/training/partners.md.

``--controls partner`` trains the agent that is left beside a partner, ``--partners`` says beside
whom, as ``coopenv train --control partner --partner NAME``; ``--actions motion`` gives hands, as
``coopenv train --action motion``:

    python -m benchmarks.learning.baselines --controls partner --partners leader follower --seeds 0
    python -m benchmarks.learning.baselines --controls joint --actions motion --seeds 0 1
"""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import tyro
from rich.console import Console

from benchmarks.learning.budget import lacking
from benchmarks.learning.run import Run, configured, is_of, settings_of
from benchmarks.learning.tables import hands, names, partners, row, table
from benchmarks.pages import DOCS, fill
from coopenv.agents.curves import Row
from coopenv.agents.evaluate import evaluate
from coopenv.agents.partners import find_partner
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.threads import torch_threads
from coopenv.files import written

FOLDER, PAGE = DOCS / "training" / "baselines", DOCS / "training.md"
OTHERS, BESIDE_PAGE = "partners", DOCS / "training" / "partners.md"  # beside partners, by hands
EPISODES = 500  # held-out ones of each policy
LEVELS = (0.9, 0.98)  # success rates of the exploring policy whose time is told
HANDS = ("motion", "impedance")  # actions that a partner which feels needs

__all__ = ["Baselines", "Run", "configured", "is_of", "names", "row", "run_all", "saved", "table"]


@dataclass(frozen=True, kw_only=True)
class Baselines:
    """Run what is lacking of the baselines."""

    envs: tuple[str, ...] = ()
    """Names such as BeamLift; none: all."""
    controls: tuple[str, ...] = ("joint", "shared")
    """Who has a policy: joint, shared, partner."""
    partners: tuple[str, ...] = ()
    """With controls partner, who is beside the learner; none: the default of each environment."""
    actions: tuple[str, ...] = ()
    """What agents give, motion for example; none: what the environment has."""
    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Training runs of each."""
    minutes: float = 60.0
    """Of the processor, after which no further training begins."""
    out: Path = Path("runs/baselines")
    """Folder for the runs."""
    write: bool = False
    """Put the tables into docs/training.md and docs/training/partners.md."""


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
        partner=config.environment.partner,
        action=config.environment.action,
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
        for file in sorted(FOLDER.rglob(f"{pattern}.json"))
        for each in json.loads(file.read_text(encoding="utf-8"))
    ]
    return [Run(**{**each, "reached": tuple(each["reached"])}) for each in given]


def save(run: Run) -> None:
    """Write a run among those of its name, one a line."""
    runs = [run, *(other for other in saved(run.name) if other.seed != run.seed)]
    runs.sort(key=lambda one: one.seed)
    lines = ",\n".join(json.dumps(one.to_dict()) for one in runs)
    folder = FOLDER if run.is_plain else FOLDER / OTHERS
    folder.mkdir(parents=True, exist_ok=True)
    with written(folder / f"{run.name}.json") as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def planned(asked: Baselines) -> Iterator[tuple[str, TrainConfig]]:
    """Environment and settings of every run, the first seed of all before the second.

    Partners that feel are beside hands alone.
    """
    for control in asked.controls:
        beside = (asked.partners or (None,)) if control == "partner" else (None,)
        every = product(asked.seeds, asked.envs or names(), asked.actions or (None,), beside)
        for seed, env, action, partner in every:
            if partner is None or action in HANDS or not find_partner(partner).needs_hands:
                others = {"partner": partner, "action": action}
                yield env, configured(env, control, seed, asked.out, **others)


def run_all(asked: Baselines, tell: Callable[[str], None] = print) -> list[Run]:
    """Run what is lacking, until so many minutes of the processor are spent."""

    def is_done(piece: tuple[str, TrainConfig]) -> bool:
        return any(is_of(run, *piece) for run in saved())

    for env, config in lacking(planned(asked), is_done, asked.minutes, tell):
        made = learn(config, env)
        save(made)
        tell(json.dumps(made.to_dict()))
    return saved()


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Baselines), Console()

    def tell(line: str) -> None:
        console.print(line, markup=False, soft_wrap=True)

    runs = run_all(asked, tell)
    beside = {"partners": partners(runs), "hands": hands(runs)}
    made = {"baselines": table(runs), **beside}
    tell("\n\n".join(made.values()))
    if asked.write:
        fill(PAGE, {"baselines": made["baselines"]})
        fill(BESIDE_PAGE, beside)


if __name__ == "__main__":
    main()
