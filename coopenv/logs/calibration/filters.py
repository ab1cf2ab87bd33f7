"""Zero-phase low pass: a Butterworth filter that passes forward and backward."""

import math
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, positive
from coopenv.errors import InvalidInput

LEFT = 1e-12  # of a transient, once it counts as gone


def low_pass(values: FloatArray, rate: float, cutoff: float, order: int = 2) -> FloatArray:
    """Low-pass filtered values, not delayed.

    The filter passes twice, so that its gain at the cutoff is ½ and it falls off with twice the
    order. The ends are continued by their mirror images through the last sample (`sosfiltfilt`).

    Parameters
    ----------
    values
        ``(T, ...)``, at equal steps.
    rate
        Of the samples [Hz].
    cutoff
        Of one pass [Hz], below half the rate.
    order
        Of one pass.

    Raises
    ------
    InvalidInput
        If the cutoff is not below half the rate.
    """
    from scipy.signal import sosfiltfilt

    sections = _sections(rate, cutoff, order)
    if len(values) < 2:
        return values.copy()
    delays = (sections[:, [2, 5]] == 0).sum(axis=0).min()
    padding = 3 * (2 * len(sections) + 1 - int(delays))  # as where SciPy chooses it
    return sosfiltfilt(sections, values, axis=0, padlen=min(padding, len(values) - 1))


def settling_rows(rate: float, cutoff: float, order: int) -> int:
    """After how many samples at most a transient is down to `LEFT` of what it was.

    So far from where a recording is cut the filter gives what it gives on the whole of it.
    """
    from scipy.signal import butter

    made: Any = butter(order, _checked(rate, cutoff), output="zpk", fs=rate)
    poles = made[1]
    return math.ceil(math.log(LEFT) / math.log(np.abs(poles).max())) + 3 * (order + 2)


def _sections(rate: float, cutoff: float, order: int) -> FloatArray:
    from scipy.signal import butter

    return np.asarray(butter(order, _checked(rate, cutoff), output="sos", fs=rate))


def _checked(rate: float, cutoff: float) -> float:
    positive(cutoff, "cutoff", unit="Hz")
    if not cutoff < rate / 2:
        raise InvalidInput(
            f"cutoff must be below half the rate of {rate:.6g} Hz, got {cutoff:.6g} Hz; "
            "lower it or leave the filter out"
        )
    return cutoff
