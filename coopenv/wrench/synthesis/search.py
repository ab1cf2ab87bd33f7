"""Search for wrenches that fulfil a wish: closed forms first, every answer decomposed.

1. Forces along the resultant (`shares`), any number of effectors, nothing internal.
2. Two planar effectors on a line through the centre of mass (`pair`).
3. Nothing internal otherwise: twists that vouch for a wrench (`twist`), more and more of them.
4. Internal wrench of two planar effectors off that line: all that can be (`planar`).
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.wrench.decomposition import Decomposer
from coopenv.wrench.pair import on_axis
from coopenv.wrench.synthesis import pair, planar, shares, twist
from coopenv.wrench.synthesis.wish import Wish, internal_miss, share_miss

FOUND = 1e-7  # by how much an answer may miss what is wanted: shares, and parts of the wrench
ROUNDS = ((8, 30), (24, 40), (32, 60), (32, 60), (32, 60))  # starts, steps
AT_ONCE = 2e5  # entries of all systems of equations that are solved at the same time
MOST_TRIED = 8  # answers of a sample that are decomposed before another round


def find(wish: Wish) -> tuple[FloatArray, int | None]:
    """Applied wrenches ``(batch, n, k)`` that decompose as wanted.

    The search ends at the first sample that is impossible or was searched in vain. The number of
    that sample is returned beside the wrenches; None where all were found.
    """
    applied = _along_resultant(wish)
    on_line = on_axis.applies(wish.grips)
    rows = np.flatnonzero(_missing(applied) & on_line)
    if len(rows):
        applied[rows] = pair.find(wish.rows(rows))
    internal = wish.internal.any(axis=(-1, -2))
    rows = np.flatnonzero(_missing(applied) & ~on_line & internal & wish.searched)
    if len(rows):
        applied[rows] = planar.find(wish.rows(rows))
    impossible = _missing(applied) & (on_line | internal)
    if impossible.any():
        return applied, int(impossible.argmax())
    rows = np.flatnonzero(_missing(applied))
    entries = ROUNDS[0][0] * twist.entries(*wish.internal.shape[1:])
    at_once = max(int(AT_ONCE / entries), 1)
    for start in range(0, len(rows), at_once):
        failed = _searched(wish, applied, rows[start : start + at_once])
        if failed is not None:
            return applied, failed
    return applied, None


def _searched(wish: Wish, applied: FloatArray, rows: IntArray) -> int | None:
    """Search some samples, write what is found to ``applied``; return the first that has none."""
    applied[rows] = _from_twists(wish.rows(rows), 0)
    for row in rows[_missing(applied[rows])]:
        applied[row] = _last_resort(wish.rows(np.array([row])))[0]
        if _missing(applied[row]):
            return int(row)
    return None


def _last_resort(wish: Wish) -> FloatArray:
    """What takes longer, for one sample."""
    for number in range(1, len(ROUNDS)):
        found = _from_twists(wish, number)
        if not _missing(found)[0]:
            return found
    return np.full(wish.internal.shape, np.nan)


def _missing(applied: FloatArray) -> BoolArray:
    return np.asarray(np.isnan(applied).any(axis=(-1, -2)))


def _along_resultant(wish: Wish) -> FloatArray:
    applied = shares.find(wish.object_wrench, wish.grips, wish.force_share, wish.torque_share)
    missed = share_miss(np.nan_to_num(applied), wish) > FOUND
    applied[missed | wish.internal.any(axis=(-1, -2))] = np.nan
    return applied


def _from_twists(wish: Wish, number: int) -> FloatArray:
    """Smallest wrench of each sample that a twist vouches for, of a round of starts."""
    found = twist.find(
        wish.object_wrench,
        wish.grips,
        wish.force_share,
        wish.torque_share,
        *ROUNDS[number],
        seed=number,
    )
    return _smallest(found, wish)


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
    length = np.linalg.norm(wish.grips, axis=-1).max(axis=-1)
    miss = internal_miss(found.internal, wish.internal, applied, length)
    return np.maximum(miss, share_miss(applied, wish))
