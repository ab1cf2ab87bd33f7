"""Synthesis for two planar effectors on one line through the centre of mass.

In the frame of the line let F be the wanted resultant force, g = (u, v) the wanted internal force
on effector 1, and p = (x, y) the manipulation force of effector 1, F − p that of effector 2. What
is wanted leaves p and one pure torque open. Where h_M is optimal for h = h_M + h_I, x is one of six
functions of y (`_path`): Heron's point; the ends where p or F − p touches its ball, p·g = 0 or
(F − p)·g = 0; what the force share says; 0; F_x. Along each, the conditions of optimality, of
plausibility and of both shares change only at certain y, which are computed (`_levels`). These and
the points between them are candidates; those that keep plausibility and shares are decomposed, and
what comes back as wanted is an answer.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.wrench.measures import cost_weights
from coopenv.wrench.pair.lens import COS, FIRST, ON_LINE
from coopenv.wrench.pair.on_axis import decompose_on_axis, frame
from coopenv.wrench.shares import load_share_kernel
from coopenv.wrench.synthesis.polynomials import product, real_roots
from coopenv.wrench.synthesis.wish import Wish, internal_miss, into_frame, out_of_frame

NUM_PATHS = 6
ALLOWED = 1e-9  # by how much a candidate may miss plausibility or shares before it is decomposed
FOUND = 1e-7  # by how much its decomposition may miss what is wanted, relative to the wrench


class PairWish(NamedTuple):
    """Wishes ``(batch, ...)`` in the frame of the line; shares are NaN where open."""

    force: FloatArray  # F (batch, 2) [N]
    torque: FloatArray  # t_o (batch,) [N·m]
    internal: FloatArray  # g (batch, 2) [N]
    internal_torque: FloatArray  # t_I (batch, 2) [N·m]
    force_share: FloatArray  # of effector 1 (batch,)
    torque_share: FloatArray  # of effector 1 (batch,)
    lever: FloatArray  # a (batch, 2) [m]
    weights: tuple[float, float]  # w, s

    def rows(self, which: BoolArray) -> "PairWish":
        """Some of the wishes."""
        return PairWish(*(part[which] for part in self[:-1]), self.weights)  # pyright: ignore


def find(wish: Wish) -> FloatArray:
    """Smallest wrenches ``(batch, 2, 3)`` found that decompose as wanted; NaN where none is.

    The grips must be two planar positions on a line through the centre of mass.
    """
    axis = frame(wish.grips)
    wanted = PairWish(
        into_frame(wish.object_wrench[:, :2], axis),
        wish.object_wrench[:, 2],
        into_frame(wish.internal[:, 0, :2], axis),
        wish.internal[..., 2],
        wish.force_share[:, 0],
        wish.torque_share[:, 0],
        axis[:, FIRST:],
        (wish.settings.torque_weight, float(wish.settings.include_induced)),
    )
    answer = _search(wanted, thorough=False)
    missing = np.isnan(answer[:, 0, 0])
    if missing.any():
        answer[missing] = _search(wanted.rows(missing), thorough=True)
    return out_of_frame(answer, axis)


def _search(wish: PairWish, thorough: bool) -> FloatArray:
    """Answers in the frame of the line; a thorough search tries more levels."""
    part = np.stack([wish.internal, -wish.internal], axis=1)
    internal = np.concatenate([part, wish.internal_torque[..., None]], axis=-1)[:, None]
    line = np.zeros((len(part), 1, 2, 2))
    line[:, 0, :, 0] = wish.lever
    with np.errstate(all="ignore"):  # a level that does not exist is NaN or infinite
        manipulation = _candidates(wish, thorough)
        applied = manipulation + internal
        good = _is_plausible(manipulation, internal, wish) & _has_shares(applied, line, wish)
    return _best(applied, internal, good, wish)


def _candidates(wish: PairWish, thorough: bool) -> FloatArray:
    """Manipulation wrenches worth trying, ``(batch, candidate, 2, 3)``."""
    fx, fy = wish.force[:, :1], wish.force[:, 1:]
    a1, a2 = wish.lever[:, :1], wish.lever[:, 1:]
    found = []
    for path in range(NUM_PATHS):
        y = _levels(path, wish, thorough)
        x = _path(path, y, wish)
        torque = wish.torque[:, None] - a1 * y - a2 * (fy - y)
        for own in _torque_splits(y, torque, wish):
            first = np.stack([x, y, own], axis=-1)
            second = np.stack([fx - x, fy - y, torque - own], axis=-1)
            found.append(np.stack([first, second], axis=-2))
    return np.concatenate(found, axis=1)


def _path(path: int, y: FloatArray, wish: PairWish) -> FloatArray:
    """X component of p at height y ``(batch, level)``, see the module's docstring."""
    fx, fy = wish.force[:, :1], wish.force[:, 1:]
    u, v = wish.internal[:, :1], wish.internal[:, 1:]
    if path == 0:
        rise = np.abs(y) + np.abs(fy - y)
        return np.where(rise > 0, fx * np.abs(y) / np.where(rise > 0, rise, 1.0), 0.5 * fx)
    if path == 1:
        return -v * y / u
    if path == 2:
        return fx + v * (fy - y) / u
    if path == 3:
        share = wish.force_share[:, None]
        return (share * (fx**2 + fy**2) - y * fy) / fx - u
    return fx * (path - 4.0) + 0.0 * y


def _torque_splits(y: FloatArray, torque: FloatArray, wish: PairWish) -> list[FloatArray]:
    """Pure torques of effector 1: all, none, in proportion to the internal ones, by share, half."""
    v, a1 = wish.internal[:, 1:], wish.lever[:, :1]
    own, both = wish.internal_torque[:, :1], wish.internal_torque.sum(axis=-1, keepdims=True)
    shared = wish.torque_share[:, None] * wish.torque[:, None] - a1 * (y + v) - own
    return [torque, 0.0 * torque, torque * (own / both), shared, 0.5 * torque]


def _levels(path: int, wish: PairWish, thorough: bool) -> FloatArray:
    """Heights y on a path where some condition changes, and heights between ``(batch, level)``."""
    fx, fy = wish.force[:, 0], wish.force[:, 1]
    a1, a2 = wish.lever[:, 0], wish.lever[:, 1]
    lever = a1 - a2
    levels = [0.0 * fy, fy, (wish.torque - a2 * fy) / lever]  # no f_M1y, no f_M2y, no torque left
    own, both = wish.internal_torque[:, 0], wish.internal_torque.sum(axis=-1)
    asked = wish.torque_share * wish.torque - a1 * wish.internal[:, 1] - own
    levels += [  # where a part of the torque makes the torque share: none, all, in proportion
        (asked - part * (wish.torque - a2 * fy)) / (a1 - part * lever)
        for part in (0.0, 1.0, own / both)
    ]
    levels += _share_levels(path, wish)
    if not thorough:
        return np.stack(levels, axis=-1)
    levels += _priced_levels(path, wish)
    sorted_levels = np.sort(np.stack(levels, axis=-1), axis=-1)  # NaN last
    sorted_levels[~np.isfinite(sorted_levels)] = np.nan
    size = 1.0 + np.abs(fx) + np.abs(fy) + np.abs(wish.internal).sum(axis=-1)
    size = size[:, None]
    between = 0.5 * (sorted_levels[:, 1:] + sorted_levels[:, :-1])
    beyond = [np.nanmin(sorted_levels, axis=-1, keepdims=True) - size]
    beyond.append(np.nanmax(sorted_levels, axis=-1, keepdims=True) + size)
    return np.concatenate([sorted_levels, between, *beyond], axis=-1)


def _share_levels(path: int, wish: PairWish) -> list[FloatArray]:
    """Where the force share is the wanted one: (x(y) + u) F_x + (y + v) F_y = α‖F‖²."""
    fx, fy = wish.force[:, 0], wish.force[:, 1]
    square = fx**2 + fy**2
    rest = wish.force_share * square - (wish.force * wish.internal).sum(axis=-1)
    if path == 0:  # a quadratic where y leaves [0, F_y], and linear inside
        half = 0.5 * (square - 2.0 * fy**2 - 2.0 * rest)
        root = np.sqrt(half**2 - 2.0 * fy**2 * rest)
        large = -half - np.copysign(root, half)
        return [rest * fy / square, large / (2.0 * fy), rest * fy / large]
    zero, one = np.zeros((len(fx), 1)), np.ones((len(fx), 1))
    at_zero = _path(path, zero, wish)[:, 0]
    slope = _path(path, one, wish)[:, 0] - at_zero
    return [(rest - at_zero * fx) / (slope * fx + fy)]


def _priced_levels(path: int, wish: PairWish) -> list[FloatArray]:
    """Where torque costs the same through forces and by itself, so that both may be in use."""
    w, induced = wish.weights
    fx, fy = wish.force[:, 0], wish.force[:, 1]
    lever1, lever2 = np.abs(wish.lever).T
    pure = w * np.abs(wish.lever[:, 0] - wish.lever[:, 1])
    if path == 0:  # both forces make the same angle with the line, its sine is known
        sine = (pure - induced * w * (lever1 + lever2)) / (2.0 * (1.0 - w))
        tangent = sine / np.sqrt(1.0 - sine**2)
        return [0.5 * (fy + np.abs(fx) * tangent), 0.5 * (fy - np.abs(fx) * tangent)]
    if path > 2:
        return []
    prices = [pure, -pure]
    if induced:
        moments = [w * (lever1 + lever2), w * (lever1 - lever2)]
        prices = [price + sign * part for price in prices for part in moments for sign in (1, -1)]
    return [level for price in prices for level in _levels_on_ball(path, price, wish)]


def _levels_on_ball(path: int, price: FloatArray, wish: PairWish) -> list[FloatArray]:
    """Stationary points on the edge of a ball, where y is worth ``price``.

    One force is ρ n, across g; the other is F − ρ n. Along the ball's tangent |g| n − ρ g/|g| the
    cost must not change: a linear function of ρ over ‖F − ρ n‖ equals another linear function.
    Squared, that is a polynomial of fourth degree.
    """
    w, _ = wish.weights
    internal = wish.internal if path == 2 else -wish.internal
    size = np.hypot(internal[:, 0], internal[:, 1])
    along = internal / size[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    force_along = (wish.force * along).sum(axis=-1)
    force_across = (wish.force * across).sum(axis=-1)
    top = np.stack([-(1.0 - w) * (force_along + size), (1.0 - w) * size * force_across], axis=-1)
    square = np.stack([0 * size + 1.0, -2.0 * force_across, (wish.force**2).sum(axis=-1)], axis=-1)
    found = []
    for sign in (1.0, -1.0):
        constant = sign * (1.0 - w) * size + price * size * across[:, 1]
        linear = np.stack([-price * along[:, 1], constant], axis=-1)
        polynomial = -product(square, product(linear, linear))
        polynomial[:, 2:] += product(top, top)
        roots = real_roots(polynomial) * across[:, 1:]
        found += list((roots if path == 1 else wish.force[:, 1:] - roots).T)
    return found


def _is_plausible(manipulation: FloatArray, internal: FloatArray, wish: PairWish) -> BoolArray:
    """Whether x_Iᵀ x_M ≥ 0 for forces, induced and pure torques (eqs. 9-11)."""
    largest = np.abs(manipulation).max(axis=(-1, -2)) + np.abs(internal).max(axis=(-1, -2))
    allowed = (ALLOWED * largest**2)[..., None]
    product = manipulation * internal
    across = (product[..., 1] >= -allowed) | (wish.lever[:, None] == 0.0)
    force = product[..., 0] + product[..., 1] >= -allowed
    good = force & across & (product[..., 2] >= -allowed)
    return np.asarray(good.all(axis=-1) & np.isfinite(manipulation).all(axis=(-1, -2)))


def _has_shares(applied: FloatArray, line: FloatArray, wish: PairWish) -> BoolArray:
    good = np.ones(applied.shape[:2], dtype=np.bool_)
    shares = load_share_kernel(np.where(np.isfinite(applied), applied, 0.0), line)
    for share, wanted in zip(shares, (wish.force_share, wish.torque_share), strict=True):
        met = np.abs(share[..., 0] - wanted[:, None]) <= FOUND
        good &= met | np.isnan(wanted)[:, None]
    return good


def _best(applied: FloatArray, internal: FloatArray, good: BoolArray, wish: PairWish) -> FloatArray:
    """Smallest candidate of each sample that decomposes as wanted, NaN where none does."""
    sample, candidate = np.nonzero(good)
    tried = applied[sample, candidate]
    axis = np.zeros((len(tried), ON_LINE))
    axis[:, COS], axis[:, FIRST:] = 1.0, wish.lever[sample]
    found = tried - decompose_on_axis(tried, axis, cost_weights(*wish.weights))
    size = np.abs(tried).max(axis=(-1, -2))
    length = np.abs(wish.lever).max(axis=-1)[sample]
    size[internal_miss(found, internal[sample, 0], tried, length) > FOUND] = np.inf
    cost = np.full(good.shape, np.inf)
    cost[sample, candidate] = size
    cost[np.isnan(cost)] = np.inf
    best = cost.argmin(axis=-1)
    rows = np.arange(len(good))
    answer = applied[rows, best]
    answer[~np.isfinite(cost[rows, best])] = np.nan
    return answer
