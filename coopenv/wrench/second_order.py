"""Second-order cones {(s_0, s_1): ‖s_1‖ ≤ s_0} for an interior-point method, compiled.

A pair (s, z) in the cone lies in an array ``cone`` of numbers, beside all that is derived from it;
s and z have four components, [s_0, s_1], padded with zeros. ``det`` is s_0² − ‖s_1‖². It is carried
along from step to step where the difference would cancel.

Source: Nesterov-Todd scaling as in L. Vandenberghe, "The CVXOPT linear and quadratic cone program
solvers", 2010, sections 4 and 5.
"""

from math import sqrt
from typing import Any

import numpy as np
from numba import njit

S, Z, W, Q, DS, DZ = 0, 4, 8, 12, 16, 20  # offsets: the pair, scaling, right-hand side, steps
DET_S, DET_Z, ERROR_S, ERROR_Z = 24, 25, 26, 27
LAMBDA = 28  # W⁻¹ s = W z
PER_ETA, SQUARE, PER_HEAD, PER_BEND = 32, 33, 34, 35  # 1/η, 1/η², 1/(1 + w_0), 1/(2 w_0² − 1)
CONE = 36  # numbers a cone occupies
ROUNDING = 4e-16  # of a product of vectors, relative
CANCELLED = 1e-3  # s·z, relative to s_0 z_0, below which it is not taken from the components
TINY = 1e-300  # keeps divisions finite where the numerator is zero as well

OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "nogil": True,
    "fastmath": {"contract"},
    "no_cpython_wrapper": True,  # they are called from compiled code only
    "no_cfunc_wrapper": True,
}
compiled = njit(**OPTIONS)
inlined = njit(**OPTIONS, forceinline=True)


@inlined
def mirrored(cone, a, b):
    """aᵀJb, the inner product with one tail negated; ``mirrored(cone, a, a)`` is det a."""
    return (
        cone[a] * cone[b]
        - cone[a + 1] * cone[b + 1]
        - cone[a + 2] * cone[b + 2]
        - cone[a + 3] * cone[b + 3]
    )


@inlined
def scale(cone):
    """Write the Nesterov-Todd direction w, 1/η and λ = W⁻¹ s.

    W = η [w_0, w_1ᵀ; w_1, I + w_1 w_1ᵀ/(1+w_0)] maps z to W z = W⁻¹ s.
    """
    s, z, w = S, Z, W
    root_s, root_z = sqrt(cone[DET_S]), sqrt(cone[DET_Z])
    per_s, per_z = 1.0 / root_s, 1.0 / root_z
    gamma = sqrt(0.5 + 0.5 * inner(cone) * per_s * per_z)
    s0, z0, half = cone[s] * per_s, cone[z] * per_z, 0.5 / gamma
    size = sqrt(root_s * root_z)
    part = size / (s0 + z0 + 2.0 * gamma)
    from_s, from_z = (gamma + z0) * part * per_s, (gamma + s0) * part * per_z
    cone[LAMBDA] = size * gamma
    for r in range(1, 4):
        cone[LAMBDA + r] = from_s * cone[s + r] + from_z * cone[z + r]
    w1 = (cone[s + 1] * per_s - cone[z + 1] * per_z) * half
    w2 = (cone[s + 2] * per_s - cone[z + 2] * per_z) * half
    w3 = (cone[s + 3] * per_s - cone[z + 3] * per_z) * half
    w0 = sqrt(1.0 + w1 * w1 + w2 * w2 + w3 * w3)
    cone[w], cone[w + 1], cone[w + 2], cone[w + 3] = w0, w1, w2, w3
    cone[SQUARE] = root_z * per_s
    cone[PER_ETA] = sqrt(cone[SQUARE])
    cone[PER_HEAD] = 1.0 / (1.0 + w0)
    cone[PER_BEND] = 1.0 / (2.0 * w0 * w0 - 1.0)


@inlined
def inner(cone):
    """s·z, accurate also where the vectors are long and nearly opposite."""
    s, z = S, Z
    tails = cone[s + 1] * cone[z + 1] + cone[s + 2] * cone[z + 2] + cone[s + 3] * cone[z + 3]
    heads = cone[s] * cone[z]
    if heads + tails > CANCELLED * heads:
        return heads + tails
    length_s = sqrt(cone[s + 1] ** 2 + cone[s + 2] ** 2 + cone[s + 3] ** 2)
    length_z = sqrt(cone[z + 1] ** 2 + cone[z + 2] ** 2 + cone[z + 3] ** 2)
    c1 = cone[s + 2] * cone[z + 3] - cone[s + 3] * cone[z + 2]
    c2 = cone[s + 3] * cone[z + 1] - cone[s + 1] * cone[z + 3]
    c3 = cone[s + 1] * cone[z + 2] - cone[s + 2] * cone[z + 1]
    lean = (cone[s] + length_s) / (cone[z] + length_z)
    aligned = (c1 * c1 + c2 * c2 + c3 * c3) / (length_s * length_z - tails)
    return 0.5 * (cone[DET_S] / lean + cone[DET_Z] * lean) + aligned


@inlined
def unscaled(cone, x0, x1, x2, x3):
    """W⁻¹ x."""
    w0, w1, w2, w3 = cone[W], cone[W + 1], cone[W + 2], cone[W + 3]
    along = w1 * x1 + w2 * x2 + w3 * x3
    step = along * cone[PER_HEAD] - x0
    per_eta = cone[PER_ETA]
    return (
        per_eta * (w0 * x0 - along),
        per_eta * (x1 + step * w1),
        per_eta * (x2 + step * w2),
        per_eta * (x3 + step * w3),
    )


@inlined
def dual_step(cone):
    """Write dz = q − W⁻² ds."""
    w, q, ds, dz = W, Q, DS, DZ
    square = cone[SQUARE]
    along = 2.0 * mirrored(cone, w, ds)
    cone[dz] = cone[q] - square * (cone[w] * along - cone[ds])
    for r in range(1, 4):
        cone[dz + r] = cone[q + r] - square * (cone[ds + r] - cone[w + r] * along)


@inlined
def correct(cone, target):
    """Write the second-order corrector's right-hand side.

    q = −z + target·s⁻¹ + W⁻¹(u + λ∖(u∘u)),  u = W⁻¹ds (the predictor's),  λ = W⁻¹s
    """
    s, z, q, d = S, Z, Q, DS
    u0, u1, u2, u3 = unscaled(cone, cone[d], cone[d + 1], cone[d + 2], cone[d + 3])
    l0, l1, l2, l3 = cone[LAMBDA], cone[LAMBDA + 1], cone[LAMBDA + 2], cone[LAMBDA + 3]
    p0 = u0 * u0 + u1 * u1 + u2 * u2 + u3 * u3
    p1, p2, p3 = 2.0 * u0 * u1, 2.0 * u0 * u2, 2.0 * u0 * u3
    det = sqrt(cone[DET_S] * cone[DET_Z])
    t0 = (l0 * p0 - l1 * p1 - l2 * p2 - l3 * p3) / max(det, TINY)
    per_l0 = 1.0 / l0
    u1 += (p1 - t0 * l1) * per_l0
    u2 += (p2 - t0 * l2) * per_l0
    u3 += (p3 - t0 * l3) * per_l0
    u0, u1, u2, u3 = unscaled(cone, u0 + t0, u1, u2, u3)
    inverse = target / cone[DET_S]
    cone[q] = u0 - cone[z] + inverse * cone[s]
    cone[q + 1] = u1 - cone[z + 1] - inverse * cone[s + 1]
    cone[q + 2] = u2 - cone[z + 2] - inverse * cone[s + 2]
    cone[q + 3] = u3 - cone[z + 3] - inverse * cone[s + 3]


@inlined
def longest_step(cone, x, dx, det):
    """Largest α with x + α dx in the cone; infinite where the ray stays inside."""
    slope = mirrored(cone, x, dx)
    bend = mirrored(cone, dx, dx)
    root = slope * slope - bend * det
    if root < 0.0:
        return np.inf
    root = sqrt(root)
    if slope > 0.0:
        return (root + slope) / -bend if bend < 0.0 else np.inf
    return det / (root - slope) if root > slope else np.inf


@inlined
def advance(cone, x, dx, which, step):
    """Take a step, carrying the det and what rounding may have done to it (``which`` is its place).

    det(x + α dx) = det x + 2α xᵀJdx + α² det dx: exact in what the step was chosen by.
    """
    error = which + ERROR_S - DET_S
    slope, bend = mirrored(cone, x, dx), mirrored(cone, dx, dx)
    det = cone[which] + step * (2.0 * slope + step * bend)
    cone[error] += ROUNDING * max(cone[which], det)
    cone[which] = det
    for r in range(4):
        cone[x + r] += step * cone[dx + r]


@inlined
def refresh(cone, x, which):
    """Evaluate a det anew where that is more accurate than carrying it along."""
    error = which + ERROR_S - DET_S
    doubt = ROUNDING * cone[x] * cone[x]
    if doubt < cone[error]:
        length = sqrt(cone[x + 1] ** 2 + cone[x + 2] ** 2 + cone[x + 3] ** 2)
        value = (cone[x] - length) * (cone[x] + length)
        if value > 2.0 * doubt:
            cone[which], cone[error] = value, doubt
