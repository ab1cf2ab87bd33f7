"""What prices on disagreement do: ``python -m benchmarks.learning.shaping [--runs DIR] [--write]``.

``coopenv experiment examples/reward_shaping.toml --out DIR`` trains and evaluates; ``--runs DIR``
takes what came out of it into docs/results/reward_shaping/runs.csv. From that file come the tables
and the picture of docs/results/reward_shaping.md, which ``--write`` renews.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np
import tyro
from rich.console import Console

from benchmarks.learning.shaping_picture import Shown, draw
from benchmarks.pages import DOCS, fill, markdown
from coopenv.agents.experiments.report.results import Results
from coopenv.agents.experiments.report.statistics import (
    bootstrap_interval,
    interquartile_mean,
)
from coopenv.arrays import FloatArray
from coopenv.files import written

PAGE = DOCS / "results" / "reward_shaping.md"
RUNS, PICTURE = DOCS / "results" / "reward_shaping" / "runs.csv", PAGE.with_suffix(".png")
ACTIONS = {"wrench": "wrenches", "motion": "by hands"}
PRICES = {  # of the grid's rewards
    "none": "none",
    "effort": "effort",
    "difference": "difference along the beam",
    "moore_penrose": "internal force, Moore–Penrose",
    "plausible": "internal force, plausible",
    "relative_cost": "γ",
    "wasted_cost": "wasted cost",
    "internal_power": "internal power",
}
SHARED = "_80_20"  # ends the name of a reward with a wanted share
SHARES = {"": "any", SHARED: "80/20"}
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
PICTURED = (SUCCESS, TIME, "relative_cost", SHARE)
KEPT = (*MEASURES, "internal_torque_level")


@dataclass(frozen=True, kw_only=True)
class Run:
    """A policy that was trained, and what it does."""

    action: str
    price: str
    share: str  # a key of SHARES
    seed: int
    measured: dict[str, float]  # NaN where undefined


@dataclass(frozen=True, kw_only=True)
class Shaping:
    """Renew the page of the reward-shaping grid."""

    runs: Path | None = None
    """Folder of the experiment, whose results are taken into docs/results/reward_shaping."""
    write: bool = False
    """Put tables and picture onto docs/results/reward_shaping.md."""


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A number with its 95 % interval; NaN where it is undefined."""

    value: float
    low: float
    high: float

    def text(self, digits: int, *, sign: str = "") -> str:
        """``value [low, high]``."""
        if not isfinite(self.value):
            return "–"
        value, low, high = (f"{x:{sign}.{digits}f}" for x in (self.value, self.low, self.high))
        return f"{value} [{low}, {high}]"


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


def estimate(values: FloatArray) -> Estimate:
    """Interquartile mean over the training seeds."""
    return _estimate(interquartile_mean, values)


def difference(values: FloatArray, others: FloatArray) -> Estimate:
    """Of two interquartile means."""
    return _estimate(
        lambda one, two: interquartile_mean(one) - interquartile_mean(two), values, others
    )


def _estimate(statistic, *samples: FloatArray) -> Estimate:
    if not all(len(sample) for sample in samples):
        return Estimate(value=np.nan, low=np.nan, high=np.nan)
    groups = [[sample] for sample in samples]
    low, high = bootstrap_interval(statistic, *groups)
    return Estimate(value=float(statistic(*groups)), low=float(low), high=float(high))


def means(runs: Sequence[Run], action: str) -> str:
    """A row a reward: every measure."""
    columns = ("price on", "wanted share", *(title for title, _ in MEASURES.values()))
    rows = [
        [PRICES[price], SHARES[share], *cells]
        for share in SHARES
        for price in PRICES
        for cells in [
            [
                estimate(of(runs, action, price, share, name)).text(digits)
                for name, (_, digits) in MEASURES.items()
            ]
        ]
    ]
    return markdown(columns, rows)


def effects(runs: Sequence[Run], action: str) -> str:
    """A row a price: what it changes beside none, with the same wanted share."""
    columns = ("price on", "wanted share", *(title for title, _ in MEASURES.values()))
    rows = [
        [
            PRICES[price],
            SHARES[share],
            *(
                difference(
                    of(runs, action, price, share, name), of(runs, action, "none", share, name)
                ).text(digits, sign="+")
                for name, (_, digits) in MEASURES.items()
            ),
        ]
        for share in SHARES
        for price in [*PRICES][1:]
    ]
    return markdown(columns, rows)


def answer(runs: Sequence[Run]) -> str:
    """What a price on internal force does by its definition, with 80/20 wanted, in a sentence."""

    def less(name: str) -> str:
        both = [of(runs, "wrench", who, SHARED, name) for who in ("moore_penrose", "plausible")]
        return difference(*both).text(MEASURES[name][1])

    def rate(who: str) -> str:
        return estimate(of(runs, "motion", who, SHARED, SUCCESS)).text(1)

    return (
        "**With 80/20 of the load wanted and 0.1 a newton, teams that pay for the plausible "
        f"internal force reach the goal {less(TIME)} s sooner with wrenches than those that pay "
        f"for the Moore–Penrose one, at a γ lower by {less('relative_cost')}; by hands "
        f"{rate('plausible')} % of their episodes succeed, of the others' "
        f"{rate('moore_penrose')} %.**"
    )


def forbids(runs: Sequence[Run]) -> str:
    """A row a price: what it changes that no price on a fight should."""
    asked = {  # title -> action, wanted share and measure
        "time [s], wrenches": ("wrench", "", TIME),
        "load of agent 0 of 0.8 wanted, wrenches": ("wrench", SHARED, SHARE),
        "time [s], by hands": ("motion", "", TIME),
        "success [%], by hands": ("motion", "", SUCCESS),
        "sampled [%], by hands": ("motion", "", SAMPLED),
    }
    rows = [
        [
            PRICES[price],
            *(
                difference(
                    of(runs, action, price, share, name), of(runs, action, "none", share, name)
                ).text(MEASURES[name][1], sign="+")
                for action, share, name in asked.values()
            ),
        ]
        for price in [*PRICES][1:]
    ]
    return markdown(("price on", *asked), rows)


def tables(runs: Sequence[Run]) -> dict[str, str]:
    """All tables of the page."""
    made = {f"{action} means": means(runs, action) for action in ACTIONS}
    changes = {f"{action} effects": effects(runs, action) for action in ACTIONS}
    return {"answer": answer(runs), "forbids": forbids(runs), **made, **changes}


def shown(runs: Sequence[Run]) -> dict[str, dict[str, Shown]]:
    """Panels of the picture: action and measure, then a line a price and share."""
    panels: dict[str, dict[str, Shown]] = {}
    for action, who in ACTIONS.items():
        for name in PICTURED:
            panel = panels.setdefault(f"{who}: {MEASURES[name][0]}", {})
            for share, wanted in SHARES.items():
                for price, label in PRICES.items():
                    found = estimate(of(runs, action, price, share, name))
                    panel[f"{label}, {wanted}"] = (found.value, found.low, found.high)
    return panels


def main() -> None:
    """Take, print and write what the command line asks for."""
    asked, console = tyro.cli(Shaping), Console()
    if asked.runs is not None:
        take(asked.runs)
    made = tables(saved())
    for table in made.values():
        console.print(table, markup=False, soft_wrap=True)
    if asked.write:
        draw(shown(saved()), PICTURE)
        fill(PAGE, made)


if __name__ == "__main__":
    main()
