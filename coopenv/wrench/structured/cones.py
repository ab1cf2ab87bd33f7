"""Second-order cones {(s_0, s_1): ‖s_1‖ ≤ s_0} of an interior-point method; compiled.

The fields of a ``cone`` hold a pair (s, z) and all that is derived from it, in four lanes for four
cones at once (`lanes`). s and z have four components, [s_0, s_1], padded with zeros. det s is
s_0² − ‖s_1‖². Where the difference would cancel, it is carried along from step to step.

Source: Nesterov-Todd scaling as in L. Vandenberghe, "The CVXOPT linear and quadratic cone program
solvers", 2010, sections 4 and 5.
"""

import numpy as np

from coopenv.compiled import fused, fused_inlined
from coopenv.compiled.lanes.vectors import larger, root, some, splat, where
from coopenv.wrench.structured.tolerances import CANCELLED, ROUNDING

S, Z = 0, 4  # fields: the pair
W = 8  # direction w of the scaling
Q = 12  # right-hand side q
DS, DZ = 16, 20  # steps
DET_S, DET_Z = 24, 25
ERROR_S, ERROR_Z = 26, 27  # what rounding may have done to the dets
LAMBDA = 28  # λ = W⁻¹ s = W z, scaled to a det of 1
PER_LAMBDA, PER_HEAD, PER_BEND = 32, 33, 34  # 1/λ_0, 1/(1 + w_0), 1/(2 w_0² − 1)
PER_S, SQUARE, PER_SQUARE, INNER = 35, 36, 37, 38  # 1/√det s, 1/η², η², s·z
CONE = 39  # fields of a cone


@fused_inlined
def mirrored(cone, a, b):
    """Return aᵀJb, the inner product with one tail negated; ``mirrored(cone, a, a)`` is det a."""
    return (
        cone[a] * cone[b]
        - cone[a + 1] * cone[b + 1]
        - cone[a + 2] * cone[b + 2]
        - cone[a + 3] * cone[b + 3]
    )


@fused_inlined
def product(cone, a, b):
    """Return the inner product aᵀb."""
    return (
        cone[a] * cone[b]
        + cone[a + 1] * cone[b + 1]
        + cone[a + 2] * cone[b + 2]
        + cone[a + 3] * cone[b + 3]
    )


@fused_inlined
def tail(cone, x):
    """Return the length of x without its first component."""
    return root(cone[x + 1] * cone[x + 1] + cone[x + 2] * cone[x + 2] + cone[x + 3] * cone[x + 3])


@fused_inlined
def scale(cone):
    """Write the Nesterov-Todd direction w, λ and the other fields of the scaling.

    W = η [w_0, w_1ᵀ; w_1, I + w_1 w_1ᵀ/(1+w_0)] maps z to W z = W⁻¹ s.
    """
    root_s, root_z = root(cone[DET_S]), root(cone[DET_Z])
    per_both = 1.0 / (root_s * root_z)
    per_s, per_z = root_z * per_both, root_s * per_both
    gamma = root(0.5 + 0.5 * cone[INNER] * per_both)
    s0, z0 = cone[S] * per_s, cone[Z] * per_z
    heads = s0 + z0 + 2.0 * gamma
    per_product = 1.0 / (gamma * heads)
    per_gamma, per_heads = heads * per_product, gamma * per_product
    from_s, from_z = (gamma + z0) * per_heads * per_s, (gamma + s0) * per_heads * per_z
    for_s, for_z = 0.5 * per_gamma * per_s, 0.5 * per_gamma * per_z
    square = splat(0.0)
    for r in range(1, 4):
        s, z = cone[S + r], cone[Z + r]
        cone[LAMBDA + r] = from_s * s + from_z * z
        w = for_s * s - for_z * z
        cone[W + r] = w
        square = square + w * w
    w0 = root(1.0 + square)
    head, bend = 1.0 + w0, 1.0 + 2.0 * square
    per_product = 1.0 / (head * bend)
    cone[W], cone[LAMBDA], cone[PER_LAMBDA] = w0, gamma, per_gamma
    cone[PER_HEAD], cone[PER_BEND] = bend * per_product, head * per_product
    cone[PER_S], cone[SQUARE], cone[PER_SQUARE] = per_s, root_z * per_s, root_s * per_z


@fused_inlined
def inner(cone):
    """Return s·z, accurate also where the vectors are long and nearly opposite."""
    plain, heads = product(cone, S, Z), cone[S] * cone[Z]
    cancelled = plain <= CANCELLED * heads
    return where(cancelled, _inner_of_opposite(cone), plain) if some(cancelled) else plain


@fused
def _inner_of_opposite(cone):
    """Return s·z from the dets and the angle between the tails."""
    s, z = S, Z
    tails = cone[s + 1] * cone[z + 1] + cone[s + 2] * cone[z + 2] + cone[s + 3] * cone[z + 3]
    length_s, length_z = tail(cone, s), tail(cone, z)
    c1 = cone[s + 2] * cone[z + 3] - cone[s + 3] * cone[z + 2]
    c2 = cone[s + 3] * cone[z + 1] - cone[s + 1] * cone[z + 3]
    c3 = cone[s + 1] * cone[z + 2] - cone[s + 2] * cone[z + 1]
    lean = (cone[s] + length_s) / (cone[z] + length_z)
    aligned = (c1 * c1 + c2 * c2 + c3 * c3) / (length_s * length_z - tails)
    return 0.5 * (cone[DET_S] / lean + cone[DET_Z] * lean) + aligned


@fused_inlined
def unscaled(cone, x0, x1, x2, x3):
    """Return η W⁻¹ x."""
    w0, w1, w2, w3 = cone[W], cone[W + 1], cone[W + 2], cone[W + 3]
    along = w1 * x1 + w2 * x2 + w3 * x3
    step = along * cone[PER_HEAD] - x0
    return w0 * x0 - along, x1 + step * w1, x2 + step * w2, x3 + step * w3


@fused_inlined
def dual_step(cone):
    """Write dz = q − W⁻² ds."""
    w, q, ds, dz = W, Q, DS, DZ
    square = cone[SQUARE]
    along = 2.0 * mirrored(cone, w, ds)
    cone[dz] = cone[q] - square * (cone[w] * along - cone[ds])
    for r in range(1, 4):
        cone[dz + r] = cone[q + r] - square * (cone[ds + r] - cone[w + r] * along)


@fused_inlined
def write_corrector(cone, target, present):
    """Write the right-hand side q of the second-order corrector; 0 where there is no such cone.

    q = −z + target·s⁻¹ + W⁻¹(u + λ∖(u∘u)),  u = W⁻¹ds (the predictor's),  λ = W⁻¹s

    With v = ηu and λ scaled to a det of 1 the last term is η⁻² (ηW⁻¹)(v + λ∖(v∘v)/√det s).
    """
    s, z, q, d = S, Z, Q, DS
    u0, u1, u2, u3 = unscaled(cone, cone[d], cone[d + 1], cone[d + 2], cone[d + 3])
    l0, l1, l2, l3 = cone[LAMBDA], cone[LAMBDA + 1], cone[LAMBDA + 2], cone[LAMBDA + 3]
    per_s, square = cone[PER_S], cone[SQUARE]
    square_u = u0 * u0 + u1 * u1 + u2 * u2 + u3 * u3
    t0 = (l0 * square_u - 2.0 * u0 * (l1 * u1 + l2 * u2 + l3 * u3)) * per_s
    part = cone[PER_LAMBDA]
    twice = 2.0 * u0 * per_s * part
    u1, u2, u3 = (
        u1 + twice * u1 - t0 * part * l1,
        u2 + twice * u2 - t0 * part * l2,
        u3 + twice * u3 - t0 * part * l3,
    )
    u0, u1, u2, u3 = unscaled(cone, u0 + t0, u1, u2, u3)
    inverse = target * per_s * per_s
    q0 = square * u0 - cone[z] + inverse * cone[s]
    q1 = square * u1 - cone[z + 1] - inverse * cone[s + 1]
    q2 = square * u2 - cone[z + 2] - inverse * cone[s + 2]
    q3 = square * u3 - cone[z + 3] - inverse * cone[s + 3]
    cone[q], cone[q + 1] = where(present, q0, 0.0), where(present, q1, 0.0)
    cone[q + 2], cone[q + 3] = where(present, q2, 0.0), where(present, q3, 0.0)


@fused_inlined
def longest_step(cone, x, dx, det):
    """Return the largest α with x + α dx in the cone; infinite where the ray stays inside.

    det(x + α dx) is positive behind the apex, too. A step that leads through the apex, or so near
    that the roots are lost in rounding, is known by its first component: it ends at x_0 = 0.
    """
    slope = mirrored(cone, x, dx)
    bend = mirrored(cone, dx, dx)
    length = root(larger(slope * slope - bend * det, 0.0))
    inwards = slope > 0.0
    over = where(inwards, length + slope, det)
    under = where(inwards, -bend, length - slope)
    behind = (cone[dx] < 0.0) & (-cone[dx] * over > cone[x] * under)
    over, under = where(behind, cone[x], over), where(behind, -cone[dx], under)
    return where(under > 0.0, over / under, np.inf)


@fused_inlined
def advance(cone, x, dx, which, step):
    """Take a step of x, and carry along its det (field ``which``) and the error of that.

    det(x + α dx) = det x + 2α xᵀJdx + α² det dx

    This is accurate, as the length α of the step was computed from the same terms.
    """
    error = which + ERROR_S - DET_S
    slope, bend = mirrored(cone, x, dx), mirrored(cone, dx, dx)
    before = cone[which]
    det = before + step * (2.0 * slope + step * bend)
    cone[error] += ROUNDING * larger(before, det)
    cone[which] = det
    for r in range(4):
        cone[x + r] += step * cone[dx + r]


@fused_inlined
def refresh(cone, x, which):
    """Evaluate a det anew from x where that is more accurate than carrying it along."""
    error = which + ERROR_S - DET_S
    doubt = ROUNDING * cone[x] * cone[x]
    if some(doubt < cone[error]):
        length = tail(cone, x)
        renew(cone, which, (cone[x] - length) * (cone[x] + length), doubt)


@fused_inlined
def renew(cone, which, value, doubt):
    """Replace a det by a value uncertain by ``doubt``, in the lanes where that is better."""
    error = which + ERROR_S - DET_S
    better = (doubt < cone[error]) & (value > 2.0 * doubt)
    cone[which] = where(better, value, cone[which])
    cone[error] = where(better, doubt, cone[error])
