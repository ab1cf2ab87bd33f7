"""Other algorithms than PPO: ``python -m benchmarks.learning.algorithms [--write]``.

SAC and recurrent PPO with one policy for the team, and MAPPO, in every environment. Every policy is
tested on the held-out episodes of `benchmarks.learning.baselines`, by its mean actions and by
sampled ones. Runs that docs/training/algorithms holds are not run again, unless the settings are
others now. Two processes may run at a time if no algorithm with an environment is of both.
``--write`` puts the tables into docs/training/algorithms.md. ``--policies FOLDER`` keeps the
policies' files, for ``coopenv benchmark 'FOLDER/sac_{task}_0.zip' --name sac --suites team``.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import tyro
from rich.console import Console

from benchmarks.learning.algorithms import search, tables
from benchmarks.learning.algorithms.policies import file_of
from benchmarks.learning.algorithms.runs import NAMES, Name, Run, learn, save, saved, settings_of
from benchmarks.learning.baselines import names
from benchmarks.learning.budget import lacking
from benchmarks.pages import fill


@dataclass(frozen=True, kw_only=True)
class Algorithms:
    """Run what is lacking of the trainings."""

    only: tuple[Name, ...] = NAMES
    """Algorithms."""
    envs: tuple[str, ...] = ()
    """Names such as BeamLift; none: all."""
    seeds: tuple[int, ...] = (0,)
    """Training runs of each."""
    minutes: float = 60.0
    """Of the processor, after which no further training begins."""
    policies: Path | None = None
    """Folder in which policies are kept; runs whose policy it lacks are run again."""
    write: bool = False
    """Put the tables into docs/training/algorithms.md."""


def planned(asked: Algorithms) -> Iterator[tuple[Name, str, int]]:
    """Algorithm, environment and seed of every run, the first seed of all before the second."""
    for seed in asked.seeds:
        for name in asked.only:
            for env in asked.envs or names():
                yield name, env, seed


def is_of(run: Run, name: Name, env: str, seed: int) -> bool:
    """Whether a run is the one that is asked for, with the settings of today."""
    mine = run.algorithm, run.env, run.seed, dict(run.settings)
    return mine == (name, env, seed, settings_of(name, env))


def lacks_policy(asked: Algorithms, name: Name, env: str, seed: int) -> bool:
    """Whether a run's policy is wanted and not there."""
    folder = asked.policies
    return folder is not None and not file_of(folder, name, env, seed).exists()


def run_all(asked: Algorithms, tell: Callable[[str], None] = print) -> list[Run]:
    """Run what is lacking, until so many minutes of the processor are spent."""

    def is_done(piece: tuple[Name, str, int]) -> bool:
        made = any(is_of(run, *piece) for run in saved(*piece[:2]))
        return made and not lacks_policy(asked, *piece)

    for name, env, seed in lacking(planned(asked), is_done, asked.minutes, tell):
        made = learn(name, env, seed, asked.policies)
        save(made)
        tell(json.dumps(asdict(made)))
    return saved()


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Algorithms), Console()
    runs = run_all(asked, lambda line: console.print(line, markup=False, soft_wrap=True))
    made = {"algorithms": tables.table(runs), "cost": tables.cost(runs)}
    for text in made.values():
        console.print(text, markup=False, soft_wrap=True)
    if asked.write:
        fill(tables.PAGE, {**made, "search": search.table(search.saved())})


if __name__ == "__main__":
    main()
