"""Wishes of two planar effectors whose costs tie: what `decompose` splits as wanted.

Where both effectors supply a part of the torque that is left, and both keep a part internal, any
split costs the same, and the solver's depends on what was applied. So there is one number more to
find: what effector 1 is to apply for the wanted part to remain. It is bracketed on a grid of
decompositions, the grid made ever finer: at fixed forces, where the torque share leaves the split
open; along the curves of `synthesis_curves`, where it says what the split must be.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.wrench import synthesis_curves, synthesis_planar
from coopenv.wrench.decomposition import Decomposer
from coopenv.wrench.settings import Settings

GRID, NUM_GRIDS = 24, 6
CLOSE = 1e-4  # by how much internal forces may miss what is wanted, relative to the wrench


class OneWish(NamedTuple):
    """What is wanted of two planar effectors; shares of effector 1, NaN where open."""

    object_wrench: FloatArray  # (3,) [N, N·m]
    grips: FloatArray  # (2, 2) [m]
    internal: FloatArray  # (2, 3) [N, N·m]
    force_share: float
    torque_share: float
    settings: Settings

    @property
    def _turn(self) -> FloatArray:
        along = self.grips[0] - self.grips[1]
        x, y = along / np.hypot(*along)
        return np.array([[x, y], [-y, x]])

    @property
    def _units(self) -> FloatArray:
        """Of forces and torques (3,), such that nothing wanted is larger than 1."""
        units = np.array([1.0, 1.0, np.hypot(*self.grips.T).max()])
        largest = max(np.abs(self.internal / units).max(), np.abs(self.object_wrench / units).max())
        return units * largest

    @property
    def in_frame(self) -> synthesis_planar.Wish:
        """The wish in its own units, the x axis along the line through the grips."""
        units, w = self._units, self.settings.torque_weight
        length = units[2] / units[0]
        wanted, internal = self.object_wrench / units, self.internal / units
        induced = w * length * self.settings.include_induced
        return synthesis_planar.Wish(
            self._turn @ wanted[:2],
            wanted[2],
            self._turn @ internal[0, :2],
            internal[:, 2],
            self.force_share,
            self.torque_share,
            self.grips @ self._turn.T / length,
            (1.0 - w, w * length, induced),
        )

    def applied(self, manipulation: FloatArray) -> FloatArray:
        """What to apply ``(..., 2, 3)`` for a manipulation wrench in the frame."""
        result = manipulation * self._units
        result[..., :2] = result[..., :2] @ self._turn
        return result + self.internal

    def remains(self, applied: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Whether effector 1 keeps less torque than wanted, and both the force that is wanted."""
        internal = Decomposer(self.grips, self.settings)(applied).internal
        size = np.abs(applied).max(axis=(-1, -2))
        off = np.abs(internal[..., :2] - self.internal[..., :2]).max(axis=(-1, -2))
        return internal[..., 0, 2] < self.internal[0, 2], np.asarray(off <= CLOSE * size)


def find(wish: OneWish, tried: FloatArray) -> FloatArray:
    """Wrenches ``(m, 2, 3)`` whose torques come back split as wanted, as far as costs tie.

    Parameters
    ----------
    wish
        What is wanted.
    tried
        Candidates ``(k, 2, 3)``, of which the forces are used [N, N·m].
    """
    own, other = wish.internal[:, 2]
    if own * other <= 0.0:
        return tried[:0]
    found = [_at_fixed_forces(wish, tried)]
    if np.isfinite(wish.torque_share) and not 0.0 < wish.force_share < 1.0:
        with np.errstate(all="ignore"):  # a curve that does not exist is NaN or infinite
            found.append(_along_curves(wish))
    return np.concatenate(found)


def _at_fixed_forces(wish: OneWish, tried: FloatArray) -> FloatArray:
    own, other = wish.internal[:, 2]
    left = tried[..., 2].sum(axis=-1) - own - other
    tried = tried[left * own > 0.0]
    if not len(tried):
        return tried
    size = np.maximum(np.abs(tried).max(axis=(-1, -2)), 1e-300)
    _, first = np.unique(np.round(tried[:, 0, :2] / size[:, None], 9), axis=0, return_index=True)
    tried = tried[first]
    tried = tried[wish.remains(tried)[1]]
    left = tried[..., 2].sum(axis=-1) - own - other

    def split(row: IntArray, part: FloatArray) -> FloatArray:
        applied = tried[row]
        applied[..., 0, 2] = own + part * left[row]
        applied[..., 1, 2] = other + (1.0 - part) * left[row]
        return applied

    row = np.repeat(np.arange(len(tried))[:, None], GRID, axis=1)
    part = np.broadcast_to(np.linspace(0.0, 1.0, GRID), row.shape)
    return _refined(wish, split, row, part)


def _along_curves(wish: OneWish) -> FloatArray:
    in_frame = wish.in_frame

    def shared(curve: IntArray, angle: FloatArray) -> FloatArray:
        return wish.applied(synthesis_curves.with_torque_share(in_frame, angle, curve))

    return _refined(wish, shared, *synthesis_curves.everywhere(in_frame))


def _refined(
    wish: OneWish,
    wrench: Callable[[IntArray, FloatArray], FloatArray],
    curve: IntArray,
    place: FloatArray,
) -> FloatArray:
    """Wrenches where what remains crosses what is wanted, from grids ``(m, GRID)`` of places."""
    for number in range(NUM_GRIDS):
        applied = wrench(curve, place)
        usable = np.asarray(np.isfinite(applied).all(axis=(-1, -2)))
        too_little, close = np.zeros_like(usable), np.zeros_like(usable)
        if usable.any():
            too_little[usable], close[usable] = wish.remains(applied[usable])
        crosses = (too_little[:, 1:] != too_little[:, :-1]) & close[:, 1:] & close[:, :-1]
        row, first = np.nonzero(crosses)
        if number:  # what changes more than once now does so by rounding
            row, once = np.unique(row, return_index=True)
            first = first[once]
        low, high = place[row, first], place[row, first + 1]
        place = low[:, None] + np.linspace(0.0, 1.0, GRID) * (high - low)[:, None]
        curve = np.repeat(curve[row, :1], GRID, axis=1)
    return wrench(curve[:, 0], 0.5 * (place[:, 0] + place[:, -1]))
