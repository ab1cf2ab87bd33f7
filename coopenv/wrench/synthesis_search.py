"""Wished-for wrenches: closed forms first, searches for what they leave, every answer decomposed.

1. Forces along the resultant (`synthesis_shares`), any number of effectors, nothing internal.
2. Two planar effectors on a line through the centre of mass (`synthesis_pair`).
3. Nothing internal otherwise: twists that vouch for a wrench (`synthesis_twist`), more and more.
4. Two planar effectors off that line: everywhere an optimum can be (`synthesis_planar`).
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench import (
    pair,
    synthesis_pair,
    synthesis_planar,
    synthesis_shares,
    synthesis_twist,
)
from coopenv.wrench.decomposition import Decomposer
from coopenv.wrench.synthesis_wish import Wish, share_miss

FOUND = 1e-7  # by how much an answer may miss what is wanted: shares, and parts of the wrench
ROUNDS = ((8, 0.1, 60), (64, 0.01, 100), (192, 0.001, 200))  # starts, margin, steps
AT_ONCE = 1e6  # entries of all systems of equations that are solved at the same time
MOST_TRIED = 3  # answers of a sample that are decomposed before another round


def find(wish: Wish) -> tuple[FloatArray, int | None]:
    """Applied wrenches ``(batch, n, k)`` that decompose as wanted.

    Also the number of a sample for which there is none or none was found, if any; the search
    ends there.
    """
    applied = _along_resultant(wish)
    missing = _missing(applied)
    if (missing & ~wish.searched).any():
        return applied, int((missing & ~wish.searched).argmax())
    on_axis = np.asarray(pair.applies(wish.grips))
    rows = np.flatnonzero(missing & on_axis)
    if len(rows):
        applied[rows] = _as_pair(wish.rows(rows))
    rows = np.flatnonzero(missing & ~on_axis & wish.internal.any(axis=(-1, -2)))
    if len(rows):
        applied[rows] = synthesis_planar.find(wish.rows(rows))
    rows = np.flatnonzero(missing & ~on_axis & ~wish.internal.any(axis=(-1, -2)))
    for number in range(len(ROUNDS) - 1):
        applied[rows] = _from_twists(wish.rows(rows), number)
        rows = rows[_missing(applied[rows])]
    for row in np.flatnonzero(_missing(applied)):
        if not on_axis[row]:
            applied[row] = _last_resort(wish.rows(np.array([row])))[0]
        if _missing(applied[row]):
            return applied, int(row)
    return applied, None


def _last_resort(wish: Wish) -> FloatArray:
    """What takes longer, for one sample."""
    if wish.internal.any():
        return np.full(wish.internal.shape, np.nan)
    found = np.full(wish.internal.shape, np.nan)
    if wish.grips.shape[1:] == (2, 2):
        found = synthesis_planar.find(wish)
    return _from_twists(wish, len(ROUNDS) - 1) if _missing(found)[0] else found


def _missing(applied: FloatArray) -> BoolArray:
    return np.asarray(np.isnan(applied).any(axis=(-1, -2)))


def _along_resultant(wish: Wish) -> FloatArray:
    shares = (wish.force_share, wish.torque_share)
    applied = synthesis_shares.find(wish.object_wrench, wish.grips, *shares)
    missed = share_miss(np.nan_to_num(applied), wish) > FOUND
    applied[missed | wish.internal.any(axis=(-1, -2))] = np.nan
    return applied


def _as_pair(wish: Wish) -> FloatArray:
    weights = (wish.settings.torque_weight, float(wish.settings.include_induced))
    shares = (wish.force_share[:, 0], wish.torque_share[:, 0])
    return synthesis_pair.find(wish.object_wrench, wish.grips, wish.internal, *shares, weights)


def _from_twists(wish: Wish, number: int) -> FloatArray:
    """Smallest wrench of each sample that a twist vouches for, of a round of starts."""
    answer = np.full(wish.internal.shape, np.nan)
    entries = ROUNDS[number][0] * synthesis_twist.entries(*wish.internal.shape[1:])
    at_once = max(int(AT_ONCE / entries), 1)
    for start in range(0, len(answer), at_once):
        rows = np.arange(start, min(start + at_once, len(answer)))
        part = wish.rows(rows)
        found = synthesis_twist.find(
            part.object_wrench,
            part.grips,
            part.force_share,
            part.torque_share,
            *ROUNDS[number],
            number,
        )
        answer[rows] = _smallest(found, part)
    return answer


def _smallest(found: FloatArray, wish: Wish) -> FloatArray:
    """Smallest of the wrenches ``(batch, m, n, k)`` of each sample that decompose as wanted."""
    size = np.abs(found).max(axis=(-1, -2))
    size[np.isnan(size)] = np.inf
    answer = np.full(wish.internal.shape, np.nan)
    rows = np.arange(len(found))
    for _ in range(MOST_TRIED):
        best = size[rows].argmin(axis=-1)
        exists = np.isfinite(size[rows, best])
        rows, best = rows[exists], best[exists]
        if not len(rows):
            break
        tried = found[rows, best]
        good = _miss(tried, wish.rows(rows)) <= FOUND
        answer[rows[good]] = tried[good]
        size[rows, best] = np.inf
        rows = rows[~good]
    return answer


def _miss(applied: FloatArray, wish: Wish) -> FloatArray:
    """By how much decompositions miss wishes: shares, and parts of the wrench."""
    found = Decomposer(wish.grips, wish.settings)(applied)
    size = np.maximum(np.abs(applied).max(axis=(-1, -2)), 1e-300)
    miss = np.abs(found.internal - wish.internal).max(axis=(-1, -2)) / size
    return np.maximum(miss, share_miss(applied, wish))
