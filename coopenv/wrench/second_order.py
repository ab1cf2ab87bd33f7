"""Second-order cones {(s_0, s_1): ‖s_1‖ ≤ s_0} for an interior-point method, compiled.

A pair (s, z) in the cone lies in a row of numbers from ``at`` on, beside all that is derived from
it; s and z have four components, [s_0, s_1], padded with zeros. ``det`` is s_0² − ‖s_1‖². It is
carried along from step to step where the difference would cancel.

Source: Nesterov-Todd scaling as in L. Vandenberghe, "The CVXOPT linear and quadratic cone program
solvers", 2010, sections 4 and 5.
"""

from math import sqrt

import numpy as np
from numba import njit

S, Z, W, Q, DS, DZ = 0, 4, 8, 12, 16, 20  # offsets: the pair, scaling, right-hand side, steps
DET_S, DET_Z, ERROR_S, ERROR_Z, PER_ETA, HALF_ANGLE = 24, 25, 26, 27, 28, 29
CONE = 30  # numbers a cone occupies
ROUNDING = 4e-16  # of a product of vectors, relative
CANCELLED = 1e-3  # s·z, relative to s_0 z_0, below which it is not taken from the components
TINY = 1e-300  # keeps divisions finite where the numerator is zero as well

compiled = njit(
    error_model="numpy",
    nogil=True,
    fastmath={"contract"},
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
)


@compiled
def mirrored(row, a, b):
    """aᵀJb, the inner product with one tail negated; ``mirrored(row, a, a)`` is det a."""
    return (
        row[a] * row[b]
        - row[a + 1] * row[b + 1]
        - row[a + 2] * row[b + 2]
        - row[a + 3] * row[b + 3]
    )


@compiled
def scale(row, at):
    """Write the Nesterov-Todd direction w and 1/η.

    W = η [w_0, w_1ᵀ; w_1, I + w_1 w_1ᵀ/(1+w_0)] maps z to W z = W⁻¹ s.
    """
    s, z, w = at + S, at + Z, at + W
    root_s, root_z = sqrt(row[at + DET_S]), sqrt(row[at + DET_Z])
    per_s, per_z = 1.0 / root_s, 1.0 / root_z
    gamma = sqrt(0.5 + 0.5 * inner(row, at) * per_s * per_z)
    row[at + HALF_ANGLE] = gamma
    half = 0.5 / gamma
    w1 = (row[s + 1] * per_s - row[z + 1] * per_z) * half
    w2 = (row[s + 2] * per_s - row[z + 2] * per_z) * half
    w3 = (row[s + 3] * per_s - row[z + 3] * per_z) * half
    row[w], row[w + 1], row[w + 2], row[w + 3] = sqrt(1.0 + w1 * w1 + w2 * w2 + w3 * w3), w1, w2, w3
    row[at + PER_ETA] = sqrt(root_z * per_s)


@compiled
def inner(row, at):
    """s·z, accurate also where the vectors are long and nearly opposite."""
    s, z = at + S, at + Z
    tails = row[s + 1] * row[z + 1] + row[s + 2] * row[z + 2] + row[s + 3] * row[z + 3]
    heads = row[s] * row[z]
    if heads + tails > CANCELLED * heads:
        return heads + tails
    length_s = sqrt(row[s + 1] ** 2 + row[s + 2] ** 2 + row[s + 3] ** 2)
    length_z = sqrt(row[z + 1] ** 2 + row[z + 2] ** 2 + row[z + 3] ** 2)
    c1 = row[s + 2] * row[z + 3] - row[s + 3] * row[z + 2]
    c2 = row[s + 3] * row[z + 1] - row[s + 1] * row[z + 3]
    c3 = row[s + 1] * row[z + 2] - row[s + 2] * row[z + 1]
    lean = (row[s] + length_s) / (row[z] + length_z)
    aligned = (c1 * c1 + c2 * c2 + c3 * c3) / (length_s * length_z - tails)
    return 0.5 * (row[at + DET_S] / lean + row[at + DET_Z] * lean) + aligned


@compiled
def unscaled(row, at, x0, x1, x2, x3):
    """W⁻¹ x."""
    w0, w1, w2, w3 = row[at + W], row[at + W + 1], row[at + W + 2], row[at + W + 3]
    along = w1 * x1 + w2 * x2 + w3 * x3
    step = along / (1.0 + w0) - x0
    per_eta = row[at + PER_ETA]
    return (
        per_eta * (w0 * x0 - along),
        per_eta * (x1 + step * w1),
        per_eta * (x2 + step * w2),
        per_eta * (x3 + step * w3),
    )


@compiled
def dual_step(row, at):
    """Write dz = q − W⁻² ds."""
    w, q, ds, dz = at + W, at + Q, at + DS, at + DZ
    square = row[at + PER_ETA] * row[at + PER_ETA]
    along = 2.0 * mirrored(row, w, ds)
    row[dz] = row[q] - square * (row[w] * along - row[ds])
    for r in range(1, 4):
        row[dz + r] = row[q + r] - square * (row[ds + r] - row[w + r] * along)


@compiled
def correct(row, at, target):
    """Write the second-order corrector's right-hand side.

    q = −z + target·s⁻¹ + W⁻¹(u + λ∖(u∘u)),  u = W⁻¹ds (the predictor's),  λ = W⁻¹s
    """
    s, z, q, d = at + S, at + Z, at + Q, at + DS
    u0, u1, u2, u3 = unscaled(row, at, row[d], row[d + 1], row[d + 2], row[d + 3])
    l0, l1, l2, l3 = _scaled_pair(row, at)
    p0 = u0 * u0 + u1 * u1 + u2 * u2 + u3 * u3
    p1, p2, p3 = 2.0 * u0 * u1, 2.0 * u0 * u2, 2.0 * u0 * u3
    det = sqrt(row[at + DET_S] * row[at + DET_Z])
    t0 = (l0 * p0 - l1 * p1 - l2 * p2 - l3 * p3) / max(det, TINY)
    per_l0 = 1.0 / l0
    u1 += (p1 - t0 * l1) * per_l0
    u2 += (p2 - t0 * l2) * per_l0
    u3 += (p3 - t0 * l3) * per_l0
    u0, u1, u2, u3 = unscaled(row, at, u0 + t0, u1, u2, u3)
    inverse = target / row[at + DET_S]
    row[q] = u0 - row[z] + inverse * row[s]
    row[q + 1] = u1 - row[z + 1] - inverse * row[s + 1]
    row[q + 2] = u2 - row[z + 2] - inverse * row[s + 2]
    row[q + 3] = u3 - row[z + 3] - inverse * row[s + 3]


@compiled
def _scaled_pair(row, at):
    """λ = W⁻¹ s = W z, from both."""
    s, z, gamma = at + S, at + Z, row[at + HALF_ANGLE]
    root_s, root_z = sqrt(row[at + DET_S]), sqrt(row[at + DET_Z])
    per_s, per_z = 1.0 / root_s, 1.0 / root_z
    size = sqrt(root_s * root_z)
    s0, z0 = row[s] * per_s, row[z] * per_z
    part = size / (s0 + z0 + 2.0 * gamma)
    from_s, from_z = (gamma + z0) * part * per_s, (gamma + s0) * part * per_z
    return (
        size * gamma,
        from_s * row[s + 1] + from_z * row[z + 1],
        from_s * row[s + 2] + from_z * row[z + 2],
        from_s * row[s + 3] + from_z * row[z + 3],
    )


@compiled
def longest_step(row, x, dx, det):
    """Largest α with x + α dx in the cone; infinite where the ray stays inside."""
    slope = mirrored(row, x, dx)
    bend = mirrored(row, dx, dx)
    root = slope * slope - bend * det
    if root < 0.0:
        return np.inf
    root = sqrt(root)
    if slope > 0.0:
        return (root + slope) / -bend if bend < 0.0 else np.inf
    return det / (root - slope) if root > slope else np.inf


@compiled
def advance(row, x, dx, which, step):
    """Take a step, carrying the det and what rounding may have done to it (``which`` is its place).

    det(x + α dx) = det x + 2α xᵀJdx + α² det dx: exact in what the step was chosen by.
    """
    error = which + ERROR_S - DET_S
    slope, bend = mirrored(row, x, dx), mirrored(row, dx, dx)
    det = row[which] + step * (2.0 * slope + step * bend)
    row[error] += ROUNDING * max(row[which], det)
    row[which] = det
    for r in range(4):
        row[x + r] += step * row[dx + r]


@compiled
def refresh(row, x, which):
    """Evaluate a det anew where that is more accurate than carrying it along."""
    error = which + ERROR_S - DET_S
    doubt = ROUNDING * row[x] * row[x]
    if doubt < row[error]:
        length = sqrt(row[x + 1] ** 2 + row[x + 2] ** 2 + row[x + 3] ** 2)
        value = (row[x] - length) * (row[x] + length)
        if value > 2.0 * doubt:
            row[which], row[error] = value, doubt
