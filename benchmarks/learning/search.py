"""Search of PPO's settings for speed: ``python -m benchmarks.learning.search [--write]``.

One factor at a time, from what was best before. A trial trains BeamTransport until 98 % of held-out
episodes succeed (`TrainConfig.until`), or to the end of its steps where its settings say how many,
and counts the processor's seconds. Its policy is tested on held-out episodes of the search's own;
seeds of trainings are no others' either. Trials that docs/training/search.json holds are not run
again. ``--write`` puts the table of all of them into docs/training.md.
"""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from math import ceil, isnan, nan
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from typing import Any

import tyro
from rich.console import Console

from benchmarks.learning.budget import lacking
from benchmarks.learning.stages import SEEDS, STAGES, WARM
from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.evaluate import evaluate
from coopenv.agents.policy import Policy
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.threads import torch_threads
from coopenv.errors import InvalidInput
from coopenv.files import locked, written

FILE, PAGE = DOCS / "training" / "search.json", DOCS / "training.md"
UNTIL = 0.98  # of held-out episodes
STEPS = 400_000  # control steps after which a trial is given up
EVALUATION, EPISODES = 3, 250  # held-out episodes of the search
COLUMNS = ("stage", "settings", "CPU s", "control steps", "gradient steps", "success", "γ")
Settings = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A training that was tried, and what it took."""

    settings: Settings  # of `TrainConfig`
    seed: int
    reached: bool  # the target, or the end of the steps; else given up, or diverged
    seconds: float  # of the processor, imports aside
    steps: int
    gradient_steps: int
    success: float = nan  # of its mean actions on the search's held-out episodes
    relative_cost: float = nan  # γ


@dataclass(frozen=True, kw_only=True)
class Search:
    """Run what is lacking of the search."""

    write: bool = False
    """Put the table into docs/training.md."""
    minutes: float = 25.0
    """Of the processor, after which no further trial begins."""


def run(settings: Mapping[str, Any], seed: int) -> Trial:
    """Train once, in a folder that is removed."""
    done: list[int] = [0]
    told: list[str] = []
    found: dict[str, Any] = {"reached": False}
    with TemporaryDirectory() as folder:
        ends = {} if "steps" in settings else {"steps": STEPS, "until": UNTIL}
        config = TrainConfig(**{**ends, **settings}, seed=seed, out=Path(folder) / "run")
        began = time.process_time()
        try:
            policy = train(
                config, report=lambda row: done.append(int(row["steps"])), tell=told.append
            )
        except InvalidInput as error:
            if "diverged" not in str(error):
                raise
            found["seconds"] = round(time.process_time() - began, 2)
        else:
            found["seconds"] = round(time.process_time() - began, 2)
            found["reached"] = not ends or any("held-out" in line for line in told)
            found.update(_tested(policy))
    rows = config.num_worlds * config.rollout
    return Trial(
        settings=dict(settings),
        seed=seed,
        steps=done[-1],
        gradient_steps=(len(done) - 1) * config.epochs * ceil(rows / min(config.batch_size, rows)),
        **found,
    )


def _tested(policy: Policy) -> dict[str, float]:
    with torch_threads(1):
        seen = evaluate(policy, episodes=EPISODES, seed=EVALUATION)
    return {"success": seen.success_rate, "relative_cost": round(seen.relative_cost, 4)}


def saved() -> list[Trial]:
    """What was tried so far."""
    if not FILE.exists():
        return []
    return [Trial(**given) for given in json.loads(FILE.read_text(encoding="utf-8"))]


def save(trials: list[Trial]) -> None:
    """Write all trials, one a line."""
    lines = ",\n".join(json.dumps(_written(trial)) for trial in trials)
    with written(FILE) as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def _written(trial: Trial) -> Settings:
    """Without what is not known, for which JSON has no number."""
    return {name: value for name, value in asdict(trial).items() if value == value}


def search(minutes: float, tell: Callable[[str], None] = print) -> list[Trial]:
    """Run the trials that are lacking, until so many minutes of the processor are spent."""
    trials = saved()
    run(WARM, 0)  # what is imported or compiled at first use

    def is_done(piece: tuple[str, Settings, int]) -> bool:
        return any(_is_of(trial, *piece[1:]) for trial in trials)

    for stage, settings, seed in lacking(planned(), is_done, minutes, tell):
        trials.append(run(settings, seed))
        save(trials)
        tell(f"{stage}: {json.dumps(_written(trials[-1]))}")
    return trials


def planned() -> list[tuple[str, Settings, int]]:
    """Stage, settings and seed of every trial."""
    return [
        (stage, {**base, **change}, seed)
        for stage, (base, changes) in STAGES.items()
        for change in changes
        for seed in SEEDS
    ]


def table(trials: list[Trial]) -> str:
    """One row a setting, seeds side by side."""
    rows = []
    for stage, (base, changes) in STAGES.items():
        for change in changes:
            mine = [t for s in SEEDS for t in trials if _is_of(t, {**base, **change}, s)]
            if not mine:
                continue
            rows.append(
                (
                    stage,
                    ", ".join(f"{name} {value}" for name, value in change.items()) or "as before",
                    ", ".join(f"{t.seconds:.1f}" if t.reached else "–" for t in mine),
                    ", ".join(f"{t.steps:,}" for t in mine),
                    f"{mean(t.gradient_steps for t in mine):,.0f}",
                    ", ".join(_shown(t.success, ".1%") for t in mine),
                    ", ".join(_shown(t.relative_cost, ".3f") for t in mine),
                )
            )
    return markdown(COLUMNS, rows)


def _shown(value: float, form: str) -> str:
    return "–" if isnan(value) else format(value, form)


def _is_of(trial: Trial, settings: Settings, seed: int) -> bool:
    return (trial.settings, trial.seed) == (settings, seed)


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Search), Console()
    with locked(FILE.parent):  # a second search would write over the trials of the first
        made = table(search(asked.minutes, lambda line: console.print(line, markup=False)))
    console.print(made, markup=False, soft_wrap=True)
    if asked.write:
        fill(PAGE, {"search": made})


if __name__ == "__main__":
    main()
