"""Policies that are trained for suites of the benchmark: ``python -m benchmarks.board.learners``.

python -m benchmarks.board.learners                       # trains what runs/board lacks
python -m benchmarks.board.learners --only bodies-joint-0

Each is one run of ``coopenv train`` in a folder of its own, so the same command goes on after a
kill. At the end stands the command that enters each.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro
from rich.console import Console

from coopenv import TransportConfig
from coopenv.agents.benchmark import SUITES
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.presets import train_config
from coopenv.errors import UnknownName

OUT = Path("runs/board")
WITHIN = "within the training range"  # scenario of the suite of bodies


@dataclass(frozen=True, kw_only=True)
class Learner:
    """A training for a suite, by ``coopenv train`` with what is changed of it."""

    suite: str
    config: TrainConfig
    environment: TransportConfig | None = None
    """What it learns in, if ``config`` does not say it all."""


def _of_bodies(control: Any, seed: int) -> Learner:
    """In the range of bodies that the suite allows."""
    (within,) = (one for one in SUITES["bodies"].scenarios if one.name == WITHIN)
    config = TrainConfig(control=control, seed=seed)
    return Learner(suite="bodies", config=config, environment=within.config)


def _beside_population(**changes: Any) -> Learner:
    """Beside the partners that those of the suite are unlike."""
    choice = EnvironmentChoice(partner="population")
    return Learner(suite="partners", config=train_config(choice, control="partner", **changes))


LEARNERS: Mapping[str, Learner] = {
    "bodies-joint-0": _of_bodies("joint", 0),
    "bodies-shared-0": _of_bodies("shared", 0),
    "bodies-joint-1": _of_bodies("joint", 1),
    "bodies-shared-1": _of_bodies("shared", 1),
    "population-0": _beside_population(seed=0),
    "population-long-0": _beside_population(seed=0, steps=1_800_000),
}


@dataclass(frozen=True, kw_only=True)
class Learners:
    """Train what is lacking of the learned entries."""

    only: tuple[str, ...] = ()
    """Names; none: all."""
    out: Path = OUT
    """Folder for the runs."""

    def __post_init__(self) -> None:
        for name in self.only:
            if name not in LEARNERS:
                raise UnknownName("learner", name, LEARNERS)


def run(asked: Learners, tell: Callable[[str], None] = print) -> None:
    """Train each; what is finished is taken as it is."""
    for name in asked.only or LEARNERS:
        learner = LEARNERS[name]
        tell(f"{name}:")
        config = replace(learner.config, out=asked.out / name)
        train(config, environment=learner.environment, tell=tell)


def main() -> None:
    """Train what the command line asks for."""
    asked, console = tyro.cli(Learners, description=__doc__), Console()
    run(asked, lambda line: console.print(line, markup=False, soft_wrap=True))


if __name__ == "__main__":
    main()
