"""Wished-for wrenches: closed forms first, searches for what they leave, every answer decomposed.

1. Forces along the resultant (`synthesis_shares`), any number of effectors, nothing internal.
2. Two planar effectors on a line through the centre of mass (`synthesis_pair`).
3. Nothing internal otherwise: twists that vouch for a wrench (`synthesis_twist`), more and more.
4. Internal wrench of two planar effectors anywhere: curves on which an optimum can lie
   (`synthesis_curves`), and where costs tie, what the solver makes of it (`synthesis_ties`).
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.wrench import (
    pair,
    synthesis_curves,
    synthesis_pair,
    synthesis_shares,
    synthesis_ties,
    synthesis_twist,
)
from coopenv.wrench.decomposition import Decomposer, Decomposition
from coopenv.wrench.measure_kernels import load_share_kernel
from coopenv.wrench.settings import Settings

FOUND = 1e-7  # by how much an answer may miss what is wanted: shares, and parts of the wrench
ROUGH = 1e-4  # the same where no closer one is found and what is wanted is as cheap
AS_CHEAP = 1e-7  # part of the cost that counts as nothing
ROUNDS = ((8, 30), (24, 40), (32, 60), (32, 60), (32, 60))  # starts, steps
AT_ONCE = 2e5  # entries of all systems of equations that are solved at the same time
MOST_TRIED = 8  # answers of a sample that are decomposed before another round
TRIED = 64  # candidates decomposed at the same time


class Wish(NamedTuple):
    """What is wanted, one sample a row; shares are NaN where open."""

    object_wrench: FloatArray  # (batch, k) [N, N·m]
    grips: FloatArray  # (batch, n, d) [m]
    internal: FloatArray  # (batch, n, k) [N, N·m]
    force_share: FloatArray  # (batch, n)
    torque_share: FloatArray  # (batch, n)
    settings: Settings

    def rows(self, which: BoolArray | IntArray) -> "Wish":
        """Wishes of some samples."""
        return Wish(*(part[which] for part in self[:-1]), self.settings)  # pyright: ignore

    @property
    def searched(self) -> BoolArray:
        """For which samples ``(batch,)`` there is a search: internal wrench only for pairs."""
        if self.grips.shape[1:] == (2, 2):
            return np.ones(len(self.grips), dtype=np.bool_)
        return np.asarray(~self.internal.any(axis=(-1, -2)))


def find(wish: Wish) -> tuple[FloatArray, int | None]:
    """Applied wrenches ``(batch, n, k)`` that decompose as wanted.

    Also the number of a sample for which there is none or none was found, if any; the search
    ends there.
    """
    applied = _along_resultant(wish)
    on_axis = np.asarray(pair.applies(wish.grips))
    rows = np.flatnonzero(_missing(applied) & on_axis)
    if len(rows):
        applied[rows] = _as_pair(wish.rows(rows))
    impossible = _missing(applied) & (on_axis | ~wish.searched)
    if impossible.any():
        return applied, int(impossible.argmax())
    rows = np.flatnonzero(_missing(applied))
    entries = ROUNDS[0][0] * synthesis_twist.entries(*wish.internal.shape[1:])
    at_once = max(int(AT_ONCE / entries), 1)
    for start in range(0, len(rows), at_once):
        failed = _searched(wish, applied, rows[start : start + at_once])
        if failed is not None:
            return applied, failed
    return applied, None


def _searched(wish: Wish, applied: FloatArray, rows: IntArray) -> int | None:
    """Search some samples, write what is found to ``applied``; return the first that has none."""
    free = rows[~wish.internal[rows].any(axis=(-1, -2))]
    applied[free] = _from_twists(wish.rows(free), 0)
    for row in rows[_missing(applied[rows])]:
        applied[row] = _last_resort(wish.rows(np.array([row])))[0]
        if _missing(applied[row]):
            return int(row)
    return None


def _last_resort(wish: Wish) -> FloatArray:
    """What takes longer, for one sample."""
    if wish.internal.any():
        return _on_curves(wish)
    for number in range(1, len(ROUNDS)):
        found = _from_twists(wish, number)
        if not _missing(found)[0]:
            return found
    return np.full(wish.internal.shape, np.nan)


def _missing(applied: FloatArray) -> BoolArray:
    return np.asarray(np.isnan(applied).any(axis=(-1, -2)))


def _along_resultant(wish: Wish) -> FloatArray:
    shares = (wish.force_share, wish.torque_share)
    applied = synthesis_shares.find(wish.object_wrench, wish.grips, *shares)
    missed = _share_miss(np.nan_to_num(applied), wish) > FOUND
    applied[missed | wish.internal.any(axis=(-1, -2))] = np.nan
    return applied


def _as_pair(wish: Wish) -> FloatArray:
    weights = (wish.settings.torque_weight, float(wish.settings.include_induced))
    shares = (wish.force_share[:, 0], wish.torque_share[:, 0])
    return synthesis_pair.find(wish.object_wrench, wish.grips, wish.internal, *shares, weights)


def _from_twists(wish: Wish, number: int) -> FloatArray:
    """Smallest wrench of each sample that a twist vouches for, of a round of starts."""
    found = synthesis_twist.find(
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
        good = _miss(tried, wish.rows(rows))[0] <= FOUND
        answer[rows[good]] = tried[good]
        size[rows, best] = np.inf
        rows = rows[~good]
    return answer


def _on_curves(wish: Wish) -> FloatArray:
    """Smallest wrench ``(1, 2, 3)`` among the candidates for two planar effectors, of one wish."""
    answer = np.full(wish.internal.shape, np.nan)
    if wish.grips.shape[1:] != (2, 2):
        return answer
    one = synthesis_ties.OneWish(
        wish.object_wrench[0],
        wish.grips[0],
        wish.internal[0],
        wish.force_share[0, 0],
        wish.torque_share[0, 0],
        wish.settings,
    )
    tried = one.applied(synthesis_curves.candidates(one.in_frame))
    tried = tried[np.abs(tried).max(axis=(-1, -2)).argsort()]
    least = ROUGH
    for start in range(0, len(tried), TRIED):
        chunk = tried[start : start + TRIED]
        miss, as_cheap = _miss(chunk, wish.rows(np.zeros(len(chunk), dtype=np.int64)))
        good = np.flatnonzero(miss <= FOUND)
        if len(good):
            return chunk[good[:1]]
        rough = np.where(as_cheap, miss, np.inf)
        if rough.min() < least:
            least, answer = rough.min(), chunk[rough.argmin()][None]
    tied = synthesis_ties.find(one, tried)
    if len(tied):
        miss, as_cheap = _miss(tied, wish.rows(np.zeros(len(tied), dtype=np.int64)))
        miss[~as_cheap] = np.inf
        if miss.min() < least:
            return tied[miss.argmin()][None]
    return answer


def _miss(applied: FloatArray, wish: Wish) -> tuple[FloatArray, BoolArray]:
    """By how much decompositions miss wishes, and whether what is wanted is as cheap."""
    decomposer = Decomposer(wish.grips, wish.settings)
    found = decomposer(applied)
    wanted = Decomposition(applied, applied - wish.internal, None, decomposer)
    size = np.maximum(np.abs(applied).max(axis=(-1, -2)), 1e-300)
    miss = np.abs(found.internal - wish.internal).max(axis=(-1, -2)) / size
    as_cheap = wanted.cost <= found.cost + AS_CHEAP * found.applied_cost
    return np.maximum(miss, _share_miss(applied, wish)), np.asarray(as_cheap)


def _share_miss(applied: FloatArray, wish: Wish) -> FloatArray:
    miss = np.zeros(len(applied))
    shares = load_share_kernel(applied, wish.grips)
    for reached, wanted in zip(shares, (wish.force_share, wish.torque_share), strict=True):
        off = np.where(np.isnan(wanted), 0.0, np.abs(reached - wanted))
        miss = np.maximum(miss, np.where(np.isnan(off), np.inf, off).max(axis=-1))
    return miss
