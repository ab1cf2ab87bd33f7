"""Measures of a scenario: their titles and units, and estimates of them with 95 % intervals."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from coopenv.arrays import FloatArray

from ..episodes import Episodes
from ..evaluation import success_of
from ..experiments.report.statistics import bootstrap_interval, mean

DIGITS = 6  # that are kept
SUCCESS, HALVED, DOUBLED = "success_rate", "success_at_half", "success_at_double"
MEASURES: Mapping[str, tuple[str, str]] = {  # name -> title and unit
    SUCCESS: ("success", "%"),
    HALVED: ("at half the tolerances", "%"),
    DOUBLED: ("at double the tolerances", "%"),
    "success_time": ("time", "s"),
    "effort": ("effort", "N"),
    "partner_effort": ("partner's effort", "N"),
    "relative_cost": ("γ", ""),
    "internal_force_level": ("F_I", "N"),
    "internal_torque_level": ("T_I", "N·m"),
    "wasted_cost": ("wasted cost", "N"),
    "internal_power": ("internal power", "W"),
    "load_share": ("load share", ""),
    "load_imbalance": ("imbalance", ""),
    "disagreement": ("disagreement", "m"),
}

_SMALL = ("relative_cost", "load_share", "load_imbalance", "internal_power")  # three digits


class Estimate(NamedTuple):
    """A measure and its 95 % interval, and the episodes in which it is defined."""

    value: float
    low: float
    high: float
    episodes: int


def rates(seen: Episodes) -> Estimate:
    """Success rate with Wilson's interval."""
    value, (low, high) = success_of(seen)
    return _rounded(value, low, high, len(seen.length))


def means(
    seen: Episodes, others: Mapping[str, FloatArray], *, dt: float, learner: int
) -> dict[str, Estimate | None]:
    """Means over episodes of all other measures; ``None`` where no episode has one.

    Parameters
    ----------
    seen
        The episodes.
    others
        Further measures by name, ``(episode,)``.
    dt
        Control step [s].
    learner
        Agent of whose share of the load is told.
    """
    own: dict[str, Any] = {name: getattr(seen, name, None) for name in MEASURES}
    values: dict[str, FloatArray] = {
        **{name: array for name, array in own.items() if array is not None},
        "success_time": np.where(seen.success, dt * seen.length, np.nan),
        "load_share": seen.force_load_share[:, learner],
        **others,
    }
    return {
        name: estimate(values[name]) if name in values else None
        for name in MEASURES
        if not name.startswith("success_") or name == "success_time"
    }


def estimate(values: FloatArray) -> Estimate | None:
    """Mean of the values that are defined, with a bootstrap interval over the episodes."""
    defined = values[~np.isnan(values)]
    if not len(defined):
        return None
    low, high = bootstrap_interval(mean, [defined])
    return _rounded(float(defined.mean()), float(low), float(high), len(defined))


def shown(name: str, found: Estimate | None) -> str:
    """An estimate for people, with its interval; per cent where the unit is."""
    if found is None:
        return "–"
    many = 100 if MEASURES[name][1] == "%" else 1
    digits = 1 if many == 100 else 3 if name in _SMALL else 2
    return f"{many * found.value:.{digits}f} [{many * found.low:.{digits}f}, " + (
        f"{many * found.high:.{digits}f}]"
    )


def _rounded(value: float, low: float, high: float, episodes: int) -> Estimate:
    value, low, high = (float(f"{each:.{DIGITS}g}") for each in (value, low, high))
    return Estimate(value, low, high, episodes)
