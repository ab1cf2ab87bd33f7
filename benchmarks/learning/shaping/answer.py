"""Tables of the reward-shaping grid, and its answer in a sentence."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from benchmarks.learning.shaping.picture import Shown
from benchmarks.learning.shaping.runs import (
    MEASURES,
    SAMPLED,
    SHARE,
    SHARED,
    SUCCESS,
    TIME,
    Run,
    of,
)
from benchmarks.pages import markdown
from coopenv.agents.experiments.report.statistics import bootstrap_interval, interquartile_mean
from coopenv.arrays import FloatArray

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
SHARES = {"": "any", SHARED: "80/20"}
PICTURED = (SUCCESS, TIME, "relative_cost", SHARE)


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
