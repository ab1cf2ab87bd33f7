"""Checks of whole arrays that every step makes, for less than NumPy takes to be called."""

import numpy as np

from coopenv.compiled.kinds import compiled


@compiled
def is_finite(array):
    """Whether every element is a finite number."""
    finite = True
    for number in array.flat:
        finite &= np.isfinite(number)
    return finite
