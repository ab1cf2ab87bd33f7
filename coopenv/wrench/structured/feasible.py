"""Feasible answers from iterates of the structured solver: balanced and in every ball; compiled."""

import numpy as np

from coopenv.compiled import TINY, fused, fused_inlined
from coopenv.compiled.lanes.vectors import (
    larger,
    largest,
    size,
    smaller,
    smallest,
    splat,
    where,
)
from coopenv.wrench.structured.balance import (
    NU_STEP,
    largest_component,
    resultant,
    seen,
    solve_system,
    spread_evenly,
)
from coopenv.wrench.structured.blocks import ANSWER, CONES, FREE, RADIUS, V, chunk, num_chunks
from coopenv.wrench.structured.bound import leaving, products, saving
from coopenv.wrench.structured.newton import under_hessian
from coopenv.wrench.structured.tolerances import (
    BALANCE_ROUNDING,
    NO_DIRECTION,
    TORQUE_EXCESS,
)


@fused
def settle(sample, system, part, excess, balanced):
    """Make a balanced answer in every ball of the g at ``part``; return what it saves, J(h) − J.

    The last Newton system takes g back to balance. Where that fails, every block takes a part in
    proportion to ‖v‖² (`spread_evenly`). Then all are shrunk by one factor θ, which keeps the
    balance, until no ball is left by more than ``excess``: ‖θg‖² ≤ θ g·v. What then misses balance
    by more than ``balanced`` is no answer and saves −∞.
    """
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for j in range(3):
            b[ANSWER + j] = b[part + j]

    # balance
    missed = _missed(sample, system)
    for _ in range(6):
        if missed <= BALANCE_ROUNDING:
            break
        _balance(sample, system)
        missed = _missed(sample, system)
    if not largest_component(system, NU_STEP) <= balanced:
        spread_evenly(sample, system)
        if not resultant(sample, system, ANSWER, NU_STEP) <= balanced:
            return -np.inf

    # shrink into the balls
    room = splat(1.0)
    for i in range(num_chunks(sample)):
        room = smaller(_room(chunk(sample, i), excess), room)
    shrink = smallest(room)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for j in range(3):
            b[ANSWER + j] *= shrink
    return saving(sample, ANSWER)


@fused
def clear(sample):
    """Make the applied wrench the answer: nothing is internal."""
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        for j in range(3):
            b[ANSWER + j] = 0.0


@fused
def fit(sample):
    """Shrink each torque of the answer that leaves its ball by more than a trifle of itself.

    It leaves the ball by no more than `EXCESS` or `LOOSE_EXCESS`, which balance hardly notices.
    """
    for i in range(1, num_chunks(sample), 2):
        b = chunk(sample, i)
        inner, square = products(b)
        inner, square = inner + b[ANSWER] * b[V], square + b[ANSWER] * b[ANSWER]
        room = _room_of(inner, square, b[RADIUS], TORQUE_EXCESS * b[RADIUS], TINY)
        for j in range(3):
            b[ANSWER + j] *= room


@fused
def _missed(sample, system):
    """Write −Σ G g of the candidate to dν; return the largest, relative to the largest of g."""
    resultant(sample, system, ANSWER, NU_STEP)
    force, torque = splat(0.0), splat(0.0)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        own = larger(larger(size(b[ANSWER]), size(b[ANSWER + 1])), size(b[ANSWER + 2]))
        own = where(b[FREE] > 0.0, own, 0.0)
        if i & 1:
            torque = larger(own, torque)
        else:
            force = larger(own, force)
    unit = largest(force)
    missed = 0.0
    for r in range(6):
        if r == 3:
            unit = max(unit, largest(torque))
        missed = max(missed, abs(system[NU_STEP, r]) / max(unit, TINY))
    return missed


@fused
def _balance(sample, system):
    """Add H⁻¹ Gᵀ M⁻¹ r to the candidate, which takes it back to Σ G g = 0; r is in dν."""
    solve_system(system)
    for i in range(num_chunks(sample)):
        b = chunk(sample, i)
        x, y, z = under_hessian(b, *seen(b, system, NU_STEP, i & 1))
        b[ANSWER] += x
        b[ANSWER + 1] += y
        b[ANSWER + 2] += z


@fused_inlined
def _room(b, excess):
    """Return the largest θ ≤ 1 for which θ times the candidate is in ball and disc."""
    inner, square = products(b)
    whole = square + b[ANSWER] * b[ANSWER]
    room = _room_of(inner + b[ANSWER] * b[V], whole, b[RADIUS], excess, NO_DIRECTION)
    in_disc = _room_of(inner, square, 0.5 * size(b[V + 1]), excess, NO_DIRECTION)
    return smaller(room, where(b[CONES] > 2.0, in_disc, 1.0))


@fused_inlined
def _room_of(inner, square, radius, excess, noise):
    """Return the largest θ ≤ 1 for one ball from g·v and ‖g‖²; 1 where that is only ``noise``."""
    outside = leaving(inner, square, radius) > excess
    return where((square > noise) & outside, larger(inner, 0.0) / larger(square, TINY), 1.0)
