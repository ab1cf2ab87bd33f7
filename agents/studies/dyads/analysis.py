"""The analysis of the human study (section VI) on any table of trials of pairs.

Two questions: how much do the partners' torques cancel at the start of a trial, by method and
guide; and how do they share force and torque while the beam turns, by guide.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput
from coopenv.wrench import load_share

from ..methods import decompose_by_methods
from ..tables import Table
from .anova import Effect, complete_subjects, repeated_measures
from .config import WINDOW
from .density import LoadDensity, Quadrants
from .trials import applied_wrenches, checked_trials, durations, elapsed, grip_positions, turned

METHODS = (
    "prioritized_torque",
    "point_mass",
    "moore_penrose",
    "nonsqueezing",
    "virtual_linkage",
)
"""The five of the paper; ours is pTtTC there."""

GUIDES = ("one", "both", "none")
QUADRANTS = ("dominant", "passive", "force_specialist", "torque_specialist")
TURN = np.pi / 4  # [rad] up to which rotations count


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DyadAnalysis:
    """What the trials show; tables have one row a pair and condition (and method)."""

    source: str  # of the trials, as the figures call it
    internal_torque: Table  # pair, condition, method, num_trials, internal_torque [N·m]
    torque_effects: tuple[Effect, ...]  # of method, condition and both; empty: see notes
    quadrants: Table  # pair, condition and the four shares of time
    dominance_effects: tuple[Effect, ...]  # of condition; empty: see notes
    densities: dict[str, LoadDensity]  # by condition
    conditions: tuple[str, ...]  # in the order of tables and figures
    num_pairs: int
    num_trials: int
    notes: tuple[str, ...]  # what was left out, and why

    def document(self) -> dict[str, Any]:
        """Numbers of tables and effects, for programs."""
        return {
            "source": self.source,
            "num_pairs": self.num_pairs,
            "num_trials": self.num_trials,
            "internal_torque": self.internal_torque.to_dict("records"),
            "quadrants": self.quadrants.to_dict("records"),
            "torque_effects": self.torque_effects,
            "dominance_effects": self.dominance_effects,
            "notes": self.notes,
        }


def analyse(
    trials: Table,
    *,
    window: float = WINDOW,
    turn: float = TURN,
    methods: Sequence[str] = METHODS,
    source: str = "recorded trials",
) -> DyadAnalysis:
    """Internal torque by method and guide, load shares by guide, each with its ANOVA.

    Parameters
    ----------
    trials
        Columns as in `coopenv.agents.studies.dyads.trials`; with ``first``.
    window
        Of the internal torque, from the start of a trial [s].
    turn
        Load shares count until the beam has turned by this [rad].
    methods
        Names of decompositions.
    source
        What the figures call these trials: recorded, or plainly simulated.

    Returns
    -------
    A `DyadAnalysis`; an ANOVA that cannot be done is left out and ``notes`` say why.

    Raises
    ------
    InvalidInput
        If the table is not in order, or lacks ``first``.
    """
    trials = checked_trials(trials).assign(condition=lambda table: table["condition"].astype(str))
    notes: list[str] = []
    torque = internal_torques(trials, window=window, methods=methods)
    quadrants = quadrant_shares(trials, turn=turn)
    present = trials["condition"].unique().tolist()
    known = [name for name in GUIDES if name in present]
    conditions = (*known, *(name for name in present if name not in GUIDES))
    return DyadAnalysis(
        source=source,
        internal_torque=torque,
        torque_effects=_effects(
            torque, ("method", "condition"), "internal_torque", notes, len(conditions)
        ),
        quadrants=quadrants,
        dominance_effects=_effects(quadrants, ("condition",), "dominant", notes, len(conditions)),
        densities=load_densities(trials, turn=turn, notes=notes.append),
        conditions=conditions,
        num_pairs=trials["pair"].nunique(),
        num_trials=len(trials[["pair", "condition", "trial"]].drop_duplicates()),
        notes=tuple(notes),
    )


def internal_torques(
    trials: Table, *, window: float = WINDOW, methods: Sequence[str] = METHODS
) -> Table:
    """Mean T_I over the start of the trials in which agent 1 enters the final platform first.

    The mean is over time, then over the trials of a pair and condition.

    Returns
    -------
    Columns pair, condition, method, num_trials, internal_torque [N·m].

    Raises
    ------
    InvalidInput
        If ``first`` is missing, or agent 1 is never first.
    """
    if "first" not in trials.columns:
        raise InvalidInput(
            "trials must have the column first, the agent that enters the final platform first, "
            "got none; add it, or give the platform (trials.first_to_enter)"
        )
    chosen = (trials["first"].to_numpy() == 1) & (elapsed(trials) < window - 1e-9)
    if not chosen.any():
        raise InvalidInput(
            "first must be 1 in some trials, got none; T_I is compared where agent 1 enters the "
            "final platform first"
        )
    start = trials[chosen]
    keys = start[["pair", "condition", "trial"]].assign(weight=durations(trials)[chosen])
    split = decompose_by_methods(applied_wrenches(start), grip_positions(start), methods)
    parts: list[Table] = []
    for name, decomposition in split.items():
        table = keys.assign(product=decomposition.internal_torque_level * keys["weight"])
        sums = table.groupby(["pair", "condition", "trial"], observed=True)[["product", "weight"]]
        each = sums.sum().eval("product / weight").rename("internal_torque")
        by_pair = each.groupby(["pair", "condition"], observed=True).agg(["size", "mean"])
        by_pair = by_pair.rename(columns={"size": "num_trials", "mean": "internal_torque"})
        parts.append(by_pair.reset_index().assign(method=name))
    columns = ["pair", "condition", "method", "num_trials", "internal_torque"]
    return pd.concat(parts, ignore_index=True)[columns]


def quadrant_shares(trials: Table, *, turn: float = TURN) -> Table:
    """Shares of time in the quadrants of (α_f,1, α_t,1), by pair and condition.

    Returns
    -------
    Columns pair, condition, dominant, passive, force_specialist, torque_specialist; pairs without
    a sample in which both shares are defined have no row.
    """
    table = _load_shares(trials, turn)
    rows = []
    for (pair, condition), part in table.groupby(["pair", "condition"], observed=True):
        found = Quadrants.of(*part[["force", "torque", "weight"]].to_numpy(np.float64).T)
        shares = {name: getattr(found, name) for name in QUADRANTS}
        rows.append({"pair": pair, "condition": condition, **shares})
    return pd.DataFrame(rows, columns=["pair", "condition", *QUADRANTS])


def load_densities(
    trials: Table, *, turn: float = TURN, notes: Callable[[str], None] | None = None
) -> dict[str, LoadDensity]:
    """Density of (α_f,1, α_t,1) by condition, over the trials of all pairs.

    A condition whose shares do not vary has none; ``notes`` is told.
    """
    densities = {}
    for condition, part in _load_shares(trials, turn).groupby("condition", observed=True):
        columns = part[["force", "torque", "weight"]].to_numpy(np.float64).T
        try:
            densities[str(condition)] = LoadDensity.of(*columns)
        except InvalidInput as error:
            if notes is None:
                raise
            notes(f"no density for guide {condition!r}: {error}")
    return densities


def _load_shares(trials: Table, turn: float) -> Table:
    """pair, condition, force, torque, weight of the samples in which both shares are defined."""
    chosen = turned(trials) <= turn
    part = trials[chosen]
    share = load_share(applied_wrenches(part), grip_positions(part))
    table = part[["pair", "condition"]].assign(
        force=share.force[:, 0], torque=share.torque[:, 0], weight=durations(trials)[chosen]
    )
    return table.dropna(subset=["force", "torque"])


def _effects(
    table: Table, factors: tuple[str, ...], value: str, notes: list[str], conditions: int
) -> tuple[Effect, ...]:
    """The ANOVA over complete pairs, or none and a note."""
    what = f"ANOVA of {value} by {' and '.join(factors)}"
    whole = complete_subjects(table, subject="pair", factors=factors)
    left_out = [pair for pair in table["pair"].unique().tolist() if pair not in whole]
    if left_out:
        notes.append(f"{what}: without pairs {left_out}, which lack trials in some condition")
    if table["condition"].nunique() < conditions:
        notes.append(f"{what}: some condition has no trial that counts")
    kept: FloatArray = table["pair"].isin(whole).to_numpy()
    try:
        return repeated_measures(table[kept], subject="pair", factors=factors, value=value)
    except InvalidInput as error:
        notes.append(f"no {what}: {error}")
        return ()
