"""What no plausible internal wrench can move: found in the multipliers, proved, and held fixed.

Every ball goes through 0, ‖g‖² ≤ v·g. So if multipliers λ of balance exist with

−Gᵀλ = μ_f f + μ_d P f  or  μ_t t  in every block,  all μ ≥ 0

(P takes the part across the lever), then 0 = −λᵀΣ G g = Σ μ v·g is a sum of nonnegative terms: what
has a positive μ cannot move. Agreeing forces are the best known case (λ = f_o). Such a set has no
interior, the iterations' multipliers grow along λ without end, and there λ is found. It counts only
if the equations hold to rounding; then the parts are fixed and the iterations start afresh.
"""

from coopenv.compiled import fused
from coopenv.wrench.structured.balance import (
    NU,
    NU_STEP,
    SPARE,
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
    norm3,
    num_blocks,
    num_chunks,
)
from coopenv.wrench.structured.cones import CONE, Z
from coopenv.wrench.structured.memory import after
from coopenv.wrench.structured.tolerances import PROOF_ERROR, PROOF_POSITIVE, SUSPECT_SHARE

LAMBDA, SEEING = NU_STEP, STEP  # where λ is kept, and which coordinates see what must be 0


@fused
def fix_immovable(sample, system, multiplier):
    """Fix what is proved immovable, if anything is; return whether so.

    ``multiplier`` is the largest of a ball or disc.
    """
    limit = SUSPECT_SHARE * multiplier
    for i in range(num_blocks(sample)):
        _suspect(block(sample, i), limit)
    for r in range(6):
        system[LAMBDA, r] = system[NU, r]
    for _ in range(2):
        _project(sample, system)
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
    fixed = False
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        if row[PENDING] < row[FREE]:
            fixed = True
            row[FREE], row[CONES] = row[PENDING], (2.0 if row[PENDING] > 0.0 else 0.0)
    return fixed


@fused
def _suspect(row, limit):
    """Propose free coordinates: none for a large multiplier of the ball, one for the disc's."""
    row[PENDING] = row[FREE]
    if row[FREE] == 0.0:
        return
    if row[FIRST_CONE + CONE + Z] >= limit:
        row[PENDING] = 0.0
    elif row[CONES] > 2.0 and row[FIRST_CONE + 2 * CONE + Z] >= limit:
        row[PENDING] = 1.0


@fused
def _along(row, system, j):
    """Coordinate j of −Gᵀλ."""
    total = 0.0
    for r in range(6):
        total -= row[COLUMNS + 6 * j + r] * system[LAMBDA, r]
    return total


@fused
def _may_differ(row, j):
    """Whether coordinate j of −Gᵀλ may differ from 0 by the proposal."""
    if row[PENDING] == row[FREE]:
        return False
    if row[CONES] == 2.0:
        return j == 0
    return j == 1 or (j == 0 and row[PENDING] == 0.0 and abs(row[V]) > PROOF_ERROR)


@fused
def _project(sample, system):
    """Make λ obey the equations: subtract what is seen by coordinates that must be 0."""
    for r in range(6):
        system[SPARE, r] = system[LAMBDA, r]
    for i in range(num_blocks(sample)):
        row = block(sample, i)
        for j in range(3):
            row[SEEING + j] = 1.0 if j < row[FREE] and not _may_differ(row, j) else 0.0
    clear_matrix(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        add_squares(sample, after(b, COLUMNS), 0, b[SEEING], b[SEEING + 1], b[SEEING + 2])
    collect_matrix(sample, system)
    for r in range(6):
        total = 0.0
        for t in range(6):
            total += system[max(r, t), min(r, t)] * system[SPARE, t]
        system[LAMBDA, r] = total
    find_pivots(system)
    solve_system(system)
    for r in range(6):
        system[LAMBDA, r] = system[SPARE, r] - system[LAMBDA, r]


@fused
def _proves(row, system, size):
    """Whether λ obeys a block's equations with μ ≥ 0; settle what of the proposal has μ > 0."""
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
