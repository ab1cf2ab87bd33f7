"""Search of the followers' gains, on episodes that nothing else is measured on.

python -m benchmarks.followers          # prints the best of each; some minutes of one core

The scripted leader `Straight` alone knows the goal; beams of 7.7 and of 20 kg. Of a grid, that is
taken which takes the least part of the episodes' time, failures counted as all of it, in the mean
of both beams. The defaults of `Follower` and `ActiveFollower` are what came out.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from rich.progress import track

from coopenv import Body, TransportConfig
from coopenv.agents.controllers.active import ActiveFollower
from coopenv.agents.controllers.follower import Follower
from coopenv.agents.controllers.roles import Roles
from coopenv.agents.controllers.straight import Straight
from coopenv.agents.evaluate import run_episodes

SEED, EPISODES = 900, 100  # of the evaluation; tests and the page have other ones
BEAMS = {
    "7.7 kg": TransportConfig(action="motion", informed=(0,)),
    "20 kg": TransportConfig(action="motion", informed=(0,), body=Body(mass=20.0), horizon=300),
}
GRIDS: dict[type[Follower], dict[str, tuple[float, ...]]] = {
    Follower: {
        "anticipation": (0.0, 0.025, 0.05, 0.075, 0.1),
        "turn_compliance": (0.02, 0.1),
    },
    ActiveFollower: {
        "anticipation": (0.025, 0.05, 0.075),
        "turn_compliance": (0.05, 0.15),
        "move_share": (0.0, 0.15),
        "turn_share": (1.0, 2.0, 5.0, 10.0, 20.0),
    },
}


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What came of some gains, in the order of `BEAMS`."""

    gains: dict[str, float]
    success: tuple[float, ...]  # parts of the episodes
    time: tuple[float, ...]  # parts of the horizon

    @property
    def score(self) -> float:
        """Mean over the beams of the time that was taken; less is better."""
        return float(np.mean(self.time))

    def __str__(self) -> str:
        each = zip(BEAMS, self.success, self.time, strict=True)
        shown = [f"{beam} {100 * rate:.0f} %, {part:.3f}" for beam, rate, part in each]
        gains = ", ".join(f"{name}={value:g}" for name, value in self.gains.items())
        return f"{self.score:.3f}  {gains}: {'; '.join(shown)}"


def tried(kind: type[Follower], gains: dict[str, float]) -> Tried:
    """A follower with these gains, beside the leader."""
    success, time = [], []
    for config in BEAMS.values():
        team = Roles(config, {0: Straight(config), 1: kind(config, **gains)})
        seen = run_episodes(team, config, episodes=EPISODES, seed=SEED, num_worlds=EPISODES)
        success.append(float(seen.success.mean()))
        taken = np.where(seen.success, seen.length, config.horizon)
        time.append(float(taken.mean()) / config.horizon)
    return Tried(gains=gains, success=tuple(success), time=tuple(time))


def choices(kind: type[Follower]) -> Iterator[dict[str, float]]:
    """Every point of a follower's grid."""
    grid = GRIDS[kind]
    for values in product(*grid.values()):
        yield dict(zip(grid, values, strict=True))


def search(kind: type[Follower]) -> list[Tried]:
    """All points of its grid, the best first; of equal ones the first in the grid."""
    every = [*choices(kind)]
    return sorted((tried(kind, gains) for gains in track(every, kind.__name__)), key=_score)


def _score(one: Tried) -> float:
    return one.score


def main() -> None:
    """Print the best ten of each follower."""
    for kind in GRIDS:
        print(kind.__name__)
        for one in search(kind)[:10]:
            print(f"  {one}")


if __name__ == "__main__":
    main()
