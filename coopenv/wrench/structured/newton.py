"""Newton steps of the structured solver, in work linear in the number of effectors; compiled.

Eliminating τ and g from every block leaves one symmetric system of 6 equations in the multipliers
ν of balance, G g = 0:

M dν = r + Σ G H⁻¹ ρ,   M = Σ G H⁻¹ Gᵀ,   H dg = Gᵀdν − ρ,   H = L D Lᵀ of size 3

H is the sum of the curvatures of the block's cones in its free coordinates. It is factorised and
never inverted, since close to the boundary its parts differ by many magnitudes. ρ is the residual
of stationarity plus the cones' right-hand sides, and r = −G g.

Every function treats a chunk of four blocks at once (`blocks`). A step takes four passes over the
blocks, since what is not in the processor's cache has to be fetched in every pass. A step misses
balance by its rounding. That does little harm, as the next step starts from the r there is; where
progress is slow the step is refined nevertheless.
"""

from math import inf

from coopenv.compiled import fused, fused_inlined
from coopenv.compiled.lanes.memory import after
from coopenv.compiled.lanes.vectors import larger, smaller, smallest, splat, total, where
from coopenv.wrench.structured.balance import (
    BALANCE,
    BEFORE,
    NU_STEP,
    SCRATCH,
    add_resultant,
    add_squares,
    clear_matrix,
    clear_resultant,
    collect_matrix,
    collect_resultant,
    factorise_system,
    seen,
    solve_system,
    sums,
)
from coopenv.wrench.structured.blocks import (
    COLUMNS,
    CONES,
    FACTOR,
    FREE,
    RIGHT,
    SEEN,
    STEP,
    chunk,
    cone_of,
    num_chunks,
    num_cones,
)
from coopenv.wrench.structured.cones import (
    DET_S,
    DET_Z,
    DS,
    DZ,
    PER_BEND,
    PER_SQUARE,
    SQUARE,
    Q,
    S,
    W,
    Z,
    dual_step,
    longest_step,
    product,
    scale,
    write_corrector,
)
from coopenv.wrench.structured.tolerances import LEAST_PIVOT, RAISED_PIVOT


@fused
def predict(sample, system):
    """Factorise and find the step towards the optimum; return what `_find_direction` does."""
    clear_matrix(sample)
    clear_resultant(sample)
    for i in range(num_chunks(sample)):
        _factorise_block(sample, i)
        _load(sample, i)
    collect_matrix(sample, system)
    for r in range(6):
        system[r, r] *= 1.0 + RAISED_PIVOT
    factorise_system(system)
    return _find_direction(sample, system, False)


@fused
def correct(sample, system, target, refined):
    """Find the step towards s·z = ``target``, with the predictor's step in the right-hand side.

    It replaces the predictor's; returned is what `_find_direction` does.
    """
    clear_resultant(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for c in range(num_cones(b)):
            write_corrector(cone_of(b, c), target, b[CONES] > c)
        _load(sample, i)
    return _find_direction(sample, system, refined)


@fused
def _factorise_block(sample, i):
    """Scale the cones, factorise H, and add G H⁻¹ Gᵀ to M.

    G H⁻¹ Gᵀ is the square of G L⁻ᵀ with the weights D⁻¹.
    """
    # scale the cones
    b = chunk(sample, i)
    for c in range(num_cones(b)):
        cone = cone_of(b, c)
        scale(cone)
        for r in range(4):
            cone[Q + r] = where(b[CONES] > c, -cone[Z + r], 0.0)

    # factorise H
    h00, h01, h02, h11, h12, h22 = _hessian(b)
    several, all_three = b[FREE] > 1.0, b[FREE] > 2.0
    p0 = where(b[FREE] > 0.0, 1.0 / h00, 0.0)
    l10 = where(several, h01 * p0, 0.0)
    p1 = where(several, 1.0 / larger(h11 - l10 * h01, LEAST_PIVOT * h11), 0.0)
    l20 = where(all_three, h02 * p0, 0.0)
    bend = h12 - l20 * h01
    l21 = where(all_three, bend * p1, 0.0)
    p2 = where(all_three, 1.0 / larger(h22 - l20 * h02 - l21 * bend, LEAST_PIVOT * h22), 0.0)
    b[FACTOR], b[FACTOR + 1], b[FACTOR + 2] = l10, l20, l21
    b[FACTOR + 3], b[FACTOR + 4], b[FACTOR + 5] = p0, p1, p2

    # add to M
    carried = after(sums(sample), SCRATCH)
    for r in range(3 * (i & 1), 6):
        a0, a1, a2 = b[COLUMNS + r], b[COLUMNS + 6 + r], b[COLUMNS + 12 + r]
        a1 -= l10 * a0
        carried[r], carried[6 + r], carried[12 + r] = a0, a1, a2 - l20 * a0 - l21 * a1
    add_squares(sample, carried, 3 * (i & 1), p0, p1, p2)


@fused_inlined
def _hessian(b):
    """Return the upper triangle of H, the sum of the cones' curvatures with τ eliminated."""
    zero = splat(0.0)
    h00, h01, h02, h11, h12, h22 = zero, zero, zero, zero, zero, zero
    for c in range(num_cones(b)):
        cone = cone_of(b, c)
        w1, w2, w3 = cone[W + 1], cone[W + 2], cone[W + 3]
        square = where(b[CONES] > c, cone[SQUARE], 0.0)
        bend = square * (splat(2.0) if c == 1 or c == 2 else -2.0 * cone[PER_BEND])
        if c < 2:
            h00 += square + bend * w1 * w1
            h01 += bend * w1 * w2
            h02 += bend * w1 * w3
        h11 += square + bend * w2 * w2
        h12 += bend * w2 * w3
        h22 += square + bend * w3 * w3
    return h00, h01, h02, h11, h12, h22


@fused_inlined
def under_hessian(b, y0, y1, y2):
    """Return H⁻¹ y."""
    y1 -= b[FACTOR] * y0
    y2 = (y2 - b[FACTOR + 1] * y0 - b[FACTOR + 2] * y1) * b[FACTOR + 5]
    y1 = y1 * b[FACTOR + 4] - b[FACTOR + 2] * y2
    return y0 * b[FACTOR + 3] - b[FACTOR] * y1 - b[FACTOR + 1] * y2, y1, y2


@fused_inlined
def _load(sample, i):
    """Write ρ from the residual of stationarity and the cones' q; add G H⁻¹ρ to the resultant.

    ρ = Σ ± (z_1 + q_1 [+ 2 w_0 w_1 q_0 / (2 w_0² − 1), costs only, for their τ]) − Gᵀν
    """
    b = chunk(sample, i)
    y0, y1, y2 = -b[SEEN], -b[SEEN + 1], -b[SEEN + 2]
    for c in range(num_cones(b)):
        cone = cone_of(b, c)
        sign, more = splat(-1.0), splat(0.0)
        if c == 0 or c == 3:
            sign, more = splat(1.0), 2.0 * cone[W] * cone[Q] * cone[PER_BEND]
        sign = where(b[CONES] > c, sign, 0.0)
        y0 += sign * (cone[Z + 1] + cone[Q + 1] + more * cone[W + 1])
        y1 += sign * (cone[Z + 2] + cone[Q + 2] + more * cone[W + 2])
        y2 += sign * (cone[Z + 3] + cone[Q + 3] + more * cone[W + 3])
    b[RIGHT], b[RIGHT + 1], b[RIGHT + 2] = y0, y1, y2
    x, y, z = under_hessian(b, y0, y1, y2)
    add_resultant(sample, i, x, y, z)


@fused
def _find_direction(sample, system, refined):
    """Solve for dν, and write dg, ds and dz of every block.

    Returns the longest steps that keep every s and every z in its cone, Σ ds·z, Σ s·dz, and
    Σ ds·dz.
    """
    for r in range(6):
        system[NU_STEP, r] = system[BALANCE, r]
    collect_resultant(sample, system, NU_STEP, 1.0)
    solve_system(system)
    if refined:
        _refine(sample, system)
    load = 0.0 if refined else 1.0
    primal, dual = splat(inf), splat(inf)
    moved, dual_moved, both = splat(0.0), splat(0.0), splat(0.0)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        y0, y1, y2 = seen(b, system, NU_STEP, i & 1)
        y0, y1, y2 = y0 - load * b[RIGHT], y1 - load * b[RIGHT + 1], y2 - load * b[RIGHT + 2]
        x, y, z = under_hessian(b, y0, y1, y2)
        if refined:
            x, y, z = x + b[STEP], y + b[STEP + 1], z + b[STEP + 2]
        b[STEP], b[STEP + 1], b[STEP + 2] = x, y, z
        for c in range(num_cones(b)):
            cone = cone_of(b, c)
            _move_cone(cone, x, y, z, c, b[CONES] > c)
            primal = smaller(longest_step(cone, S, DS, cone[DET_S]), primal)
            dual = smaller(longest_step(cone, Z, DZ, cone[DET_Z]), dual)
            moved += product(cone, DS, Z)
            dual_moved += product(cone, S, DZ)
            both += product(cone, DS, DZ)
    if refined:
        for r in range(6):
            system[NU_STEP, r] += system[BEFORE, r]
    return smallest(primal), smallest(dual), total(moved), total(dual_moved), total(both)


@fused
def _refine(sample, system):
    """Write dg and solve once more for what it misses of balance, Σ G dg = r.

    The first dν is kept beside the second.
    """
    clear_resultant(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        y0, y1, y2 = seen(b, system, NU_STEP, i & 1)
        x, y, z = under_hessian(b, y0 - b[RIGHT], y1 - b[RIGHT + 1], y2 - b[RIGHT + 2])
        b[STEP], b[STEP + 1], b[STEP + 2] = x, y, z
        add_resultant(sample, i, x, y, z)
    for r in range(6):
        system[BEFORE, r], system[NU_STEP, r] = system[NU_STEP, r], system[BALANCE, r]
    collect_resultant(sample, system, NU_STEP, -1.0)
    solve_system(system)


@fused_inlined
def _move_cone(cone, x, y, z, c, present):
    """Write ds and dz for dg = (x, y, z); the τ of a cost moves so that its own dual stays c."""
    is_cost = c == 0 or c == 3
    sign = where(present, -1.0 if is_cost else 1.0, 0.0)
    cone[DS] = 0.0
    cone[DS + 1] = sign * x if c < 2 else splat(0.0)
    cone[DS + 2] = sign * y
    cone[DS + 3] = sign * z
    if is_cost:
        along = cone[W + 1] * cone[DS + 1] + cone[W + 2] * cone[DS + 2]
        along += cone[W + 3] * cone[DS + 3]
        cone[DS] = (cone[Q] * cone[PER_SQUARE] + 2.0 * cone[W] * along) * cone[PER_BEND]
    dual_step(cone)
    if is_cost:
        cone[DZ] = 0.0
