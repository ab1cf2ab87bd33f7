"""Search of SAC's settings: ``python -m benchmarks.learning.algorithms.search [--write]``.

A trial trains BeamTransport from `START` with what is changed, for at most `SECONDS` of the
processor. Its policy is tested on held-out episodes of the search's own; seeds of trainings are no
others' either. Trials that docs/training/algorithms/search.json holds are not run again. Several
processes may run at a time if each is given other trials. ``--write`` puts the table of all of them
into docs/training/algorithms.md.
"""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import tyro
from rich.console import Console

from benchmarks.learning.algorithms import sac
from benchmarks.learning.algorithms.runs import FOLDER
from benchmarks.learning.algorithms.space import CHANGES, SEED, START
from benchmarks.learning.algorithms.tables import NONE, PAGE
from benchmarks.learning.baselines import LEVELS, reached
from benchmarks.pages import fill, markdown
from coopenv.agents.evaluate import evaluate
from coopenv.agents.settings import EnvironmentChoice
from coopenv.agents.training.threads import torch_threads
from coopenv.envs.registry import PREFIX
from coopenv.files import written

FILE = FOLDER / "search.json"
ENV = "BeamTransport"
SECONDS = 80.0  # of the processor, after which a trial is given up
EVALUATION, EPISODES = 3, 250  # held-out episodes of the search
COLUMNS = ("changed", "control steps", "CPU s", "to 90 %", "to 98 %", "success", "sampled", "γ")


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A training that was tried, and what came of it."""

    changed: Mapping[str, Any]  # of `START`
    steps: int  # control steps that were done
    seconds: float  # of the processor
    reached: tuple[float | None, ...]  # [s] until each of `LEVELS`; None where it never was
    success: float  # of its mean actions
    sampled: float  # of sampled ones
    relative_cost: float  # γ


@dataclass(frozen=True, kw_only=True)
class Search:
    """Run what is lacking of the search."""

    only: tuple[int, ...] = ()
    """Numbers of trials, from 0; none: all."""
    minutes: float = 15.0
    """Of the processor, after which no further trial begins."""
    write: bool = False
    """Put the table into docs/training/algorithms.md."""


def run(changed: Mapping[str, Any]) -> Trial:
    """Train once and test."""
    recipe = replace(START, **changed)
    environment = EnvironmentChoice(env=f"{PREFIX}{ENV}-v0").config()
    with torch_threads(1):
        policy, curve = sac.learn(ENV, SEED, asdict(recipe), SECONDS)
        seconds = curve.seconds
        seen = evaluate(policy, environment, episodes=EPISODES, seed=EVALUATION)
    assert seen.sampled_success_rate is not None
    whole = recipe.num_worlds * environment.horizon
    return Trial(
        changed=dict(changed),
        steps=curve.steps,
        seconds=round(seconds, 1),
        reached=tuple(reached(curve.points, level, whole) for level in LEVELS),
        success=seen.success_rate,
        sampled=seen.sampled_success_rate,
        relative_cost=round(seen.relative_cost, 4),
    )


def saved() -> list[Trial]:
    """What was tried so far."""
    if not FILE.exists():
        return []
    given = json.loads(FILE.read_text(encoding="utf-8"))
    return [Trial(**{**each, "reached": tuple(each["reached"])}) for each in given]


def save(trial: Trial) -> None:
    """Write a trial behind the others, one a line."""
    lines = ",\n".join(json.dumps(asdict(one)) for one in [*saved(), trial])
    with written(FILE) as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def search(asked: Search, tell: Callable[[str], None] = print) -> list[Trial]:
    """Run the trials that are lacking, until so many minutes of the processor are spent."""
    began = time.process_time()
    for number in asked.only or range(len(CHANGES)):
        if any(trial.changed == CHANGES[number] for trial in saved()):
            continue
        if time.process_time() - began > 60 * asked.minutes:
            tell("the budget is spent; the same command goes on")
            break
        made = run(CHANGES[number])
        save(made)
        tell(json.dumps(asdict(made)))
    return saved()


def table(trials: list[Trial]) -> str:
    """One row a trial, in the order of the space; a sentence where there is none."""
    order = [trial for change in CHANGES for trial in trials if trial.changed == change]
    return markdown(COLUMNS, [_row(trial) for trial in order]) if order else NONE


def _row(trial: Trial) -> tuple[str, ...]:
    return (
        ", ".join(f"{name} {value}" for name, value in trial.changed.items()) or "nothing",
        f"{trial.steps:,}",
        f"{trial.seconds:.0f}",
        *("–" if at is None else f"{at:.0f}" for at in trial.reached),
        f"{trial.success:.1%}",
        f"{trial.sampled:.1%}",
        f"{trial.relative_cost:.3f}",
    )


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Search), Console()
    made = table(search(asked, lambda line: console.print(line, markup=False, soft_wrap=True)))
    console.print(made, markup=False, soft_wrap=True)
    if asked.write:
        fill(PAGE, {"search": made})


if __name__ == "__main__":
    main()
