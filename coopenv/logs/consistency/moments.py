"""Least squares among many signals, of which only sums of products are kept."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import nnls

from coopenv.arrays import FloatArray


class Moments:
    """Sums of products of named signals, among which every fit is found afterwards.

    Parameters
    ----------
    centred
        Whether each component's mean is taken off, as that of a constant force.
    """

    def __init__(self, *, centred: bool):
        self.count = 0
        self._centred = centred
        self._names: list[str] = []
        self._sum: FloatArray = np.zeros(0)
        self._products: FloatArray = np.zeros(0)

    def add(self, signals: Mapping[str, FloatArray]) -> None:
        """Append signals of shape ``(T, components)``, always of the same names."""
        stacked = np.stack(list(signals.values()), axis=-1)
        if not self._names:
            self._names = list(signals)
            self._sum = np.zeros(stacked.shape[1:])
            self._products = np.zeros((stacked.shape[2],) * 2)
        flat = stacked.reshape(-1, stacked.shape[2])
        self.count += len(stacked)
        self._sum += stacked.sum(axis=0)
        self._products += flat.T @ flat

    def size(self, name: str) -> float:
        """Root mean square of a signal; 0 where there is none."""
        if not self.count:
            return 0.0
        place = self._names.index(name)
        return float(np.sqrt(self._products[place, place] / self.count))

    def fit(
        self, response: Mapping[str, float], causes: Sequence[str], free: Sequence[str] = ()
    ) -> tuple[float, FloatArray]:
        """Least squares of Σ weight · signal by causes, none of which has a negative factor.

        Parameters
        ----------
        response
            Weights of the signals that are explained.
        causes, free
            Signals that explain them; the factor of a ``free`` one may be negative.

        Returns
        -------
        Share of the response that is left unexplained, in [0, 1] (1 where there is none), and the
        factors ``(causes,)``.
        """
        if not self.count:
            return 1.0, np.zeros(len(causes))
        products = self._products - self._centred * self._sum.T @ self._sum / self.count
        scale = np.sqrt(np.maximum(np.diag(products), 0.0))
        place = [self._names.index(name) for name in (*causes, *free, *free)]
        sign = np.array([1.0] * (len(causes) + len(free)) + [-1.0] * len(free))
        weight = np.zeros(len(scale))
        weight[[self._names.index(name) for name in response]] = list(response.values())
        whole = float(weight @ products @ weight)
        if not whole > 0:
            return 1.0, np.zeros(len(causes))
        unit = sign / np.where(scale > 0, scale, 1.0)[place]
        square = products[np.ix_(place, place)] * np.outer(unit, unit)
        value, vector = np.linalg.eigh(square)
        kept = value > 1e-10 * max(value[-1], 1e-300)
        root = np.sqrt(value[kept])[:, None] * vector[:, kept].T
        target = (vector[:, kept].T @ (unit * (products[place] @ weight))) / np.sqrt(value[kept])
        factor, _ = nnls(root, target)
        explained = float(2 * factor @ root.T @ target - factor @ square @ factor)
        return float(np.clip(1 - explained / whole, 0.0, 1.0)), (factor * unit)[: len(causes)]
