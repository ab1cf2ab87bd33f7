"""Facial reduction: finds, proves and fixes parts of a wrench that cannot be internal; compiled.

Every ball has 0 on its surface, ‖g‖² ≤ v·g. Let there be multipliers λ of balance such that

−Gᵀλ = μ_f f + μ_d P f  in every block of a force,  −Gᵀλ = μ_t t  in every one of a torque,  μ ≥ 0

where P takes the part across the lever. Then 0 = −λᵀΣ G g = Σ μ v·g is a sum of terms that are not
negative. All of them are 0, so that g is 0 in every part whose μ is positive. The best known case
is that of agreeing forces, where λ points against their sum.

Where there is such a λ the feasible set has no interior, and the multipliers of the iterations grow
along λ without end. That is where λ is looked for. It counts only if the equations hold to
rounding. Then those parts are fixed and the iterations start afresh.

Source: facial reduction as in Borwein & Wolkowicz 1981; this proof is our own.
"""

from coopenv.compiled import fused
from coopenv.compiled.lanes.memory import after
from coopenv.wrench.structured.balance import (
    BEFORE,
    NU,
    NU_STEP,
    add_squares,
    clear_matrix,
    collect_matrix,
    find_pivots,
    solve_system,
)
from coopenv.wrench.structured.blocks import (
    COLUMNS,
    CONES,
    FIRST_CONE,
    FREE,
    PENDING,
    STEP,
    V,
    block,
    chunk,
    num_blocks,
    num_chunks,
)
from coopenv.wrench.structured.cones import CONE, Z
from coopenv.wrench.structured.frame import norm3
from coopenv.wrench.structured.tolerances import PROOF_ERROR, PROOF_POSITIVE, SUSPECT_SHARE

PROOF = NU_STEP  # row of λ
BLIND = STEP  # fields: 1 for coordinates of −Gᵀλ that must be 0


@fused
def fix_immovable(sample, system, multiplier):
    """Fix the parts that are proved immovable; return whether there are any.

    ``multiplier`` is the largest of a ball or disc.
    """
    # propose parts by their multipliers, and λ by those of balance
    limit = SUSPECT_SHARE * multiplier
    for i in range(num_blocks(sample)):
        _suspect(block(sample, i), limit)
    for r in range(6):
        system[PROOF, r] = system[NU, r]
    for _ in range(2):
        _project(sample, system)

    # prove
    size = 0.0
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        for j in range(int(row[FREE])):
            size = max(size, abs(_along(row, system, j)))
    if size <= PROOF_POSITIVE * limit:
        return False
    for i in range(num_blocks(sample)):
        if not _proves(block(sample, i), system, size):
            return False

    # fix
    fixed = False
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        if row[PENDING] < row[FREE]:
            fixed = True
            row[FREE], row[CONES] = row[PENDING], (2.0 if row[PENDING] > 0.0 else 0.0)
    return fixed


@fused
def _suspect(row, limit):
    """Propose what stays free: none if the ball's multiplier is large, one if the disc's."""
    row[PENDING] = row[FREE]
    if row[FREE] == 0.0:
        return
    if row[FIRST_CONE + CONE + Z] >= limit:
        row[PENDING] = 0.0
    elif row[CONES] > 2.0 and row[FIRST_CONE + 2 * CONE + Z] >= limit:
        row[PENDING] = 1.0


@fused
def _along(row, system, j):
    """Return coordinate j of −Gᵀλ."""
    total = 0.0
    for r in range(6):
        total -= row[COLUMNS + 6 * j + r] * system[PROOF, r]
    return total


@fused
def _may_differ(row, j):
    """Whether coordinate j of −Gᵀλ may differ from 0 if the proposal holds."""
    if row[PENDING] == row[FREE]:
        return False
    if row[CONES] == 2.0:
        return j == 0
    return j == 1 or (j == 0 and row[PENDING] == 0.0 and abs(row[V]) > PROOF_ERROR)


@fused
def _project(sample, system):
    """Make λ obey the equations: project it so that coordinates which must be 0 are 0."""
    for r in range(6):
        system[BEFORE, r] = system[PROOF, r]
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        for j in range(3):
            row[BLIND + j] = 1.0 if j < row[FREE] and not _may_differ(row, j) else 0.0
    clear_matrix(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        add_squares(sample, after(b, COLUMNS), 0, b[BLIND], b[BLIND + 1], b[BLIND + 2])
    collect_matrix(sample, system)
    for r in range(6):
        total = 0.0
        for t in range(6):
            total += system[max(r, t), min(r, t)] * system[BEFORE, t]
        system[PROOF, r] = total
    find_pivots(system)
    solve_system(system)
    for r in range(6):
        system[PROOF, r] = system[BEFORE, r] - system[PROOF, r]


@fused
def _proves(row, system, size):
    """Whether λ obeys the equations of a block with μ ≥ 0; settle what of it has μ > 0."""
    for j in range(int(row[FREE])):
        if not _may_differ(row, j) and abs(_along(row, system, j)) > PROOF_ERROR * size:
            return False
    if row[PENDING] == row[FREE]:
        return True
    w0, w1 = _along(row, system, 0), 0.0
    if row[CONES] == 2.0:
        return w0 * row[V] > PROOF_POSITIVE * size * abs(row[V])
    w1 = _along(row, system, 1)
    ball = w0 / row[V] if abs(row[V]) > PROOF_ERROR else 0.0
    disc = w1 / row[V + 1] - ball
    length = norm3(row[V], row[V + 1], 0.0)
    if min(ball, disc) * length < -PROOF_ERROR * size:
        return False
    if ball * length > PROOF_POSITIVE * size or abs(row[V]) <= PROOF_ERROR:
        row[PENDING] = 0.0
    elif row[PENDING] == 0.0:
        return False
    return max(ball, disc) * length > PROOF_POSITIVE * size
