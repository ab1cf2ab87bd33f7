"""Synthesis without internal wrench where load shares need forces across the resultant, too.

A wrench h is its own manipulation wrench where the conditions of optimality hold at h_M = h: there
is a twist (a, ω), the multipliers of balance, such that with u_i = a + ω × r_i, e_i = r_i/‖r_i‖

    f_i = A_i (part of u_i along e_i) + B_i (part of u_i across e_i),  A_i ≥ B_i ≥ 0
    t_i = T_i ω,  T_i ≥ 0

(the multipliers of force ball, induced-torque disc and torque ball being what A, B and T say). The
costs w and s only bound the length of the twist from below, so that its direction is all that
matters. Resultant and shares are linear in the factors C = A − B, B and T for a given twist, and
linear in the twist for given factors. Wanted are a twist and factors that are not negative.

A step of Levenberg and Marquardt's method solves the equations linearised in both, as near to where
they are as damping asks and with no factor negative; then the factors alone, for the new twist,
where the equations are linear in truth. It starts from many twists at once. Bounds, rather than
squares, let it end where factors are 0, as they must be at the edge of what shares are possible.
"""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.synthesis import equations
from coopenv.wrench.synthesis.equations import State, TwistWish

SOLVED = 1e-12  # largest residual of a solution, relative to the wish
NEARLY = 1e-9  # the same where a wish is only approached, with factors that grow without end
STUCK = 1e4  # damping at which a system is given up
EASIER, HARDER = 0.2, 4.0  # factors of the damping after a step that helped, or did not
PATIENCE = 8  # steps in which a system must come closer
CLOSER = 0.8  # by this factor
REGULAR = 1e-15  # least damping, relative to the squares of all derivatives
MOST_CHANGES = 8  # of the set of factors that are 0, in one step


def find(
    wanted: FloatArray,
    grips: FloatArray,
    force_share: FloatArray,
    torque_share: FloatArray,
    num_starts: int,
    num_steps: int,
    seed: int,
) -> FloatArray:
    """Wrenches ``(batch, start, n, k)`` with these shares and nothing internal, NaN where none.

    Parameters
    ----------
    wanted
        Object wrenches ``(batch, 3)`` or ``(batch, 6)``, none of them 0 [N, N·m].
    grips
        ``(batch, n, 2)`` or ``(batch, n, 3)`` [m].
    force_share, torque_share
        ``(batch, n)``, rows of NaN where open.
    num_starts
        Twists to start from; the same for every sample.
    num_steps
        After which to give up.
    seed
        Of the twists.
    """
    batch, num_effectors, dimension = grips.shape
    size = wanted.shape[-1]
    length = np.linalg.norm(grips, axis=-1).max(axis=-1)
    length = np.where(length > 0.0, length, 1.0)
    units = np.ones((batch, size))
    units[:, dimension:] = length[:, None]
    units = units * np.abs(wanted / units).max(axis=-1, keepdims=True)
    shares = (force_share, torque_share)
    wish = equations.set_up(wanted / units, grips / length[:, None, None], *shares)
    wish = TwistWish(*(np.repeat(part, num_starts, axis=0) for part in wish))
    twist, factors = _solve(wish, *_starts(wish, num_starts, seed), num_steps)
    factors = factors[:, : 3 * num_effectors].reshape(-1, num_effectors, 3)
    factors = factors * wish.amount[..., None]
    applied = np.einsum("bijkl,bl,bij->bik", wish.parts, twist, factors)
    applied[..., dimension:] = factors[..., 2:] * twist[:, None, dimension:]
    return applied.reshape(batch, num_starts, num_effectors, size) * units[:, None, None]


def entries(num_effectors: int, size: int) -> int:
    """Number of derivatives in one system of equations, for wrenches ``(n, k)``."""
    return (size + 2 * num_effectors) * (size + 5 * num_effectors + 2)


def _starts(wish: TwistWish, num_starts: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Twists in all directions, and factors: alike, or for every other start of all sizes.

    No twist that would take power from the object, as every effector gives some, f_i·u_i ≥ 0.
    """
    num_effectors, size = wish.share.shape[-1], wish.wrench.shape[-1]
    rng = np.random.default_rng(seed)
    num_wishes = len(wish.wrench) // num_starts
    shape = (num_starts, 5 * num_effectors + 2)
    factors = rng.uniform(0.1, 0.6, shape)
    factors[1::2] = 10.0 ** rng.uniform(-2.0, 1.0, shape)[1::2]
    factors = np.tile(factors, (num_wishes, 1))
    twist = np.tile(rng.normal(size=(num_starts, size)), (num_wishes, 1))
    twist *= np.sqrt(size) / np.linalg.norm(twist, axis=-1, keepdims=True)
    power = (twist * wish.wrench).sum(axis=-1, keepdims=True)
    return np.where(power < 0.0, -twist, twist), factors


def _solve(
    wish: TwistWish, twist: FloatArray, factors: FloatArray, num_steps: int
) -> tuple[FloatArray, FloatArray]:
    """Run all systems until each is solved or out of steps; NaN if unsolved."""
    twists, all_factors = np.full_like(twist, np.nan), np.full_like(factors, np.nan)
    active = np.arange(len(twist))
    damping = np.full(len(twist), 1e-2)
    before = np.full(len(twist), np.inf)
    state = equations.state(wish, twist, factors)
    for step in range(num_steps + 1):
        missed = np.abs(state.residual).max(axis=-1)
        leaving = (missed <= SOLVED) | (damping > STUCK) | (step == num_steps)
        if step % PATIENCE == 0:
            length = np.linalg.norm(state.residual, axis=-1)
            leaving |= length > CLOSER * before
            before = length
        solved = leaving & (missed <= NEARLY)
        twists[active[solved]] = state.twist[solved]
        all_factors[active[solved]] = state.factors[solved]
        if leaving.any():
            keep = ~leaving
            wish, state = wish.rows(keep), state.rows(keep)
            active, damping, before = active[keep], damping[keep], before[keep]
        if not len(active):
            break
        tried = _stepped(wish, state, damping)
        state, better = _better(tried, state)
        damping = np.where(better, np.maximum(EASIER * damping, 1e-6), HARDER * damping)
    return twists, all_factors


def _stepped(wish: TwistWish, state: State, damping: FloatArray) -> State:
    """Take one step of twists and factors, and one of the factors alone."""
    size = state.twist.shape[-1]
    square = (state.residual**2).sum(axis=-1)
    bound = np.concatenate([np.full_like(state.twist, np.inf), state.factors], axis=-1)
    step = _bounded_step(state.residual, state.slope, bound, damping * square)
    twist = state.twist + step[:, :size]
    factors = np.maximum(state.factors + step[:, size:], 0.0)
    length = np.linalg.norm(twist, axis=-1, keepdims=True) / np.sqrt(size)
    factors[:, : 3 * wish.share.shape[-1]] *= length
    tried = equations.state(wish, twist / length, factors)
    step = _bounded_step(tried.residual, tried.slope[..., size:], tried.factors, square)
    factors = np.maximum(tried.factors + step, 0.0)
    return _better(equations.state(wish, tried.twist, factors), tried)[0]


def _better(one: State, other: State) -> tuple[State, BoolArray]:
    """Take whichever misses by less, and say where that is the first."""
    first = np.asarray((one.residual**2).sum(axis=-1) < (other.residual**2).sum(axis=-1))
    chosen = (
        np.where(first.reshape(-1, *[1] * (a.ndim - 1)), a, b)
        for a, b in zip(one, other, strict=True)
    )
    return State(*chosen), first


def _bounded_step(
    residual: FloatArray, slope: FloatArray, bound: FloatArray, damping: FloatArray
) -> FloatArray:
    """Steps x ≥ −bound with the smallest ‖slope x + residual‖² + damping ‖x‖².

    They are x = max(−bound, −slopeᵀ q) with damping·q = residual + slope x: linear equations for q
    once it is known where the bound holds, which Newton's method finds in a few changes.
    """
    step = np.empty_like(bound)
    damping = damping + REGULAR * (slope**2).sum(axis=(-1, -2))
    rows = np.arange(slope.shape[-2])
    free = np.ones(bound.shape, dtype=np.bool_)
    active = np.arange(len(slope))
    for _ in range(MOST_CHANGES):
        normal = (slope * free[:, None]) @ slope.swapaxes(-1, -2)
        normal[:, rows, rows] += damping[:, None]
        held = np.where(free, 0.0, bound)
        right = residual[..., None] - slope @ held[..., None]
        unbounded = -(slope.swapaxes(-1, -2) @ np.linalg.solve(normal, right))[..., 0]
        step[active] = np.maximum(unbounded, -bound)
        now_free = np.asarray(unbounded > -bound)
        changed = np.asarray((now_free != free).any(axis=-1))
        if not changed.any():
            break
        active, free, bound = active[changed], now_free[changed], bound[changed]
        residual, slope, damping = residual[changed], slope[changed], damping[changed]
    return step
