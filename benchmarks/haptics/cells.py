"""Cells of the benchmark of feeling hands: which follower, action and beam, and what came out."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from coopenv import Body, TransportConfig
from coopenv.agents.episodes import Episodes
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.policy import Policy
from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.files import reading, written
from coopenv.rewards import RewardSum
from coopenv.transition import Transition

EVALUATION = 5  # number of the evaluation; gains were searched on another
BEAMS: Mapping[str, tuple[float, int]] = {  # mass [kg], horizon [control steps]
    "7.7 kg": (7.7, 200),
    "20 kg": (20.0, 300),
}
ACTIONS = ("motion", "wrench")
_EFFORT = "effort"


class Cell(NamedTuple):
    """One figure's worth: a scripted follower, or a learner's run of one seed."""

    follower: str
    action: str
    beam: str
    seed: int | None = None  # of a learner
    rows: int | None = None  # that it learns from: steps of an agent

    @property
    def name(self) -> str:
        """Of its file."""
        parts = (self.action, self.beam, self.follower, self.seed, self.rows)
        name = "_".join(str(part) for part in parts if part is not None)
        return name.replace(",", "").replace("γ", "gamma").replace(" ", "-")


@dataclass(frozen=True, kw_only=True)
class Found:
    """What a cell's held-out episodes showed, in their mean."""

    cell: Cell
    episodes: int
    success: float  # part of the episodes
    steps: float | None  # of the successful ones; None where there is none
    effort: float  # ‖f‖ of an agent [N]
    relative_cost: float  # γ
    internal_force: float  # F_I [N]
    seconds: float  # processor time of the whole cell

    @classmethod
    def of(cls, cell: Cell, seen: Episodes, seconds: float) -> "Found":
        """Summarise episodes that `measured` ran."""
        done = seen.success
        force = seen.costs[f"cost/{_EFFORT}"].mean(axis=1) / seen.length
        return cls(
            cell=cell,
            episodes=len(done),
            success=float(done.mean()),
            steps=float(seen.length[done].mean()) if done.any() else None,
            effort=float(force.mean()),
            relative_cost=float(seen.relative_cost.mean()),
            internal_force=float(seen.internal_force_level.mean()),
            seconds=seconds,
        )

    def save(self, folder: Path) -> None:
        """Keep it as a small file, whole or not at all."""
        folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps({**asdict(self), "cell": self.cell._asdict()}, indent=1)
        with written(folder / f"{self.cell.name}.json") as part:
            part.write_text(text + "\n", encoding="utf-8")


def read_found(path: Path) -> Found:
    """What `Found.save` wrote.

    Raises
    ------
    InvalidInput
        If it is no such file.
    """
    with reading(path):
        text = path.read_text(encoding="utf-8")
    try:
        given: dict[str, Any] = json.loads(text)
        return Found(**{**given, "cell": Cell(**given["cell"])})
    except (ValueError, TypeError, KeyError) as error:
        raise InvalidInput(
            f"{path} must hold a finished cell, got something else ({error}); remove it"
        ) from error


def kept(folders: Sequence[Path]) -> dict[Cell, Found]:
    """All finished cells of some folders, those of later ones in place of earlier ones'."""
    files = [path for folder in folders for path in sorted(folder.glob("*.json"))]
    return {found.cell: found for found in map(read_found, files)}


def environment(cell: Cell, **others: Any) -> TransportConfig:
    """What a cell's team acts in; agent 0 alone is told the goal, each sees what it can sense."""
    mass, horizon = BEAMS[cell.beam]
    keywords = {"informed": (0,), "sensing": "own", **others}
    body = Body(mass=mass)
    return TransportConfig.parse(
        {"action": cell.action, "body": body, "horizon": horizon, **keywords}
    )


def measured(policy: Policy, config: TransportConfig, episodes: int) -> Episodes:
    """Held-out episodes of all followers alike, with what `Found.of` needs."""
    cost = RewardSum({_EFFORT: pull})
    return run_episodes(
        policy, replace(config, cost=cost), episodes=episodes, seed=EVALUATION, num_worlds=250
    )


def pull(transition: Transition) -> FloatArray:
    """Minus the magnitude ``(world, agent)`` of the force that each gives [N]."""
    return -np.linalg.norm(transition.applied[..., :2], axis=-1)


def grid(followers: Sequence[str], seeds: Sequence[int | None], rows: int | None) -> Iterator[Cell]:
    """Every follower with every action and beam, one seed after the other."""
    for seed in seeds:
        for action in ACTIONS:
            for beam in BEAMS:
                for follower in followers:
                    yield Cell(follower, action, beam, seed, rows)
