"""Segmentation of recorded rows into trials."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.logs.formats.chunks import Column


class Trials:
    """Numbers the trials of consecutive chunks of rows.

    Parameters
    ----------
    names
        Of the columns that say which trial a row belongs to; a new value in one of them begins a
        new trial. Without any, all rows are one trial.
    """

    def __init__(self, names: Sequence[str]):
        self._names = tuple(names)
        self._last: dict[str, Any] | None = None  # what the last readable row says
        self._number = 0
        self._time = np.nan  # the last there was

    def of(
        self, carried: Mapping[str, Column], time: FloatArray, readable: BoolArray
    ) -> tuple[IntArray, BoolArray, FloatArray]:
        """Of each row: number of its trial, whether it begins a new one, and the time before it.

        ``time`` is ``(T,)``, NaN where there is none; so is the time before, where there was none.
        A row that is not ``readable`` belongs to the trial of the row before it.
        """
        starts = np.zeros(len(time), dtype=np.bool_)
        rows = np.flatnonzero(readable)
        if len(rows):
            for name in self._names:
                column = carried[name][rows]
                starts[rows[1:]] |= _differ(column[1:], column[:-1])
                if self._last is not None:
                    starts[rows[0]] |= bool(_differ(column[:1], self._last[name])[0])
            self._last = {name: carried[name][rows[-1]] for name in self._names}
        trial = self._number + np.cumsum(starts)
        known = np.concatenate([[self._time], time])
        usable = np.isfinite(known)
        usable[1:] |= starts  # time of the trial before is none of the next one's
        newest = np.where(usable, np.arange(len(known)), 0)
        before = known[np.maximum.accumulate(newest)]
        self._number, self._time = int(trial[-1]), float(before[-1])
        return trial, starts, before[:-1]


def _differ(these: Column, those: Any) -> BoolArray:
    """Where two columns differ; two missing values are alike."""
    missing = (these != these) & (those != those)
    return (these != those) & ~missing
