"""Wishes, in batches: a resultant, load shares and an internal wrench that are asked for."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.wrench.pair.lens import COS, SIN
from coopenv.wrench.settings import Settings
from coopenv.wrench.shares import load_share_kernel


class Wish(NamedTuple):
    """Wishes as they are asked for, one sample a row; shares are NaN where open."""

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


def share_miss(applied: FloatArray, wish: Wish) -> FloatArray:
    """By how much wrenches ``(batch, n, k)`` miss the wanted shares; infinite where undefined."""
    miss = np.zeros(len(applied))
    shares = load_share_kernel(applied, wish.grips)
    for reached, wanted in zip(shares, (wish.force_share, wish.torque_share), strict=True):
        off = np.where(np.isnan(wanted), 0.0, np.abs(reached - wanted))
        miss = np.maximum(miss, np.where(np.isnan(off), np.inf, off).max(axis=-1))
    return miss


def internal_miss(
    found: FloatArray, wanted: FloatArray, applied: FloatArray, length: FloatArray
) -> FloatArray:
    """By how much internal wrenches ``(batch, n, k)`` miss, in parts of what is applied.

    A torque counts as the force that makes it at the longest lever, ``length`` ``(batch,)``.
    """
    dimension = applied.shape[-1] // 3 + 1
    units = np.ones((len(applied), 1, applied.shape[-1]))
    units[:, 0, dimension:] = np.where(length > 0.0, length, 1.0)[:, None]
    size = np.abs(applied / units).max(axis=(-1, -2))
    return np.abs((found - wanted) / units).max(axis=(-1, -2)) / np.maximum(size, 1e-300)


def into_frame(vectors: FloatArray, axis: FloatArray) -> FloatArray:
    """Planar vectors ``(..., 2)`` seen from a frame whose x axis has the direction ``axis``."""
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack(rotated_back(axis[..., COS], axis[..., SIN], x, y), axis=-1)


def out_of_frame(wrenches: FloatArray, axis: FloatArray) -> FloatArray:
    """Planar wrenches ``(batch, n, 3)`` of such a frame, as seen from outside."""
    x, y, torque = np.moveaxis(wrenches, -1, 0)
    x, y = rotated(axis[:, COS, None], axis[:, SIN, None], x, y)
    return np.stack([x, y, torque], axis=-1)
