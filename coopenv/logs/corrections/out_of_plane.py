"""Six axes of a sensor in the plane: its whole wrench, the part in the plane, and what is not."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.logs.recorded import Recording

IN_PLANE, BEYOND = [0, 1, 5], [2, 3, 4]  # fx fy tz, and fz tx ty, of fx fy fz tx ty tz


def whole_wrench(planar: FloatArray, beyond: FloatArray) -> FloatArray:
    """Wrenches ``(T, 6)`` of their parts ``(T, 3)`` in the plane and out of it."""
    made = np.empty((len(planar), 6))
    made[:, IN_PLANE], made[:, BEYOND] = planar, beyond
    return made


def in_plane(wrench: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parts ``(T, 3)`` of wrenches ``(T, 6)`` in the plane, and out of it."""
    return wrench[:, IN_PLANE], wrench[:, BEYOND]


class LeftOut:
    """Mean squares of what is out of the plane, and of what is in it.

    Parameters
    ----------
    places
        Effectors, from 0, of which all six axes are read.
    """

    def __init__(self, places: Iterable[int]):
        self._rows = 0
        self._sums = {place: np.zeros(6) for place in places}

    def of(self, recordings: Iterable[Recording]) -> Iterator[Recording]:
        """Recordings without what is out of the plane, which is counted."""
        for recording in recordings:
            beyond, good = recording.out_of_plane, recording.good
            self._rows += int(good.sum())
            for place, sums in self._sums.items():
                if beyond is not None:
                    each = whole_wrench(recording.applied[:, place], beyond[:, place])[good]
                    sums += (each * each).sum(axis=0)
            yield replace(recording, out_of_plane=None)

    def sentences(self) -> Iterator[str]:
        """How much it was, a line a sensor."""
        for place, sums in sorted(self._sums.items()):
            if not self._rows:
                return
            square = sums / self._rows
            planar, force = np.sqrt(square[:2].sum()), np.sqrt(square[2])
            torque, beyond = np.sqrt(square[5]), np.sqrt(square[3:5].sum())
            yield (
                f"sensor {place + 1}: {force:.3g} N and {beyond:.3g} N·m out of the plane left "
                f"out, beside {planar:.3g} N and {torque:.3g} N·m in it (root mean squares)"
            )
