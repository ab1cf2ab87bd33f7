"""Maximal internal force method: all of the forces that can be internal counts as internal.

maximise  Σ‖g_i‖²  over internal forces g that balance, G g = 0 (forces and their moments), and are
plausible, ‖g_i‖² ≤ f_iᵀg_i    (eq. 9)

A convex function is maximised, so there are local maxima. With an orthonormal basis N of the forces
that balance, g = N z, every ball contains 0, and on the ray from 0 through z the boundary of the
feasible set is known in closed form. Search starts from many z, climbs, and ends on the boundary,
so the answer is exactly plausible whatever the climb achieved. How far it may be from the best is
bounded by Lagrange duality: for μ ≥ 0 with A = Σ μ_i N_iᵀN_i − I positive definite,

    Σ‖g_i‖² ≤ D(μ) = ¼ bᵀA⁻¹b,  b = Σ μ_i N_iᵀf_i,

and the least bound D is found by a barrier method (`max_internal_bound`). Where all discs of a
maximiser touch, it is usually tight. The gap √D − √Σ‖g_i‖² [N] is returned as `Decomposition.gap`.

Source: Schmidts, Lee & Peer 2011, as compared in Donner, Endo & Buss 2018. The bound is our own.
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray, in_rows
from coopenv.wrench.answer import Answer, Prepared
from coopenv.wrench.grasp import grasp_matrix
from coopenv.wrench.methods.forces_only import forces_of, without_torque
from coopenv.wrench.methods.max_internal_bound import best_bound
from coopenv.wrench.settings import Settings

TRIED, STARTS, KEPT = 20, 16, 5  # directions looked along for a start; starts; climbed to the end
SWEEPS = 6  # of the projection of random directions on the plausible ones
EARLY, LATE, STEPS = 3, 7, 6  # rounds of the climb for all and for the best; Newton steps in each
PENALTY, GROWTH = 200.0, 4.0  # of leaving a ball, forces being of order 1; growth with each round
CHUNK = 250  # samples at a time, for the memory's sake
NEGLIGIBLE = 1e-12  # part of the largest force below which a force has no part in it
CLOSED = 1e-9  # relative gap below which no further start is tried


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Return the multi-start search; it raises `InvalidInput` where a torque is applied.

    The solver's name is ``"multi_start"``. `Decomposition.gap` bounds by how much the root of
    Σ‖f_I,i‖² may fall short of the largest possible [N]; it is not about the cost.
    """

    def solve(applied: FloatArray) -> Answer:
        force = forces_of(applied, grips, "max_internal")
        batch = force.shape[:-2]
        flat, all_grips = in_rows(force, batch), in_rows(grips, batch)
        internal, gap = np.zeros(flat.shape), np.zeros(len(flat))
        for k in range(0, len(flat), CHUNK):
            part = slice(k, k + CHUNK)
            internal[part], gap[part] = _maximise(flat[part], all_grips[part])
        manipulation = without_torque(force - internal.reshape(force.shape), applied)
        return Answer(manipulation, gap.reshape(batch))

    return Prepared("multi_start", solve)


def _maximise(force: FloatArray, grips: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Internal forces ``(batch, n, d)`` and gaps ``(batch,)`` [N] of samples in a row."""
    size = np.linalg.norm(force, axis=-1)
    unit = size.max(axis=-1)[:, None, None]
    unit = np.where(unit > 0, unit, 1.0)
    basis, free = _balanced_forces(grips, size <= NEGLIGIBLE * unit[..., 0])
    scaled = force / unit
    bound, z = best_bound(basis, free, scaled)
    best = _on_boundary(z, basis, scaled)
    open_samples = np.sqrt((best**2).sum(axis=-1)) < (1.0 - CLOSED) * np.sqrt(bound)
    if open_samples.any():
        part = (z[open_samples], basis[open_samples], scaled[open_samples])
        best[open_samples] = _climb_from_many(*part, free[open_samples])
    gap = np.sqrt(bound) - np.linalg.norm(best, axis=-1)
    internal = np.einsum("bndm,bm->bnd", basis, best) * unit
    return internal, np.maximum(gap, 0.0) * unit[:, 0, 0]


def _balanced_forces(grips: FloatArray, absent: BoolArray) -> tuple[FloatArray, BoolArray]:
    """N, ``(batch, n, d, nd)`` orthonormal where ``(batch, nd)`` says so and 0 elsewhere.

    Effectors that are absent apply no force and get none.
    """
    batch, num_effectors, dimension = grips.shape
    columns = num_effectors * dimension
    matrix = grasp_matrix(grips)
    length = np.linalg.norm(grips, axis=-1).max(axis=-1)
    matrix[:, dimension:] /= np.where(length > 0, length, 1.0)[:, None, None]
    size = matrix.shape[1]
    matrix = matrix.reshape(batch, size, num_effectors, size)[..., :dimension]
    matrix = matrix.reshape(batch, size, columns)
    pinned = np.eye(columns) * np.repeat(absent, dimension, axis=-1)[:, None, :]
    _, values, rows = np.linalg.svd(np.concatenate([matrix, pinned], axis=1))
    free = values <= 1e-10 * values[:, :1]
    basis = np.swapaxes(rows * free[..., None], -1, -2)
    return basis.reshape(batch, num_effectors, dimension, columns), free


def _on_boundary(z: FloatArray, basis: FloatArray, force: FloatArray) -> FloatArray:
    """Go as far along z as eq. 9 allows: ‖s g_i‖² ≤ s f_iᵀg_i."""
    part = np.einsum("bndm,...bm->...bnd", basis, z)
    square = (part**2).sum(axis=-1)
    inner = np.maximum((part * force).sum(axis=-1), 0.0)
    present = square > 1e-30 * square.sum(axis=-1, keepdims=True)
    reach = np.where(present, inner / np.where(present, square, 1.0), np.inf).min(axis=-1)
    return np.where(np.isfinite(reach), reach, 0.0)[..., None] * z


def _climb_from_many(
    z: FloatArray, basis: FloatArray, force: FloatArray, free: BoolArray
) -> FloatArray:
    """Best of the climbs from the bound's own point and from random ones, ``(batch, m)``."""
    gram = np.einsum("bndi,bndj->bnij", basis, basis)
    pull = np.einsum("bndm,bnd->bnm", basis, force)
    starts = np.concatenate([z[None], _directions(basis, force, pull, free)])  # (start, batch, m)
    ends = starts = _on_boundary(starts, basis, force)
    multiplier = np.zeros((*ends.shape[:-1], force.shape[-2]))
    ends, multiplier = _climb(ends, gram, pull, multiplier, PENALTY, EARLY)
    kept = _ranked(_on_boundary(ends, basis, force))[:KEPT, :, None]
    ends, multiplier = (np.take_along_axis(a, kept, axis=0) for a in (ends, multiplier))
    ends, _ = _climb(ends, gram, pull, multiplier, PENALTY * GROWTH**EARLY, LATE)
    ends = np.concatenate([_on_boundary(ends, basis, force), starts])
    return np.take_along_axis(ends, _ranked(ends)[:1, :, None], axis=0)[0]


def _directions(
    basis: FloatArray, force: FloatArray, pull: FloatArray, free: BoolArray
) -> FloatArray:
    """Starts ``(STARTS, batch, m)``, each the longest of a few random plausible directions."""
    generator = np.random.default_rng(0)
    z = generator.normal(size=(STARTS * TRIED, 1, free.shape[-1])) * free
    margin = generator.uniform(0.0, 0.5, size=(len(z), 1, 1))
    length = np.maximum(np.linalg.norm(pull, axis=-1, keepdims=True), NEGLIGIBLE)
    normal = pull / length
    for _ in range(SWEEPS):  # towards f_iᵀN_i z > 0
        z /= np.maximum(np.linalg.norm(z, axis=-1, keepdims=True), NEGLIGIBLE)
        for i in range(normal.shape[1]):
            missing = margin - (z * normal[:, i]).sum(axis=-1, keepdims=True)
            z += np.maximum(missing, 0.0) * normal[:, i]
    z = _on_boundary(z, basis, force).reshape(STARTS, TRIED, *free.shape)
    longest = (z**2).sum(axis=-1).argmax(axis=1)
    return np.take_along_axis(z, longest[:, None, :, None], axis=1)[:, 0]


def _ranked(ends: FloatArray) -> IntArray:
    """Indices of the starts of each sample, longest first ``(start, batch)``."""
    return (-(ends**2).sum(axis=-1)).argsort(axis=0, kind="stable")


def _climb(
    z: FloatArray,
    gram: FloatArray,
    pull: FloatArray,
    multiplier: FloatArray,
    penalty: float,
    rounds: int,
) -> tuple[FloatArray, FloatArray]:
    """Go towards local maxima, by augmented Lagrangians; also return the multipliers."""
    for _ in range(rounds):
        for _ in range(STEPS):
            z = _step(z, gram, pull, multiplier, penalty)
        multiplier = np.maximum(multiplier + penalty * _excess(z, gram, pull), 0.0)
        penalty *= GROWTH
    return z, multiplier


def _excess(z: FloatArray, gram: FloatArray, pull: FloatArray) -> FloatArray:
    """‖g_i‖² − f_iᵀg_i, positive outside the balls of eq. 9."""
    image = np.einsum("bnij,...bj->...bni", gram, z) - pull
    return np.einsum("...bni,...bi->...bn", image, z)


def _step(
    z: FloatArray, gram: FloatArray, pull: FloatArray, multiplier: FloatArray, penalty: float
) -> FloatArray:
    """Newton step on the augmented Lagrangian of −‖z‖², made convex, with a line search."""
    active = np.maximum(multiplier + penalty * _excess(z, gram, pull), 0.0)
    slope = 2.0 * np.einsum("bnij,sbj->sbni", gram, z) - pull
    gradient = np.einsum("sbn,sbni->sbi", active, slope) - 2.0 * z
    hessian = 2.0 * np.einsum("sbn,bnij->sbij", active, gram) - 2.0 * np.eye(z.shape[-1])
    pressed = slope * (active > 0.0)[..., None]
    hessian += penalty * np.swapaxes(pressed, -1, -2) @ pressed
    values, vectors = np.linalg.eigh(hessian)
    along = np.einsum("sbij,sbi->sbj", vectors, gradient) / np.maximum(np.abs(values), 0.1)
    direction = -np.einsum("sbij,sbj->sbi", vectors, along)
    direction /= np.maximum(np.linalg.norm(direction, axis=-1, keepdims=True), 1.0)
    trials = z + np.array([1.0, 0.4, 0.1, 0.02, 0.0])[:, None, None, None] * direction
    pushed = np.maximum(multiplier + penalty * _excess(trials, gram, pull), 0.0)
    value = 0.5 / penalty * (pushed**2).sum(axis=-1) - (trials**2).sum(axis=-1)
    return np.take_along_axis(trials, value.argmin(axis=0)[None, ..., None], axis=0)[0]
