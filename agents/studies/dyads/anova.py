"""Repeated-measures analysis of variance with one or two factors within subjects."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy.linalg import helmert
from scipy.stats import f as f_distribution
from statsmodels.stats.anova import AnovaRM

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput

from ..tables import Table

ROUNDING = 1e-12  # relative spread between subjects that counts as none


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """One row of the analysis: a factor, or the interaction of two."""

    factors: tuple[str, ...]
    f: float
    df_effect: int
    df_error: int
    p: float  # if sphericity holds
    epsilon: float  # Greenhouse & Geisser's estimate, in [1/df_effect, 1]; 1: spherical
    p_corrected: float  # with both degrees of freedom times epsilon
    partial_eta_squared: float  # SS_effect / (SS_effect + SS_error)

    @property
    def name(self) -> str:
        """``method``, or ``method × guide``."""
        return " × ".join(self.factors)

    def row(self) -> dict[str, str]:
        """The columns of a table, as text."""
        return {
            "effect": self.name,
            "F": f"F({self.df_effect}, {self.df_error}) = {self.f:.2f}",
            "p": f"{self.p:.3g}",
            "ε (Greenhouse-Geisser)": f"{self.epsilon:.3f}",
            "p corrected": f"{self.p_corrected:.3g}",
            "partial η²": f"{self.partial_eta_squared:.3f}",
        }


def repeated_measures(
    table: Table, *, subject: str, factors: Sequence[str], value: str
) -> tuple[Effect, ...]:
    """Repeated-measures ANOVA of a long table, one row a measurement.

    Several measurements of a subject in one cell are averaged first. The F tests are those of
    statsmodels' `AnovaRM`; sphericity is not tested but estimated: where ``epsilon`` is well below
    1, read ``p_corrected``.

    Parameters
    ----------
    table
        With the columns named below; further ones are ignored.
    subject
        Who was measured, in every cell.
    factors
        One or two columns; each with at least two levels.
    value
        The measurement, finite.

    Returns
    -------
    One `Effect` a factor in the order given, then the interaction of two. Where it is the same in
    every subject there is no error to test it against: its F, p and epsilon are NaN.

    Raises
    ------
    InvalidInput
        If a column is missing, a value is not finite, a factor has one level, there are fewer than
        two subjects, or a subject lacks a cell (named).

    Source: Greenhouse & Geisser 1959, Psychometrika 24, for epsilon.
    """
    cells, levels = _cells(table, subject, tuple(factors), value)
    values = cells.to_numpy(dtype=np.float64).reshape(len(cells), *levels)
    found = _f_tests(values)
    effects = []
    for order in range(1, len(levels) + 1):
        for which in combinations(range(len(levels)), order):
            names = tuple(factors[i] for i in which)
            epsilon = _epsilon(values, which)
            f, df_effect, df_error, p = found[which]
            if np.isnan(epsilon):
                f = p = np.nan
            corrected = f_distribution.sf(f, epsilon * df_effect, epsilon * df_error)
            effects.append(
                Effect(
                    factors=names,
                    f=f,
                    df_effect=df_effect,
                    df_error=df_error,
                    p=p,
                    epsilon=epsilon,
                    p_corrected=float(corrected),
                    partial_eta_squared=f * df_effect / (f * df_effect + df_error),
                )
            )
    return tuple(effects)


def complete_subjects(table: Table, *, subject: str, factors: Sequence[str]) -> list[Any]:
    """Subjects with a row in every cell that occurs in the table; the others cannot be analysed."""
    if table.empty:
        return []
    counts = table.groupby([subject, *factors]).size().unstack(list(factors))
    levels = int(np.prod([table[name].nunique() for name in factors]))
    complete = counts.notna().sum(axis=1) == levels
    return complete.index[complete].tolist()


def _cells(
    table: Table, subject: str, factors: tuple[str, ...], value: str
) -> tuple[Table, list[int]]:
    """One row a subject, one column a cell; and the number of levels of each factor."""
    if len(factors) not in (1, 2) or len({subject, value, *factors}) != len(factors) + 2:
        raise InvalidInput(
            f"factors must be one or two columns beside subject and value, got {factors!r}; "
            "analyse more factors in parts"
        )
    for name in (subject, *factors, value):
        if name not in table.columns:
            raise InvalidInput(
                f"table must have the column {name!r}, got {list(table.columns)}; rename it"
            )
    broken = ~np.isfinite(table[value].to_numpy(dtype=np.float64))
    if broken.any():
        raise InvalidInput(
            f"{value} must be finite, got {table[value].iloc[int(broken.argmax())]} in row "
            f"{table.index[int(broken.argmax())]}; leave such trials out first"
        )
    levels = [table[name].nunique() for name in factors]
    if min(levels, default=0) < 2 or table[subject].nunique() < 2:
        raise InvalidInput(
            f"factors {factors!r} must have at least 2 levels each and {subject!r} at least 2 "
            f"subjects, got {levels} levels and {table[subject].nunique()} subjects; nothing can "
            "be compared"
        )
    cells = table.groupby([subject, *factors], observed=True)[value].mean().unstack(list(factors))
    every: Any = pd.MultiIndex.from_product([sorted(table[name].unique()) for name in factors])
    cells = cells.reindex(columns=every if len(factors) == 2 else every.get_level_values(0))
    missing = cells.isna().any(axis=1)
    if missing.any():
        raise InvalidInput(
            f"table must hold every cell of {factors!r} for every {subject!r}, got none of some "
            f"for {cells.index[missing].tolist()}; leave these subjects out (complete_subjects)"
        )
    return cells, levels


def _f_tests(values: FloatArray) -> dict[tuple[int, ...], tuple[float, int, int, float]]:
    """(F, df of effect, df of error, p) by the axes of an effect; ``values`` (subject, ...)."""
    # Our own column names: AnovaRM takes a factor for an interaction with the subject where the
    # subject's name is part of the factor's, and fails on a factor called C.
    names = [f"factor{i}" for i in range(values.ndim - 1)]
    index = np.indices(values.shape).reshape(values.ndim, -1)
    long = pd.DataFrame(dict(zip(["unit", *names], index, strict=True)))
    long["value"] = values.ravel()
    with np.errstate(divide="ignore", invalid="ignore"):
        found = AnovaRM(long, "value", "unit", within=names).fit().anova_table
    tests = {}
    for term, row in found.iterrows():
        which = tuple(names.index(name) for name in str(term).split(":"))
        f, df_effect, df_error, p = row[["F Value", "Num DF", "Den DF", "Pr > F"]]
        tests[which] = float(f), round(df_effect), round(df_error), float(p)
    return tests


def _epsilon(values: FloatArray, which: tuple[int, ...]) -> float:
    """ε = tr(M)² / (d tr(M²)), M the covariance of d orthonormal contrasts of the effect.

    NaN where the subjects do not differ beyond rounding.
    """
    others = tuple(1 + i for i in range(values.ndim - 1) if i not in which)
    means = values.mean(axis=others) if others else values
    contrasts = reduce(np.kron, [helmert(size) for size in means.shape[1:]])
    scores = means.reshape(len(means), -1) @ contrasts.T
    covariance = np.atleast_2d(np.cov(scores, rowvar=False))
    if np.trace(covariance) <= (ROUNDING * np.abs(values).max()) ** 2:
        return np.nan
    return float(np.trace(covariance) ** 2 / (len(contrasts) * np.sum(covariance**2)))
