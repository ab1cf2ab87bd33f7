"""Statistics of a few runs: interquartile mean, improvement, profiles, bootstrap intervals.

Scores are given by problem, one array of runs each, as a run of one problem is not one of another:
``[(..., run), (..., run), ...]``; problems may have different numbers of runs.

Source: Agarwal et al. 2021, "Deep reinforcement learning at the edge of the statistical precipice".
"""

from collections.abc import Callable, Sequence

import numpy as np

from coopenv.arrays import FloatArray, whole
from coopenv.errors import InvalidInput

Scores = Sequence[FloatArray]
"""Of one way of doing it: an array ``(..., run)`` for each problem."""

RESAMPLES = 2000
CUT = 0.25  # part of the scores that the interquartile mean leaves out at either end
CONFIDENCE = 0.95


def scores_of(values: Sequence[Sequence[float] | FloatArray]) -> list[FloatArray]:
    """Scores as arrays, checked: finite, and at least one run of each problem.

    Raises
    ------
    InvalidInput
        If there is none, or one is not finite.
    """
    arrays = [np.asarray(runs, dtype=np.float64) for runs in values]
    if not arrays or any(runs.ndim != 1 or not len(runs) for runs in arrays):
        raise InvalidInput(
            f"scores must hold at least one run of each problem, got {[*map(np.shape, arrays)]}; "
            "leave out problems without runs"
        )
    if not all(np.isfinite(runs).all() for runs in arrays):
        raise InvalidInput("scores must be finite, got nan or inf; leave those runs out")
    return arrays


def interquartile_mean(scores: Scores) -> FloatArray:
    """Mean of the middle half of all runs of all problems, ``(...)``.

    A quarter of the runs, rounded down, is left out at either end.
    """
    pooled = np.sort(np.concatenate(list(scores), axis=-1), axis=-1)
    count = pooled.shape[-1]
    cut = int(CUT * count)
    return pooled[..., cut : count - cut].mean(axis=-1)


def mean(scores: Scores) -> FloatArray:
    """Mean of all runs of all problems, ``(...)``."""
    return np.concatenate(list(scores), axis=-1).mean(axis=-1)


def optimality_gap(scores: Scores, target: float = 1.0) -> FloatArray:
    """How far the runs stay below a target, those above it counting as at it, ``(...)``."""
    pooled = np.concatenate(list(scores), axis=-1)
    return target - np.minimum(pooled, target).mean(axis=-1)


def probability_of_improvement(scores: Scores, others: Scores) -> FloatArray:
    """Chance that a run has a higher score than one of the ``others``, ``(...)``.

    Mean over problems of the Mann-Whitney U of their runs divided by the number of pairs; a tie
    counts half.

    Raises
    ------
    InvalidInput
        If there are not as many problems on both sides.
    """
    if len(scores) != len(others):
        raise InvalidInput(
            f"scores must be of the same problems as the others, got {len(scores)} and "
            f"{len(others)}; leave out what only one has"
        )
    chances = []
    for mine, theirs in zip(scores, others, strict=True):
        one, other = mine[..., :, None], theirs[..., None, :]
        more, ties = (pairs.mean(axis=(-2, -1)) for pairs in (one > other, one == other))
        chances.append(more + 0.5 * ties)
    return np.mean(chances, axis=0)


def performance_profile(scores: Scores, thresholds: FloatArray) -> FloatArray:
    """Part of the runs whose score is above each threshold, ``(..., threshold)``."""
    pooled = np.concatenate(list(scores), axis=-1)
    return (pooled[..., :, None] > np.asarray(thresholds)).mean(axis=-2)


def bootstrap_interval(
    statistic: Callable[..., FloatArray],
    *groups: Scores,
    resamples: int = RESAMPLES,
    confidence: float = CONFIDENCE,
    seed: int = 0,
) -> tuple[FloatArray, FloatArray]:
    """Percentile interval of a statistic under a stratified bootstrap.

    Runs are drawn with replacement within each problem of each group, so that every problem keeps
    its weight.

    Parameters
    ----------
    statistic
        Of the groups; takes leading dimensions.
    *groups
        Scores ``(run,)`` by problem.
    resamples
        How many.
    confidence
        Of the interval, above 0 and below 1.
    seed
        Of the drawing.

    Returns
    -------
    Low and high ends, of the shape that the statistic has.

    Raises
    ------
    InvalidInput
        If a number breaks its rule.
    """
    whole(resamples, "resamples", at_least=1)
    if not 0 < confidence < 1:
        raise InvalidInput(f"confidence must be in ]0, 1[, got {confidence!r}; 0.95 is common")
    generator = np.random.default_rng(seed)
    drawn = [[_redrawn(runs, resamples, generator) for runs in scores] for scores in groups]
    values = statistic(*drawn)
    low, high = np.quantile(values, [(1 - confidence) / 2, (1 + confidence) / 2], axis=0)
    return low, high


def pareto_front(points: FloatArray) -> list[int]:
    """Rows of ``(point, quantity)`` that no other is better than, small being good, in order.

    One is better if it is no larger in any quantity and smaller in one.
    """
    points = np.asarray(points, dtype=np.float64)
    return [
        number
        for number, point in enumerate(points)
        if not ((points <= point).all(axis=1) & (points < point).any(axis=1)).any()
    ]


def _redrawn(runs: FloatArray, resamples: int, generator: np.random.Generator) -> FloatArray:
    return runs[generator.integers(len(runs), size=(resamples, len(runs)))]
