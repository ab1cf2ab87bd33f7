"""Policies of the reward-shaping grid that were trained, and what each of them does."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from benchmarks.pages import DOCS
from coopenv.agents.experiments.report.results import Results
from coopenv.arrays import FloatArray
from coopenv.files import written

RUNS = DOCS / "results" / "reward_shaping" / "runs.csv"
SHARED = "_80_20"  # ends the name of a reward with a wanted share
SUCCESS, SAMPLED, TIME = "success_rate", "sampled_success_rate", "success_time"
SHARE = "force_load_share_0"
MEASURES = {  # name -> title, digits after the point
    SUCCESS: ("success [%]", 1),
    SAMPLED: ("sampled [%]", 1),  # by sampled actions
    TIME: ("time [s]", 2),
    "relative_cost": ("γ", 3),
    "internal_force_level": ("F_I [N]", 2),
    "wasted_cost": ("wasted cost [N]", 2),
    SHARE: ("load of agent 0", 2),
}
KEPT = (*MEASURES, "internal_torque_level")


@dataclass(frozen=True, kw_only=True)
class Run:
    """A policy that was trained, and what it does."""

    action: str
    price: str
    share: str  # a key of SHARES
    seed: int
    measured: dict[str, float]  # NaN where undefined


def take(folder: Path) -> None:
    """Write what an experiment came to into the table of runs."""
    results = Results.load(folder)
    revisions = {run.revision for run in results.runs}
    names = ["action", "reward", "seed", *KEPT]
    rows = [
        [run.levels["action"], run.levels["reward"], run.seed, *_kept(run.numbers)]
        for run in results.runs
    ]
    RUNS.parent.mkdir(parents=True, exist_ok=True)
    with written(RUNS) as part, part.open("w", newline="", encoding="utf-8") as file:
        file.write(f"# revision {', '.join(sorted(map(str, revisions)))}\n")
        csv.writer(file, lineterminator="\n").writerows([names, *rows])


def _kept(numbers) -> list[str]:
    found = [numbers[name] for name in KEPT]
    return [f"{x:.5g}" if isfinite(x) else "" for x in found]


def saved() -> list[Run]:
    """The runs that docs hold."""
    with RUNS.open(newline="", encoding="utf-8") as file:
        file.readline()  # the revision
        rows = [*csv.DictReader(file)]
    return [
        Run(
            action=row["action"],
            price=row["reward"].removesuffix(SHARED),
            share=SHARED if row["reward"].endswith(SHARED) else "",
            seed=int(row["seed"]),
            measured={name: float(row[name] or "nan") for name in KEPT},
        )
        for row in rows
    ]


def of(runs: Sequence[Run], action: str, price: str, share: str, measure: str) -> FloatArray:
    """``(run,)`` of a measure, of the runs in which it is defined; success in percent."""
    mine = [run for run in runs if (run.action, run.price, run.share) == (action, price, share)]
    values = np.array([run.measured[measure] for run in mine])
    return (100.0 if measure in (SUCCESS, SAMPLED) else 1.0) * values[np.isfinite(values)]
