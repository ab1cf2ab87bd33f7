"""Search of each algorithm's settings: ``python -m benchmarks.learning.algorithms.search``.

A trial trains in an environment with what is changed of the start, for the control steps of its
`Space`. Its policy is tested on held-out episodes of the search's own; seeds of trainings are no
others' either. Trials that docs/training/algorithms/search holds are not run again. Two processes
may run at a time if no algorithm with an environment is of both. ``--write`` puts the tables into
docs/training/algorithms.md.
"""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

import tyro
from rich.console import Console

from benchmarks.learning.algorithms.environment import environment_of
from benchmarks.learning.algorithms.runs import FOLDER, NAMES
from benchmarks.learning.algorithms.space import KEPT, OF, SEED, Changed, Searched
from benchmarks.learning.algorithms.tables import NONE, PAGE, TITLES
from benchmarks.learning.baselines import LEVELS, names, reached
from benchmarks.learning.budget import lacking
from benchmarks.pages import fill, markdown
from coopenv.agents.evaluate import evaluate
from coopenv.agents.training.threads import torch_threads
from coopenv.files import written

SEARCHED: tuple[Searched, ...] = ("ppo", *NAMES)
TRIALS = FOLDER / "search"
EVALUATION, EPISODES = 3, 250  # held-out episodes of the search
SLACK = 0.01  # of the success rate, within which the quicker trial is taken
COLUMNS = (
    "environment",
    "algorithm",
    "changed",
    "control steps",
    "CPU s",
    "to 90 %",
    "to 98 %",
    "success",
    "sampled",
    "γ",
    "taken",
)


@dataclass(frozen=True, kw_only=True)
class Trial:
    """A training that was tried, and what came of it."""

    algorithm: Searched
    env: str
    changed: Changed  # of the start of the `Space`
    settings: Mapping[str, Any]  # all that the space says, as JSON has them
    steps: int  # control steps that were done
    seconds: float  # of the processor
    reached: tuple[float | None, ...]  # [s] until each of `LEVELS`; None where it never was
    success: float  # of its mean actions
    sampled: float  # of sampled ones
    relative_cost: float  # γ


@dataclass(frozen=True, kw_only=True)
class Search:
    """Run what is lacking of the search."""

    only: tuple[Searched, ...] = SEARCHED
    """Algorithms."""
    envs: tuple[str, ...] = ()
    """Names such as BeamLift; none: all."""
    minutes: float = 60.0
    """Of the processor, after which no further trial begins."""
    write: bool = False
    """Put the tables into docs/training/algorithms.md."""


def settings_of(name: Searched, env: str, changed: Changed) -> dict[str, Any]:
    """What the space says of a trial today, as JSON brings it back."""
    return json.loads(json.dumps(OF[name].settings(env, changed)))


def run(name: Searched, env: str, changed: Changed) -> Trial:
    """Train once and test."""
    module = import_module(f"{__package__}.{name}")
    settings = {**module.settings(env), **OF[name].settings(env, changed)}
    environment = environment_of(env)
    with torch_threads(1):
        began = time.process_time()
        policy, curve = module.learn(env, SEED, settings)
        seconds = time.process_time() - began
        seen = evaluate(policy, environment, episodes=EPISODES, seed=EVALUATION)
    assert seen.sampled_success_rate is not None
    whole = curve.num_worlds * environment.horizon
    return Trial(
        algorithm=name,
        env=env,
        changed=dict(changed),
        settings=settings_of(name, env, changed),
        steps=curve.steps,
        seconds=round(seconds, 1),
        reached=tuple(reached(curve.points, level, whole) for level in LEVELS),
        success=seen.success_rate,
        sampled=seen.sampled_success_rate,
        relative_cost=round(seen.relative_cost, 4),
    )


def saved(name: str = "*", env: str = "*") -> list[Trial]:
    """What was tried so far, of one algorithm and environment or of all."""
    given = [
        each
        for file in sorted(TRIALS.glob(f"{name}_{env}.json"))
        for each in json.loads(file.read_text(encoding="utf-8"))
    ]
    return [Trial(**{**each, "reached": tuple(each["reached"])}) for each in given]


def save(trial: Trial) -> None:
    """Write a trial behind the others of its algorithm and environment, over one of before."""
    others = saved(trial.algorithm, trial.env)
    every = [*(one for one in others if one.changed != trial.changed), trial]
    lines = ",\n".join(json.dumps(asdict(one)) for one in every)
    TRIALS.mkdir(parents=True, exist_ok=True)
    with written(TRIALS / f"{trial.algorithm}_{trial.env}.json") as part:
        part.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


def planned(asked: Search) -> Iterator[tuple[Searched, str, Changed]]:
    """Algorithm, environment and changes of every trial."""
    for env in asked.envs or names():
        for name in asked.only:
            for changed in OF[name].changes_in(env):
                yield name, env, changed


def search(asked: Search, tell: Callable[[str], None] = print) -> list[Trial]:
    """Run the trials that are lacking, until so many minutes of the processor are spent."""

    def is_done(piece: tuple[Searched, str, Changed]) -> bool:
        return any(trial.settings == settings_of(*piece) for trial in saved(*piece[:2]))

    for name, env, changed in lacking(planned(asked), is_done, asked.minutes, tell):
        made = run(name, env, changed)
        save(made)
        tell(json.dumps(asdict(made)))
    return saved()


def taken(trials: Sequence[Trial]) -> Trial:
    """Of the trials that succeed as often as the best does, or nearly, the quickest to 98 %.

    Where none came to 98 %, the one that succeeds most often.
    """
    best = max(trial.success for trial in trials)
    near = [trial for trial in trials if trial.success >= best - SLACK]

    def place(trial: Trial) -> tuple[float, float]:
        last = trial.reached[-1]
        return float("inf") if last is None else last, -trial.success

    return min(near, key=place)


def table(trials: Sequence[Trial]) -> str:
    """One row a trial, in the order of the space; a sentence where there is none."""
    rows: list[tuple[str, ...]] = []
    for env in names():
        for name in SEARCHED:
            mine = [one for one in trials if (one.env, one.algorithm) == (env, name)]
            order = [
                one for change in OF[name].changes_in(env) for one in mine if one.changed == change
            ]
            best = taken(order) if order else None
            mark = "kept others" if (name, env) in KEPT else "×"
            rows += [_row(one, mark if one is best else "") for one in order]
    return markdown(COLUMNS, rows) if rows else NONE


def _row(trial: Trial, mark: str) -> tuple[str, ...]:
    return (
        trial.env,
        TITLES[trial.algorithm],
        _told(trial.changed),
        f"{trial.steps:,}",
        f"{trial.seconds:.0f}",
        *("–" if at is None else f"{at:.0f}" for at in trial.reached),
        f"{trial.success:.1%}",
        f"{trial.sampled:.1%}",
        f"{trial.relative_cost:.3f}",
        mark,
    )


def _told(changed: Changed) -> str:
    return ", ".join(f"{name} {value}" for name, value in changed.items()) or "nothing"


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Search), Console()
    made = table(search(asked, lambda line: console.print(line, markup=False, soft_wrap=True)))
    console.print(made, markup=False, soft_wrap=True)
    if asked.write:
        fill(PAGE, {"search": made})


if __name__ == "__main__":
    main()
