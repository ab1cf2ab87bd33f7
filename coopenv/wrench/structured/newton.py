"""Newton steps of the structured solver: work linear in the number of effectors, compiled.

Eliminating τ and g from every block leaves one symmetric system in the multipliers ν of balance,
G g = 0, whatever the number of effectors:

M dν = r + Σ G H⁻¹ ρ,   M = Σ G H⁻¹ Gᵀ,   H dg = Gᵀdν − ρ,   H = L D Lᵀ of size 3

H is the sum of the curvatures of the block's cones, ρ the residual of stationarity plus the
cones' right-hand sides, r = −G g. The blocks ``k`` are laid out in `blocks`; every function here
treats a chunk of four of them at once. A step takes four passes over them, and what is not in the
processor's cache is fetched as often. That a step misses balance by its rounding does little harm,
as the next one starts from the r there is; where progress is slow it is refined nevertheless.
"""

from math import inf

from coopenv.compiled import fused, fused_inlined
from coopenv.wrench.structured.balance import (
    BALANCE,
    NU_STEP,
    SPARE,
    add_resultant,
    clear_matrix,
    clear_resultant,
    collect_matrix,
    collect_resultant,
    factorise_system,
    seen,
    solve_system,
)
from coopenv.wrench.structured.blocks import (
    CONES,
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
    Q,
    S,
    W,
    Z,
    correct,
    dual_step,
    longest_step,
    product,
)
from coopenv.wrench.structured.curvature import factorise_block, under_hessian
from coopenv.wrench.structured.lanes import smaller, smallest, splat, total, where

REGULAR = 1e-14  # added to the pivots of M, relative to its diagonal


@fused
def predict(k, system):
    """Factorise and step towards the boundary; return `_move`'s lengths and products."""
    clear_matrix(k)
    clear_resultant(k)
    for i in range(num_chunks(k)):
        factorise_block(k, i)
        _load(k, i)
    collect_matrix(k, system)
    for r in range(6):
        system[r, r] *= 1.0 + REGULAR
    factorise_system(system)
    return _move(k, system, False)


@fused
def improve(k, system, target, refined):
    """Step towards s·z = ``target``, corrected for the predictor's step, which it replaces."""
    clear_resultant(k)
    for i in range(num_chunks(k)):
        b = chunk(k, i)
        for c in range(num_cones(b)):
            correct(cone_of(b, c), target, b[CONES] > c)
        _load(k, i)
    return _move(k, system, refined)


@fused_inlined
def _load(k, i):
    """Take ρ from the residual of stationarity and the cones' q; add G H⁻¹ρ to the resultant.

    ρ = Σ ± (z_1 + q_1 [+ 2 w_0 w_1 q_0 / (2 w_0² − 1), costs only, for their τ]) − Gᵀν
    """
    b = chunk(k, i)
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
    add_resultant(k, i, x, y, z)


@fused
def _move(k, system, refined):
    """Solve for dν and write dg, ds and dz of every block.

    Returns the longest steps that keep every s and every z in its cone, Σ ds·z, Σ s·dz, and
    Σ ds·dz.
    """
    for r in range(6):
        system[NU_STEP, r] = system[BALANCE, r]
    collect_resultant(k, system, NU_STEP, 1.0)
    solve_system(system)
    if refined:
        _refine(k, system)
    load = 0.0 if refined else 1.0
    primal, dual = splat(inf), splat(inf)
    moved, dual_moved, both = splat(0.0), splat(0.0), splat(0.0)
    for i in range(num_chunks(k)):
        b = chunk(k, i)
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
            system[NU_STEP, r] += system[SPARE, r]
    return smallest(primal), smallest(dual), total(moved), total(dual_moved), total(both)


@fused
def _refine(k, system):
    """Write dg and solve once more for what it misses of balance, Σ G dg = r.

    dν of the first time goes to a spare row.
    """
    clear_resultant(k)
    for i in range(num_chunks(k)):
        b = chunk(k, i)
        y0, y1, y2 = seen(b, system, NU_STEP, i & 1)
        x, y, z = under_hessian(b, y0 - b[RIGHT], y1 - b[RIGHT + 1], y2 - b[RIGHT + 2])
        b[STEP], b[STEP + 1], b[STEP + 2] = x, y, z
        add_resultant(k, i, x, y, z)
    for r in range(6):
        system[SPARE, r], system[NU_STEP, r] = system[NU_STEP, r], system[BALANCE, r]
    collect_resultant(k, system, NU_STEP, -1.0)
    solve_system(system)


@fused_inlined
def _move_cone(cone, x, y, z, c, present):
    """Write ds and dz for dg = (x, y, z); a cost's τ moves so that its own dual stays c."""
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
