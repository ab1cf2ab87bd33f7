"""Seconds from process start to a policy: ``python -m benchmarks.learning.speed [--write]``.

BeamTransport by the defaults of `coopenv.agents.settings.TrainConfig`, five seeds, each a process
of its own: Python starts, imports, trains and writes the policy. Once until 98 % of held-out
episodes succeed (``until=0.98``), once to the end of its steps and its curves. Kernels were
compiled before. Not counted are the 500 other held-out episodes on which the policy is tested
afterwards. ``--write`` puts the table into docs/training.md; rows of ways and seeds that were not
asked for stay.
"""

import json
import os
import platform
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tyro
from rich.console import Console

from benchmarks.pages import DOCS, cells, fill, markdown

PAGE = DOCS / "training.md"
UNTIL = 0.98  # of held-out episodes
COLUMNS = (*("training", "seed", "control steps", "wall [s]", "CPU [s]", "load", "success", "γ"),)
WAYS: Mapping[str, Mapping[str, Any]] = {
    "until=0.98": {"until": UNTIL, "steps": 300_000},
    "to its end": {},
}


@dataclass(frozen=True, kw_only=True)
class Speed:
    """Time trainings from process start."""

    seeds: tuple[int, ...] = (0, 1, 2, 3, 4)
    """Training runs; the search of settings has others."""
    episodes: int = 500
    """Held-out episodes on which each policy is tested, other than those that end a training."""
    ways: tuple[str, ...] = tuple(WAYS)
    """Of ending: until=0.98, to its end."""
    write: bool = False
    """Put the table into docs/training.md."""


def timed(settings: Mapping[str, Any]) -> dict[str, Any]:
    """What `benchmarks.learning.timed` prints of one training.

    Raises
    ------
    subprocess.CalledProcessError
        If it fails.
    """
    with TemporaryDirectory() as folder:
        given = json.dumps({**settings, "out": str(Path(folder) / "run")})
        command = [sys.executable, "-m", "benchmarks.learning.timed", given, repr(time.time())]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def rows(speed: Speed, tell: Callable[[str], None] = print) -> list[Sequence[str]]:
    """One row a training."""
    warm = {"steps": 20_000, "until": UNTIL, "episodes": 1}
    timed(warm)  # compiles what is not in the cache
    made = []
    for way in speed.ways:
        for seed in speed.seeds:
            load = os.getloadavg()[0]
            found = timed({**WAYS[way], "seed": seed, "episodes": speed.episodes})
            made.append(
                (
                    way,
                    f"{seed}",
                    f"{found['steps']:,}",
                    f"{found['wall']:.1f}",
                    f"{found['processor']:.1f}",
                    f"{load:.0f}",
                    f"{found['success']:.1%} (from {found['low']:.1%})",
                    f"{found['relative_cost']:.3f}",
                )
            )
            tell(" | ".join(made[-1]))
    return made


def with_others(made: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """The page's rows, with those that were ``made`` in place of their ways' and seeds'."""
    anew = {(row[0], row[1]) for row in made}
    kept = [row for row in cells(PAGE, "speed")[1:] if (row[0], row[1]) not in anew]
    return sorted([*kept, *made], key=lambda row: ([*WAYS].index(row[0]), int(row[1])))


def main() -> None:
    """Run what the command line asks for."""
    speed, console = tyro.cli(Speed), Console()
    made = rows(speed, lambda line: console.print(line, markup=False))
    table = markdown(COLUMNS, with_others(made) if speed.write else made)
    console.print(table, markup=False, soft_wrap=True)
    console.print(f"{os.cpu_count()} cores, {platform.machine()}")
    if speed.write:
        fill(PAGE, {"speed": table})


if __name__ == "__main__":
    main()
