"""Policies that are trained for suites of the benchmark: ``python -m benchmarks.board.learners``.

python -m benchmarks.board.learners                       # trains what runs/board lacks
python -m benchmarks.board.learners --only bodies-joint-0

Each is one run of `coopenv.agents.train.train` in a folder of its own: what is finished is taken as
it is, and after a kill the same command goes on.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import tyro
from rich.console import Console

from benchmarks.board import hands
from coopenv import TransportConfig
from coopenv.agents.benchmark import SUITES
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.presets import train_config
from coopenv.errors import UnknownName

WITHIN = "within the training range"  # scenario of the suite of bodies
HANDS_STEPS = 600_000  # of each of the two by hands
SHORT_STEPS = 400_000  # as many as the shared policy of the package has, for comparison
Run = tuple[TrainConfig, TransportConfig | None]  # None: the environment that the settings name


def of_bodies(control: Literal["joint", "shared"], seed: int, out: Path, **changes: Any) -> Run:
    """In the range of bodies that the suite allows."""
    (within,) = (one for one in SUITES["bodies"].scenarios if one.name == WITHIN)
    return TrainConfig(control=control, seed=seed, **changes), within.config


def beside_population(seed: int, out: Path) -> Run:
    """Beside the partners that those of the suite are unlike."""
    choice = EnvironmentChoice(partner="population")
    return train_config(choice, control="partner", seed=seed), None


def leading(out: Path) -> Run:
    """By hands and told the goal, beside the partner that gives way."""
    config = TrainConfig(control="partner", steps=HANDS_STEPS)
    return config, hands.environment("compliant", agent=1)


def following(out: Path) -> Run:
    """By hands and not told the goal, beside the leader."""
    config = TrainConfig(control="partner", steps=HANDS_STEPS)
    return config, hands.environment(f"{hands.policy_of(hands.LEADER, out)}", agent=0)


LEARNERS: Mapping[str, Callable[[Path], Run]] = {  # name -> its run; a partner before who needs it
    "bodies-joint-0": partial(of_bodies, "joint", 0),
    "bodies-shared-0": partial(of_bodies, "shared", 0),
    "bodies-shared-short-0": partial(of_bodies, "shared", 0, steps=SHORT_STEPS),
    "population-0": partial(beside_population, 0),
    hands.LEADER: leading,
    hands.FOLLOWER: following,
}


@dataclass(frozen=True, kw_only=True)
class Learners:
    """Train what is lacking of the learned entries."""

    only: tuple[str, ...] = ()
    """Names; none: all."""
    out: Path = hands.OUT
    """Folder for the runs."""

    def __post_init__(self) -> None:
        for name in self.only:
            if name not in LEARNERS:
                raise UnknownName("learner", name, LEARNERS)


def run(asked: Learners, tell: Callable[[str], None] = print) -> None:
    """Train each; what is finished is taken as it is."""
    for name, made in LEARNERS.items():
        if asked.only and name not in asked.only:
            continue
        tell(f"{name}:")
        config, environment = made(asked.out)
        train(replace(config, out=asked.out / name), environment=environment, tell=tell)


def main() -> None:
    """Train what the command line asks for."""
    asked, console = tyro.cli(Learners, description=__doc__), Console()
    run(asked, lambda line: console.print(line, markup=False, soft_wrap=True))


if __name__ == "__main__":
    main()
