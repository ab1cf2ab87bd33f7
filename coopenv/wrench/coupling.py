"""The one small system that couples the effectors: balance of force and torque, compiled.

Whatever the number of effectors, it is of size 6: rows 0 to 5 of ``system`` hold a symmetric
matrix, its lower triangle or its factors LDLᵀ. What no block can make is left out of it.
"""

from coopenv.wrench.blocks import ANSWER, COLUMNS, FREE, RADIUS
from coopenv.wrench.second_order import compiled

ALIVE, BALANCE, NU, NU_STEP, SPARE = 6, 7, 8, 9, 10  # rows below: what can be made, r, ν, dν
SYSTEM = 11  # rows in all
DEAD = 1e-11  # pivot of Σ G Gᵀ, relative to its diagonal, below which a resultant cannot be made
VOID = 1e-26  # the same, relative to the largest


@compiled
def mark_alive(k, system):
    """Mark the resultants that some block can make: pivots of Σ G Gᵀ that do not vanish."""
    clear(system)
    for i in range(k.shape[0]):
        for j in range(int(k[i, FREE])):
            add_square(system, k[i], COLUMNS + 6 * j, 3 * (i & 1), 1.0)
    find_pivots(system)


@compiled
def resultant(k, system, part):
    """Write r = −Σ G x for a part x of the blocks; return its largest component."""
    for r in range(6):
        system[BALANCE, r] = 0.0
    for i in range(k.shape[0]):
        for j in range(int(k[i, FREE])):
            for r in range(3 * (i & 1), 6):
                system[BALANCE, r] -= k[i, COLUMNS + 6 * j + r] * k[i, part + j]
    largest = 0.0
    for r in range(6):
        largest = max(largest, abs(system[BALANCE, r]))
    return largest


@compiled
def spread_evenly(k, system):
    """Take the candidate answer back to G g = 0, every block in proportion to the square of ‖v‖."""
    clear(system)
    for i in range(k.shape[0]):
        for j in range(int(k[i, FREE])):
            add_square(system, k[i], COLUMNS + 6 * j, 3 * (i & 1), k[i, RADIUS] * k[i, RADIUS])
    factorise_system(system)
    for _ in range(2):
        resultant(k, system, ANSWER)
        for r in range(6):
            system[NU_STEP, r] = system[BALANCE, r]
        solve_system(system)
        for i in range(k.shape[0]):
            for j in range(int(k[i, FREE])):
                step = 0.0
                for r in range(3 * (i & 1), 6):
                    step += k[i, COLUMNS + 6 * j + r] * system[NU_STEP, r]
                k[i, ANSWER + j] += step * k[i, RADIUS] * k[i, RADIUS]


@compiled
def clear(system):
    """Set the matrix to 0."""
    for r in range(6):
        for t in range(6):
            system[r, t] = 0.0


@compiled
def add_square(system, row, at, first, weight):
    """Add weight·ccᵀ to the matrix, for the column c that lies in the row from ``at`` on."""
    for r in range(first, 6):
        part = weight * row[at + r]
        for t in range(first, r + 1):
            system[r, t] += part * row[at + t]


@compiled
def find_pivots(system):
    """Factorise a Gram matrix in place and mark its pivots that do not vanish."""
    largest = 0.0
    for r in range(6):
        system[ALIVE, r] = system[r, r]
        largest = max(largest, system[r, r])
    for r in range(6):
        least = max(DEAD * system[ALIVE, r], VOID * largest)
        system[ALIVE, r] = 1.0 if system[r, r] > least else 0.0
        _eliminate(system, r)


@compiled
def factorise_system(system):
    """Factorise the matrix in place, without what cannot be made."""
    for r in range(6):
        _eliminate(system, r)


@compiled
def _eliminate(system, j):
    """One column of LDLᵀ in the lower triangle, 1/D on the diagonal; 0 for a dead pivot."""
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


@compiled
def solve_system(system):
    """Solve for dν in place."""
    for r in range(6):
        for t in range(r):
            system[NU_STEP, r] -= system[r, t] * system[NU_STEP, t]
    for r in range(6):
        system[NU_STEP, r] *= system[r, r]
    for r in range(5, -1, -1):
        for t in range(r + 1, 6):
            system[NU_STEP, r] -= system[t, r] * system[NU_STEP, t]
