"""Upper bound of plausible internal forces: the dual of `max_internal`, by a barrier method.

minimise  D(μ) = ¼ bᵀA⁻¹b  over μ ≥ 0 with A = Σ μ_i N_iᵀN_i − I ≻ 0,  b = Σ μ_i N_iᵀf_i

D is convex, ∂D/∂μ_i = f_iᵀN_i z − ‖N_i z‖² at z = ½A⁻¹b, and every feasible μ gives a valid bound.
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray

FALL = 0.1  # factor between the barrier's weights
CENTRED = 0.7  # Newton decrement below which the weight falls
LAST = 1e-15  # the last weight, relative to the square of the largest force
MAX_STEPS = 120  # it takes about 40
MAX_HALVINGS = 30
LARGEST = 1e5  # of Σμ: where nothing can be internal, the best μ is at infinity
REGULAR = 1e-9  # least condition of A: beyond it rounding would spoil the bound


def best_bound(
    basis: FloatArray, free: BoolArray, force: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least upper bound of Σ‖g_i‖² and the point z that belongs to it, for forces of order 1.

    Parameters
    ----------
    basis
        N, ``(batch, n, d, m)``; columns that are not ``free`` are 0.
    free
        Which columns count, ``(batch, m)``.
    force
        ``(batch, n, d)``, the largest of length 1.

    Returns
    -------
    D ``(batch,)`` and z ``(batch, m)``.
    """
    gram = np.einsum("bndi,bndj->bnij", basis, basis)  # N_iᵀN_i
    pull = np.einsum("bndm,bnd->bnm", basis, force)  # N_iᵀf_i
    identity = np.einsum("bm,mk->bmk", free.astype(float), np.eye(free.shape[-1]))
    rest = np.eye(free.shape[-1]) - identity  # keeps A regular where a column does not count

    def matrix(mu: FloatArray) -> FloatArray:
        return np.einsum("bn,bnij->bij", mu, gram) - identity + rest

    mu = np.full(force.shape[:-1], 2.0)  # A = I
    weight = np.ones(len(force))
    for _ in range(MAX_STEPS):
        step, decrement = _newton_step(matrix(mu), gram, pull, mu, weight)
        length = _allowed(matrix, mu, step, decrement)
        mu = mu + length[:, None] * step
        weight = np.where(decrement < CENTRED, np.maximum(FALL * weight, LAST), weight)
        weight = np.where(length > 0.0, weight, LAST)
        if (weight <= LAST).all():
            break
    z = 0.5 * np.linalg.solve(matrix(mu), _weighted(mu, pull)[..., None])[..., 0]
    bound = 0.5 * (z * _weighted(mu, pull)).sum(axis=-1)
    return np.asarray(bound, dtype=np.float64), np.asarray(z, dtype=np.float64)


def _weighted(mu: FloatArray, pull: FloatArray) -> FloatArray:
    return np.einsum("bn,bnm->bm", mu, pull)


def _newton_step(
    a: FloatArray, gram: FloatArray, pull: FloatArray, mu: FloatArray, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Newton step of D(μ) − weight·barrier, and its decrement.

    The barrier is log det A + Σ log μ_i + log(LARGEST − Σ μ_i).
    """
    room = 1.0 / (LARGEST - mu.sum(axis=-1, keepdims=True))
    inverse = np.linalg.inv(a)
    z = 0.5 * np.einsum("bij,bj->bi", inverse, _weighted(mu, pull))
    slope = pull - 2.0 * np.einsum("bnij,bj->bni", gram, z)  # of the constraints, at z
    slack = np.einsum("bni,bi->bn", pull - np.einsum("bnij,bj->bni", gram, z), z)
    solved = np.einsum("bij,bnjk->bnik", inverse, gram)
    gradient = slack - weight[:, None] * (np.trace(solved, axis1=-2, axis2=-1) + 1.0 / mu - room)
    hessian = 0.5 * np.einsum("bni,bij,bkj->bnk", slope, inverse, slope)
    hessian += weight[:, None, None] * np.einsum("bnij,bkji->bnk", solved, solved)
    hessian += weight[:, None, None] * (room**2)[..., None]
    index = np.arange(mu.shape[-1])
    hessian[:, index, index] += weight[:, None] / mu**2
    scale = 1.0 / np.sqrt(np.maximum(hessian[:, index, index], 1e-300))
    scaled = hessian * scale[:, :, None] * scale[:, None, :]
    scaled[:, index, index] += 1e-14
    step = -scale * np.linalg.solve(scaled, (scale * gradient)[..., None])[..., 0]
    return step, np.sqrt(np.maximum(-(step * gradient).sum(axis=-1) / weight, 0.0))


def _allowed(matrix, mu: FloatArray, step: FloatArray, decrement: FloatArray) -> FloatArray:
    """Damped step length ``(batch,)``, halved until μ > 0 and A ≻ 0; 0 at the end of precision."""
    length = 1.0 / (1.0 + np.where(decrement > 0.25, decrement, 0.0))
    outside = np.zeros(length.shape, dtype=np.bool_)
    for _ in range(MAX_HALVINGS):
        there = mu + length[:, None] * step
        outside = (there <= 0.0).any(axis=-1) | (there.sum(axis=-1) >= LARGEST)
        values = np.linalg.eigvalsh(matrix(there))
        outside |= values[:, 0] <= REGULAR * values[:, -1]
        if not outside.any():
            break
        length = np.where(outside, 0.5 * length, length)
    return np.where(outside, 0.0, length)
