"""Tare of a sensor: what it reads when nothing is there, constant or drifting."""

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput


def tared(wrench: FloatArray, rest: npt.NDArray[np.bool_] | slice) -> FloatArray:
    """Wrenches ``(T, ...)`` less their mean over the rows of ``rest``, where nothing is held.

    Raises
    ------
    InvalidInput
        If there is no such row.
    """
    still = wrench[rest]
    if not len(still):
        raise InvalidInput("rest must have rows, got none; name a time in which there are some")
    return wrench - still.mean(axis=0)


def drift(
    time: FloatArray, times: tuple[float, float], first: FloatArray, last: FloatArray
) -> FloatArray:
    """Bias that grows linearly from one rest to another, and on beyond them.

    Parameters
    ----------
    time
        ``(T,)`` [s].
    times
        Mean times of the two rests [s].
    first, last
        Mean readings in them, ``(...)`` each.

    Returns
    -------
    ``(T, ...)``, to be taken off.

    Raises
    ------
    InvalidInput
        If the second rest is not after the first.
    """
    start, end = times
    if not end > start:
        raise InvalidInput(f"times must increase, got {start:g} and {end:g} s; exchange the rests")
    share = ((time - start) / (end - start)).reshape(-1, *[1] * np.ndim(first))
    return first + share * (last - first)
