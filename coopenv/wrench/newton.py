"""Newton steps of the structured solver: work linear in the number of effectors, compiled.

Eliminating τ and g from every block leaves one symmetric system in the multipliers ν of balance,
G g = 0, whatever the number of effectors:

M dν = r + Σ G H⁻¹ ρ,   M = Σ G H⁻¹ Gᵀ,   H dg = Gᵀdν − ρ,   H = L D Lᵀ of size 3

H is the sum of the curvatures of the block's cones, ρ the residual of stationarity plus the
cones' right-hand sides, r = −G g. The blocks ``k`` are laid out in `blocks`.
"""

from coopenv.wrench.blocks import (
    CARRIED,
    COLUMNS,
    CONES,
    FACTOR,
    FREE,
    RIGHT,
    STEP,
    cone_of,
)
from coopenv.wrench.coupling import (
    BALANCE,
    NU,
    NU_STEP,
    SPARE,
    clear,
    factorise_system,
    solve_system,
)
from coopenv.wrench.second_order import (
    DS,
    DZ,
    PER_BEND,
    SQUARE,
    Q,
    W,
    Z,
    compiled,
    dual_step,
    scale,
)

REGULAR = 1e-14  # added to the pivots of M, relative to its diagonal
FLOOR = 1e-15  # least pivot of H, relative to its diagonal


@compiled
def factorise(k, system):
    """Scale every cone, factorise every block and the system that couples them."""
    clear(system)
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            row = k[i]
            for c in range(int(row[CONES])):
                scale(cone_of(row, c))
            _factorise_block(row, system, 3 * (i & 1))
    for r in range(6):
        system[r, r] *= 1.0 + REGULAR
    factorise_system(system)


@compiled
def direction(k, system, refined):
    """Solve the Newton system for the q in place: dg, ds, dz and dν."""
    for r in range(6):
        system[NU_STEP, r] = system[BALANCE, r]
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            _load(k[i], system, 3 * (i & 1))
    solve_system(system)
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            spread_step(k[i], system, 3 * (i & 1), 1.0, STEP)
    if refined:
        _refine(k, system)
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            _move_cones(k[i])


@compiled
def _refine(k, system):
    """Solve once more for what the steps miss of balance, Σ G dg = r."""
    for r in range(6):
        system[SPARE, r], system[NU_STEP, r] = system[NU_STEP, r], system[BALANCE, r]
    for i in range(k.shape[0]):
        for j in range(int(k[i, FREE])):
            for r in range(3 * (i & 1), 6):
                system[NU_STEP, r] -= k[i, COLUMNS + 6 * j + r] * k[i, STEP + j]
    solve_system(system)
    for i in range(k.shape[0]):
        if k[i, FREE] > 0.0:
            spread_step(k[i], system, 3 * (i & 1), 0.0, STEP)
    for r in range(6):
        system[NU_STEP, r] += system[SPARE, r]


@compiled
def _hessian(row):
    """Upper triangle of H: the sum of the cones' curvatures, τ eliminated."""
    h00, h01, h02, h11, h12, h22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(int(row[CONES])):
        cone = cone_of(row, c)
        w1, w2, w3 = cone[W + 1], cone[W + 2], cone[W + 3]
        square = cone[SQUARE]
        bend = square * (2.0 if c == 1 or c == 2 else -2.0 * cone[PER_BEND])
        if c < 2:
            h00 += square + bend * w1 * w1
            h01 += bend * w1 * w2
            h02 += bend * w1 * w3
        h11 += square + bend * w2 * w2
        h12 += bend * w2 * w3
        h22 += square + bend * w3 * w3
    return h00, h01, h02, h11, h12, h22


@compiled
def _factorise_block(row, system, first):
    """Factorise H, carry G through L, and add G H⁻¹ Gᵀ to M (lower triangle).

    ``first`` is 3 for torques, which make no resultant force.
    """
    h00, h01, h02, h11, h12, h22 = _hessian(row)
    l10, l20, l21 = 0.0, 0.0, 0.0
    p0, p1, p2 = 1.0 / h00, 0.0, 0.0
    if row[FREE] > 1.0:
        l10 = h01 * p0
        p1 = 1.0 / max(h11 - l10 * h01, FLOOR * h11)
    if row[FREE] > 2.0:
        l20 = h02 * p0
        bend = h12 - l20 * h01
        l21 = bend * p1
        p2 = 1.0 / max(h22 - l20 * h02 - l21 * bend, FLOOR * h22)
    row[FACTOR], row[FACTOR + 1], row[FACTOR + 2] = l10, l20, l21
    row[FACTOR + 3], row[FACTOR + 4], row[FACTOR + 5] = p0, p1, p2
    for r in range(first, 6):
        a0 = row[COLUMNS + r]
        a1 = row[COLUMNS + 6 + r] - l10 * a0
        a2 = row[COLUMNS + 12 + r] - l20 * a0 - l21 * a1
        row[CARRIED + r], row[CARRIED + 6 + r], row[CARRIED + 12 + r] = a0, a1, a2
        a0, a1, a2 = a0 * p0, a1 * p1, a2 * p2
        for t in range(first, r + 1):
            part = a0 * row[CARRIED + t] + a1 * row[CARRIED + 6 + t] + a2 * row[CARRIED + 12 + t]
            system[r, t] += part


@compiled
def _load(row, system, first):
    """Take ρ from the residual of stationarity and the cones' q; add G H⁻¹ρ to dν.

    ρ = Σ ± (z_1 + q_1 [+ 2 w_0 w_1 q_0 / (2 w_0² − 1), costs only, for their τ]) − Gᵀν
    """
    y0, y1, y2 = 0.0, 0.0, 0.0
    for r in range(first, 6):
        nu = system[NU, r]
        y0 -= row[COLUMNS + r] * nu
        y1 -= row[COLUMNS + 6 + r] * nu
        y2 -= row[COLUMNS + 12 + r] * nu
    for c in range(int(row[CONES])):
        cone = cone_of(row, c)
        sign, more = -1.0, 0.0
        if c == 0 or c == 3:
            sign, more = 1.0, 2.0 * cone[W] * cone[Q] * cone[PER_BEND]
        y0 += sign * (cone[Z + 1] + cone[Q + 1] + more * cone[W + 1])
        y1 += sign * (cone[Z + 2] + cone[Q + 2] + more * cone[W + 2])
        y2 += sign * (cone[Z + 3] + cone[Q + 3] + more * cone[W + 3])
    y1 -= row[FACTOR] * y0
    y2 -= row[FACTOR + 1] * y0 + row[FACTOR + 2] * y1
    row[RIGHT], row[RIGHT + 1], row[RIGHT + 2] = y0, y1, y2
    y0, y1, y2 = y0 * row[FACTOR + 3], y1 * row[FACTOR + 4], y2 * row[FACTOR + 5]
    for r in range(first, 6):
        part = row[CARRIED + r] * y0 + row[CARRIED + 6 + r] * y1 + row[CARRIED + 12 + r] * y2
        system[NU_STEP, r] += part


@compiled
def spread_step(row, system, first, load, part):
    """Write dg = H⁻¹ (Gᵀdν − ρ), or without the ρ (``load`` = 0) add it to a part of the block."""
    y0, y1, y2 = -load * row[RIGHT], -load * row[RIGHT + 1], -load * row[RIGHT + 2]
    for r in range(first, 6):
        nu = system[NU_STEP, r]
        y0 += row[CARRIED + r] * nu
        y1 += row[CARRIED + 6 + r] * nu
        y2 += row[CARRIED + 12 + r] * nu
    y2 *= row[FACTOR + 5]
    y1 = y1 * row[FACTOR + 4] - row[FACTOR + 2] * y2
    keep = 1.0 - load
    row[part] *= keep
    row[part] += y0 * row[FACTOR + 3] - row[FACTOR] * y1 - row[FACTOR + 1] * y2
    row[part + 1] = keep * row[part + 1] + y1
    row[part + 2] = keep * row[part + 2] + y2


@compiled
def _move_cones(row):
    """Write ds and dz of the block's cones; a cost's τ moves so that its own dual stays c."""
    for c in range(int(row[CONES])):
        cone = cone_of(row, c)
        is_cost = c == 0 or c == 3
        sign = -1.0 if is_cost else 1.0
        cone[DS] = 0.0
        cone[DS + 1] = sign * row[STEP] if c < 2 else 0.0
        cone[DS + 2] = sign * row[STEP + 1]
        cone[DS + 3] = sign * row[STEP + 2]
        if is_cost:
            square = cone[SQUARE]
            along = cone[W + 1] * cone[DS + 1] + cone[W + 2] * cone[DS + 2]
            along += cone[W + 3] * cone[DS + 3]
            cone[DS] = cone[Q] / square + 2.0 * cone[W] * along
            cone[DS] *= cone[PER_BEND]
        dual_step(cone)
        if is_cost:
            cone[DZ] = 0.0
