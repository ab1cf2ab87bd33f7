"""Thinning of long curves to the least, largest and mean of consecutive rows."""

import numpy as np

from coopenv.arrays import FloatArray

BINS = 400  # kept at least, twice as many at most: a panel is some 700 pixels wide


class Envelope:
    """Curves over x, thinned as they grow.

    While there are few rows each has a bin of its own. When there are too many, neighbours are
    merged and every later bin takes twice as many rows.
    """

    def __init__(self, bins: int = BINS):
        self._bins = bins
        self.rows_a_bin = 1
        self._parts: list[tuple[FloatArray, ...]] = []
        self._count = 0

    def add(self, x: FloatArray, values: FloatArray) -> None:
        """Append rows: ``x`` ``(T,)``, curves ``(m, T)``; NaN leaves gaps."""
        finite = np.isfinite(values)
        bins = (x, values, values, np.where(finite, values, 0.0), finite.astype(np.float64))
        self._append(bins, self.rows_a_bin)
        while self._count > 2 * self._bins:
            whole = tuple(np.concatenate(part, -1) for part in zip(*self._parts, strict=True))
            self._parts, self._count = [], 0
            self.rows_a_bin *= 2
            self._append(whole, 2)

    def curves(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Where each bin begins, x ``(b,)``; least, largest and mean of each curve ``(m, b)``."""
        x, low, high, total, count = (
            np.concatenate(part, -1) for part in zip(*self._parts, strict=True)
        )
        mean = np.where(count > 0, total / np.maximum(count, 1.0), np.nan)
        return x, low, high, mean

    def _append(self, bins: tuple[FloatArray, ...], every: int) -> None:
        x, low, high, total, count = bins
        first = np.arange(0, len(x), every)
        merged = (
            np.fmin.reduceat(x, first),
            np.fmin.reduceat(low, first, axis=-1),
            np.fmax.reduceat(high, first, axis=-1),
            np.add.reduceat(total, first, axis=-1),
            np.add.reduceat(count, first, axis=-1),
        )
        self._parts.append(merged)
        self._count += len(first)
