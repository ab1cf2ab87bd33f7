"""Polynomials in batches, ``(..., degree + 1)`` coefficients, highest power first."""

import numpy as np

from coopenv.arrays import FloatArray

VANISHING = 1e-18  # a first coefficient this small, relative to the largest, stands for none


def product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Product of polynomials of any batch shapes that broadcast."""
    batch = np.broadcast_shapes(first.shape[:-1], second.shape[:-1])
    degree = second.shape[-1]
    result = np.zeros((*batch, first.shape[-1] + degree - 1))
    for k in range(first.shape[-1]):
        result[..., k : k + degree] += first[..., k : k + 1] * second
    return result


def real_roots(polynomial: FloatArray) -> FloatArray:
    """Real parts of all roots ``(..., degree)``; of a nearly double root both parts are close.

    Where the degree is lower than it seems, some are huge; NaN where a coefficient is.
    """
    degree = polynomial.shape[-1] - 1
    largest = np.abs(polynomial).max(axis=-1)
    usable = np.isfinite(largest) & (largest > 0.0)
    first = np.where(usable, polynomial[..., 0], 1.0)
    least = VANISHING * np.where(usable, largest, 1.0)
    first = np.where(np.abs(first) > least, first, least)
    companion = np.zeros((*polynomial.shape[:-1], degree, degree))
    companion[..., 1:, :-1] = np.eye(degree - 1)
    monic = polynomial[..., 1:] / first[..., None]
    companion[..., 0, :] = np.where(usable[..., None], -monic, 0.0)
    return np.where(usable[..., None], np.linalg.eigvals(companion).real, np.nan)
