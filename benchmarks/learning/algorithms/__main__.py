"""Other algorithms than PPO: ``python -m benchmarks.learning.algorithms [--write]``.

SAC and recurrent PPO with one policy for the team, and MAPPO, in every environment, with its own
actions or by hands (``--actions motion``). Every policy is tested on the held-out episodes of
`benchmarks.learning.baselines`, by its mean actions and by sampled ones. Runs that
docs/training/algorithms holds are not run again, unless the settings are others now. Two processes
may run at a time if no algorithm with an environment is of both.
``--write`` puts the tables into docs/training/algorithms.md. ``--policies FOLDER`` keeps the
policies' files, for ``coopenv benchmark 'FOLDER/sac_{task}_0.zip' --name sac --suites team``.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import NamedTuple

import tyro
from rich.console import Console

from benchmarks.learning.algorithms import search, tables
from benchmarks.learning.algorithms.environment import environment_of
from benchmarks.learning.algorithms.policies import file_of
from benchmarks.learning.algorithms.runs import (
    NAMES,
    Name,
    Run,
    learn,
    save,
    saved,
    settings_of,
    task_of,
)
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
    actions: tuple[str, ...] = ()
    """What agents give, motion for example; none: what the environment has."""
    seeds: tuple[int, ...] = (0,)
    """Training runs of each."""
    minutes: float = 60.0
    """Of the processor, after which no further training begins."""
    policies: Path | None = None
    """Folder in which policies are kept; runs whose policy it lacks are run again."""
    write: bool = False
    """Put the tables into docs/training/algorithms.md."""


class Piece(NamedTuple):
    """A training that is asked for."""

    name: Name
    env: str
    action: str | None  # None: as the environment has it
    seed: int


def planned(asked: Algorithms) -> Iterator[Piece]:
    """Every run, the first seed of all before the second."""
    envs, actions = asked.envs or names(), asked.actions or (None,)
    for seed, name, env, action in product(asked.seeds, asked.only, envs, actions):
        own = action == environment_of(env).action
        yield Piece(name, env, None if own else action, seed)


def is_of(run: Run, piece: Piece) -> bool:
    """Whether a run is the one that is asked for, with the settings of today."""
    mine = Piece(run.algorithm, run.env, run.action, run.seed)
    return mine == piece and dict(run.settings) == settings_of(*piece[:3])


def lacks_policy(folder: Path | None, piece: Piece) -> bool:
    """Whether a run's policy is wanted and not there."""
    if folder is None:
        return False
    task = task_of(piece.env, piece.action)
    return not file_of(folder, piece.name, task, piece.seed).exists()


def run_all(asked: Algorithms, tell: Callable[[str], None] = print) -> list[Run]:
    """Run what is lacking, until so many minutes of the processor are spent."""

    def is_done(piece: Piece) -> bool:
        made = saved(piece.name, task_of(piece.env, piece.action))
        return any(is_of(run, piece) for run in made) and not lacks_policy(asked.policies, piece)

    for piece in lacking(planned(asked), is_done, asked.minutes, tell):
        made = learn(piece.name, piece.env, piece.seed, piece.action, kept=asked.policies)
        save(made)
        tell(json.dumps(made.to_dict()))
    return saved()


def main() -> None:
    """Run what the command line asks for."""
    asked, console = tyro.cli(Algorithms), Console()
    runs = run_all(asked, lambda line: console.print(line, markup=False, soft_wrap=True))
    made = {
        "algorithms": tables.table(runs),
        "hands": tables.hands(runs),
        "cost": tables.cost(runs),
    }
    for text in made.values():
        console.print(text, markup=False, soft_wrap=True)
    if asked.write:
        fill(tables.PAGE, {**made, "search": search.table(search.saved())})


if __name__ == "__main__":
    main()
