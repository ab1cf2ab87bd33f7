"""The 6×6 system of balance of force and torque, which couples the effectors; compiled.

Rows 0 to 5 of a ``system`` hold a symmetric matrix, either its lower triangle or its factors LDLᵀ.
The other rows hold vectors. Resultants that no block can make are left out when it is factorised.
Sums over the blocks grow in four lanes, in a chunk of their own, until they are collected.
"""

from coopenv.compiled import fused, fused_inlined
from coopenv.compiled.lanes.memory import TABLE_WIDTH, after
from coopenv.compiled.lanes.vectors import total, where
from coopenv.wrench.structured.blocks import ANSWER, COLUMNS, FREE, RADIUS, chunk, num_chunks
from coopenv.wrench.structured.tolerances import DEAD_PIVOT, VOID_PIVOT

ALIVE = 6  # row: 1 for resultants that some block can make, 0 for others
BALANCE = 7  # r = −Σ G g
NU, NU_STEP = 8, 9  # ν, dν
BEFORE = 10  # what stood in dν before
SYSTEM = 11  # rows in all
RESULTANT = TABLE_WIDTH * TABLE_WIDTH  # field of sums of forces and torques, behind the matrix
SCRATCH = RESULTANT + 6  # fields for passing use, the same for all chunks to stay in the cache


@fused_inlined
def sums(sample):
    """Return the fields of the chunk where sums over the blocks grow."""
    return chunk(sample, num_chunks(sample))


@fused_inlined
def clear_matrix(sample):
    """Set the sum of squares to 0."""
    for r in range(RESULTANT):
        sums(sample)[r] = 0.0


@fused_inlined
def clear_resultant(sample):
    """Set the sums of forces and torques to 0."""
    for r in range(6):
        sums(sample)[RESULTANT + r] = 0.0


@fused_inlined
def collect_matrix(sample, system):
    """Write the sum of squares to the matrix of the system."""
    for r in range(6):
        for t in range(r + 1):
            system[r, t] = total(sums(sample)[TABLE_WIDTH * r + t])


@fused_inlined
def collect_resultant(sample, system, at, sign):
    """Add the sums of forces and torques, times a sign, to a row of the system."""
    for r in range(6):
        system[at, r] += sign * total(sums(sample)[RESULTANT + r])


@fused_inlined
def add_squares(sample, columns, first, x, y, z):
    """Add G diag(x, y, z) Gᵀ of a chunk to the sum of squares.

    G is in the fields ``columns``, six a column. Its rows before ``first`` are zero.
    """
    matrix = sums(sample)
    for r in range(first, 6):
        a0, a1, a2 = columns[r] * x, columns[6 + r] * y, columns[12 + r] * z
        for t in range(first, r + 1):
            part = a0 * columns[t] + a1 * columns[6 + t] + a2 * columns[12 + t]
            matrix[TABLE_WIDTH * r + t] += part


@fused_inlined
def add_resultant(sample, i, x, y, z):
    """Add G (x, y, z) of a chunk to the sums of forces and torques."""
    b, first = chunk(sample, i), 3 * (i & 1)
    for r in range(3):
        c = COLUMNS + first + r
        sums(sample)[RESULTANT + first + r] += b[c] * x + b[c + 6] * y + b[c + 12] * z
    if first == 0:
        for r in range(3, 6):
            c = COLUMNS + r
            sums(sample)[RESULTANT + r] += b[c] * x + b[c + 6] * y + b[c + 12] * z


@fused
def mark_alive(sample, system):
    """Mark the resultants that some block can make, by the pivots of Σ G Gᵀ."""
    clear_matrix(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        x, y, z = _weights(b, 1.0)
        add_squares(sample, after(b, COLUMNS), 3 * (i & 1), x, y, z)
    collect_matrix(sample, system)
    find_pivots(system)


@fused_inlined
def _weights(b, weight):
    """Return the weight for each of the three coordinates that is free, 0 for the others."""
    some, several, all_three = b[FREE] > 0.0, b[FREE] > 1.0, b[FREE] > 2.0
    return where(some, weight, 0.0), where(several, weight, 0.0), where(all_three, weight, 0.0)


@fused_inlined
def seen(b, system, at, torque):
    """Return Gᵀx of a chunk for the x in a row of the system."""
    first = 3 if torque else 0
    x, y, z = system[at, first], system[at, first + 1], system[at, first + 2]
    c = COLUMNS + first
    y0 = b[c] * x + b[c + 1] * y + b[c + 2] * z
    y1 = b[c + 6] * x + b[c + 7] * y + b[c + 8] * z
    y2 = b[c + 12] * x + b[c + 13] * y + b[c + 14] * z
    if not torque:
        x, y, z = system[at, 3], system[at, 4], system[at, 5]
        y0 += b[c + 3] * x + b[c + 4] * y + b[c + 5] * z
        y1 += b[c + 9] * x + b[c + 10] * y + b[c + 11] * z
        y2 += b[c + 15] * x + b[c + 16] * y + b[c + 17] * z
    return y0, y1, y2


@fused
def resultant(sample, system, part, at):
    """Write −Σ G x to a row of the system; return its largest component.

    x is in three fields of every block, ``part`` and the next two.
    """
    clear_resultant(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        add_resultant(sample, i, b[part], b[part + 1], b[part + 2])
    for r in range(6):
        system[at, r] = 0.0
    collect_resultant(sample, system, at, -1.0)
    return largest_component(system, at)


@fused_inlined
def largest_component(system, at):
    """Return the largest absolute value in a row of the system."""
    largest = 0.0
    for r in range(6):
        largest = max(largest, abs(system[at, r]))
    return largest


@fused
def spread_evenly(sample, system):
    """Take the candidate answer back to Σ G g = 0, every block in proportion to ‖v‖²."""
    clear_matrix(sample)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        x, y, z = _weights(b, b[RADIUS] * b[RADIUS])
        add_squares(sample, after(b, COLUMNS), 3 * (i & 1), x, y, z)
    collect_matrix(sample, system)
    factorise_system(system)
    for _ in range(2):
        resultant(sample, system, ANSWER, NU_STEP)
        solve_system(system)
        for i in range(num_chunks(sample)):
            b = chunk(sample, i)
            x, y, z = _weights(b, b[RADIUS] * b[RADIUS])
            y0, y1, y2 = seen(b, system, NU_STEP, i & 1)
            b[ANSWER] += x * y0
            b[ANSWER + 1] += y * y1
            b[ANSWER + 2] += z * y2


@fused
def find_pivots(system):
    """Factorise a Gram matrix in place and mark the pivots that do not vanish."""
    largest = 0.0
    for r in range(6):
        system[ALIVE, r] = system[r, r]
        largest = max(largest, system[r, r])
    for r in range(6):
        least = max(DEAD_PIVOT * system[ALIVE, r], VOID_PIVOT * largest)
        system[ALIVE, r] = 1.0 if system[r, r] > least else 0.0
        _eliminate(system, r)


@fused
def factorise_system(system):
    """Factorise the matrix in place, without resultants that cannot be made."""
    for r in range(6):
        _eliminate(system, r)


@fused
def _eliminate(system, j):
    """Write column j of LDLᵀ to the lower triangle, 1/D to the diagonal; 0 for a dead pivot."""
    if not (system[ALIVE, j] > 0.0 and system[j, j] > 0.0):
        for r in range(j, 6):
            system[r, j] = 0.0
        return
    per_pivot = 1.0 / system[j, j]
    for r in range(j + 1, 6):
        part = system[r, j] * per_pivot
        for t in range(j + 1, r + 1):
            system[r, t] -= part * system[t, j]
    for r in range(j + 1, 6):
        system[r, j] *= per_pivot
    system[j, j] = per_pivot


@fused
def solve_system(system):
    """Solve L D Lᵀ x = dν and write x to dν."""
    s = system
    x0, x1, x2 = s[NU_STEP, 0], s[NU_STEP, 1], s[NU_STEP, 2]
    x3, x4, x5 = s[NU_STEP, 3], s[NU_STEP, 4], s[NU_STEP, 5]
    x1 -= s[1, 0] * x0
    x2 -= s[2, 0] * x0 + s[2, 1] * x1
    x3 -= s[3, 0] * x0 + s[3, 1] * x1 + s[3, 2] * x2
    x4 -= s[4, 0] * x0 + s[4, 1] * x1 + s[4, 2] * x2 + s[4, 3] * x3
    x5 -= s[5, 0] * x0 + s[5, 1] * x1 + s[5, 2] * x2 + s[5, 3] * x3 + s[5, 4] * x4
    x5 *= s[5, 5]
    x4 = x4 * s[4, 4] - s[5, 4] * x5
    x3 = x3 * s[3, 3] - (s[4, 3] * x4 + s[5, 3] * x5)
    x2 = x2 * s[2, 2] - (s[3, 2] * x3 + s[4, 2] * x4 + s[5, 2] * x5)
    x1 = x1 * s[1, 1] - (s[2, 1] * x2 + s[3, 1] * x3 + s[4, 1] * x4 + s[5, 1] * x5)
    tail = s[1, 0] * x1 + s[2, 0] * x2 + s[3, 0] * x3 + s[4, 0] * x4 + s[5, 0] * x5
    s[NU_STEP, 0], s[NU_STEP, 1], s[NU_STEP, 2] = x0 * s[0, 0] - tail, x1, x2
    s[NU_STEP, 3], s[NU_STEP, 4], s[NU_STEP, 5] = x3, x4, x5
