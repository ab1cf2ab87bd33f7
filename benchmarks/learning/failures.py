"""Where a policy fails: ``python -m benchmarks.learning.failures POLICY [--evaluation 900]``.

Runs held-out episodes of the environment of its training and tells of those that did not succeed
how they ended: what the body touched, or how far from the goal it was.
"""

from collections import Counter
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
import tyro
from rich.console import Console

from benchmarks.pages import markdown
from coopenv.agents import load
from coopenv.agents.evaluate import run_episodes
from coopenv.agents.provenance import Provenance
from coopenv.arrays import BoolArray, FloatArray
from coopenv.geometry.clearance import ways_to_boxes, ways_to_walls
from coopenv.info import Info
from coopenv.transition import Transition

TOUCHING, BESIDE = 0.05, 0.5  # [m] from a wall or an obstacle, and from the goal
COLUMNS = ("it ended", "episodes")
_PLACE, _WALL, _BOX = range(3)  # columns of `reached`


@dataclass(frozen=True, kw_only=True)
class Failures:
    """Run episodes and sort those that fail."""

    policy: Annotated[str, tyro.conf.Positional]
    """File of a policy, or pretrained:WalkerAvoid/joint and the like."""
    evaluation: int = 900
    """Number of the evaluation, whose episodes no table is made of."""
    episodes: int = 500
    """How many of them."""


@dataclass
class Ends:
    """A watcher of `run_episodes` that keeps how every episode ended."""

    last: FloatArray = field(default_factory=lambda: np.empty((0, 3)))  # of the batch under way
    all: list[FloatArray] = field(default_factory=list)  # (episode, 3) each

    def add(
        self, transition: Transition, reward: FloatArray, info: Info, running: BoolArray
    ) -> None:
        """A step of the worlds that are ``running``."""
        if len(self.last) != len(running):
            self.last = np.full((len(running), 3), np.inf)
        self.last[running] = reached(transition)[running]

    def end(self, episodes: int) -> None:
        """A batch of so many has come to its end."""
        self.all.append(self.last[:episodes].copy())


def reached(transition: Transition) -> FloatArray:
    """``(world, 3)`` [m]: distance from the goal's place, way to the walls and to obstacles."""
    after, room = transition.next_state, transition.conditions.room
    outline = transition.conditions.load.outline
    away = np.hypot(*(after.goal - after.pose)[:, :2].T)
    walls = ways_to_walls(outline, after.pose, room.size).min(axis=1)
    boxes = np.full(len(away), np.inf)
    if room.boxes.shape[1]:
        boxes = ways_to_boxes(outline, after.pose, room.boxes, room.count)[..., 0].min(axis=1)
    return np.stack([away, walls, boxes], axis=-1)


def kind(end: FloatArray) -> str:
    """How an episode ended, in words."""
    touched = [name for name, at in (("wall", _WALL), ("obstacle", _BOX)) if end[at] < TOUCHING]
    if touched:
        return f"at {' and '.join(touched)}"
    return f"within {BESIDE} m of the goal" if end[_PLACE] < BESIDE else "elsewhere"


def failures(asked: Failures) -> Counter[str]:
    """How many episodes failed in which way."""
    policy: Any = load(asked.policy)
    provenance = Provenance.from_notes(policy.notes)
    assert provenance is not None
    ends = Ends()
    seen = run_episodes(
        policy, provenance.config(), episodes=asked.episodes, seed=asked.evaluation, recorder=ends
    )
    return Counter(kind(end) for end in np.concatenate(ends.all)[~seen.success])


def main() -> None:
    """Print what the command line asks for."""
    asked = tyro.cli(Failures)
    rows = [(name, str(count)) for name, count in failures(asked).most_common()]
    Console().print(markdown(COLUMNS, rows), markup=False, soft_wrap=True)


if __name__ == "__main__":
    main()
