"""Kernel density of load shares over the unit square, and the time in its quadrants."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.stats import gaussian_kde
from typing_extensions import Self

from coopenv.arrays import FloatArray
from coopenv.errors import InvalidInput

STEP = 0.01  # of the grid, as in the paper
_REACH = 5.0  # standard deviations of a kernel that are taken into account
_LEAST_SPREAD = 1e-6  # of the shares, below which a line or a point remains


@dataclass(frozen=True, slots=True, kw_only=True)
class Quadrants:
    """Shares of time; they sum to 1. The shares are those of agent 1."""

    dominant: float  # supplies more than half of force and torque
    passive: float  # less than half of both
    force_specialist: float  # more than half of the force, less of the torque
    torque_specialist: float  # the reverse

    @classmethod
    def of(
        cls,
        force_share: npt.ArrayLike,
        torque_share: npt.ArrayLike,
        weights: npt.ArrayLike | None = None,
    ) -> Self:
        """Shares of the samples, or of their ``weights`` (durations), in each quadrant.

        A share of exactly one half counts half to either side.

        Parameters
        ----------
        force_share, torque_share
            ``(time,)`` α_f,1 and α_t,1; samples in which either is NaN are left out.
        weights
            ``(time,)``, not negative.

        Raises
        ------
        InvalidInput
            If no sample is left.
        """
        force, torque, weight = _defined(force_share, torque_share, weights)
        most, turns = np.heaviside(force - 0.5, 0.5), np.heaviside(torque - 0.5, 0.5)
        weight = weight / weight.sum()
        return cls(
            dominant=float(weight @ (most * turns)),
            passive=float(weight @ ((1 - most) * (1 - turns))),
            force_specialist=float(weight @ (most * (1 - turns))),
            torque_specialist=float(weight @ ((1 - most) * turns)),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadDensity:
    """A density over the unit square on a grid; its integral is 1."""

    share: FloatArray  # (k,) the grid's values of either share, 0 to 1
    density: FloatArray  # (k, k): first axis α_f,1, second axis α_t,1

    @classmethod
    def of(
        cls,
        force_share: npt.ArrayLike,
        torque_share: npt.ArrayLike,
        weights: npt.ArrayLike | None = None,
        *,
        step: float = STEP,
        bandwidth: float | None = None,
    ) -> Self:
        """Gaussian kernel density of (α_f,1, α_t,1).

        The kernels are SciPy's, of the samples' covariance scaled by Scott's factor. What they
        put outside the square is folded back at its edges, so that shares of 0 and 1, which are
        common, are not thinned out.

        Parameters
        ----------
        force_share, torque_share, weights
            As in `Quadrants.of`.
        step
            Of the grid; must divide 1. Samples are sorted into cells of half its size first.
        bandwidth
            Factor on the samples' standard deviations; Scott's n^(−1/6) if ``None``.

        Raises
        ------
        InvalidInput
            If there is no sample, the shares lie on a line, or ``step`` does not divide 1.
        """
        force, torque, weight = _defined(force_share, torque_share, weights)
        cells = round(1 / step) if step > 0 else 0
        if cells < 1 or abs(cells * step - 1) > 1e-9:
            raise InvalidInput(f"step must divide 1, got {step}; take 0.01 or 0.02")
        points = np.stack([force, torque])
        factor = _scott(weight) if bandwidth is None else bandwidth
        spread = np.cov(points, aweights=weight) if len(weight) > 2 else np.zeros((2, 2))
        if np.linalg.eigvalsh(spread)[0] < _LEAST_SPREAD**2:
            raise InvalidInput(
                "force_share and torque_share must vary independently for a density, got samples "
                "on a line or a point; report their quadrants instead"
            )
        kernels = _kernels(points, weight, step / 2, factor)
        width = np.sqrt(np.diag(kernels.covariance).max())
        margin = min(int(np.ceil(_REACH * width / step)), cells)
        axis = np.arange(-margin, cells + margin + 1) / cells
        where = np.stack(np.meshgrid(axis, axis, indexing="ij")).reshape(2, -1)
        raw = kernels(where).reshape(len(axis), len(axis))
        folded = _folded(_folded(raw, margin, cells).T, margin, cells).T
        return cls(share=np.linspace(0, 1, cells + 1), density=folded)

    @property
    def integral(self) -> float:
        """Over the unit square; 1 up to the grid's error."""
        return float(np.trapezoid(np.trapezoid(self.density, self.share), self.share))


def _defined(
    force: npt.ArrayLike, torque: npt.ArrayLike, weights: npt.ArrayLike | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    force, torque = np.asarray(force, np.float64), np.asarray(torque, np.float64)
    weight = np.ones(force.shape) if weights is None else np.asarray(weights, np.float64)
    if force.ndim != 1 or force.shape != torque.shape or force.shape != weight.shape:
        raise InvalidInput(
            f"force_share, torque_share and weights must be of one length, got {force.shape}, "
            f"{torque.shape} and {weight.shape}; give one of each a sample"
        )
    if not (weight >= 0).all():
        raise InvalidInput(f"weights must not be negative, got {weight.min()}; give durations [s]")
    known = ~np.isnan(force) & ~np.isnan(torque) & (weight > 0)
    if not known.any():
        raise InvalidInput(
            "force_share and torque_share must be defined somewhere, got NaN only; there was no "
            "resultant to share"
        )
    for name, share in (("force_share", force[known]), ("torque_share", torque[known])):
        if share.min() < -1e-9 or share.max() > 1 + 1e-9:
            raise InvalidInput(
                f"{name} must lie in [0, 1], got {share.min()} to {share.max()}; take "
                "coopenv.wrench.load_share"
            )
    return np.clip(force[known], 0, 1), np.clip(torque[known], 0, 1), weight[known]


def _scott(weight: FloatArray) -> float:
    """n^(−1/6) for two dimensions, n the effective number of samples."""
    return float((weight.sum() ** 2 / (weight**2).sum()) ** (-1 / 6))


def _kernels(points: FloatArray, weight: FloatArray, cell: float, factor: float) -> gaussian_kde:
    """Kernels on the cells that hold samples, at the samples' mean in each."""
    count = round(1 / cell) + 1
    index = np.rint(points / cell).astype(np.int64)
    _, which = np.unique(index[0] * count + index[1], return_inverse=True)
    mass = np.bincount(which, weight)
    centres = np.stack([np.bincount(which, weight * row) / mass for row in points])
    return gaussian_kde(centres, weights=mass, bw_method=factor)


def _folded(raw: FloatArray, margin: int, cells: int) -> FloatArray:
    """Fold what lies beyond either end of the first axis back into it."""
    inside = raw[margin : margin + cells + 1].copy()
    inside[: margin + 1] += raw[margin::-1]  # the edge itself counts twice: from either side
    inside[cells - margin :] += raw[: margin + cells - 1 : -1]
    return inside
