"""Two planar effectors on one line through the centre of mass: the optimum to rounding.

Let g = (u, v) be the internal force on effector 1 in the frame of the line, −g that on effector 2.
Plausible are the g in the lens between the discs with diameters [0, f_1] and [0, −f_2]; v alone
decides the induced torques and the torque T(v) left to the effectors' pure torques, and the best u
for a given v is known in closed form. What remains is a convex function of v on an interval that
contains 0. It is cut at its kinks; the derivative at both ends of each piece says whether the
minimum lies on a kink (exact) or inside a piece (root of the derivative).

Where several answers cost the same, the one with the least pure torque Σ‖t_M‖ is taken, and pure
torques of the sign that is needed are shared in proportion to what was applied (as eq. 23 does).
The internal levels F_I and T_I can jump where costs tie, as at ±1 m with w = 0.5 and s = 0, where
torque costs the same through forces and by itself; the cost never does.

Source: Donner, Endo & Buss 2018, eqs. 17-21; the reduction to one dimension is our own.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import TINY, compiled, gufunc, inlined
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.wrench.answer import Answer, Solve
from coopenv.wrench.measures import INCLUDE_INDUCED, TORQUE_WEIGHT, cost_weights
from coopenv.wrench.pair.bracketed_root import root_of
from coopenv.wrench.pair.lens import (
    FIRST,
    LEVEL,
    SECOND,
    TIE,
    chord,
    heights_on_axis,
    heron_in_lens,
    in_frame,
    nonzero,
    remainder,
    resolution,
    vertex,
    write,
)
from coopenv.wrench.settings import Settings

ON_AXIS = 1e-12  # distance from the line that counts as rounding, relative to the longest lever
COINCIDENT = 1e-15  # distance from grip to grip that does: grips are known to some 4e-16
VANISHED = 1e-15  # a force this small, relative to the largest wrench component, has no direction


class OnAxis:
    """The solver for any number of applied wrenches at grips on a line; a `Solve`.

    Attributes
    ----------
    axes
        ``(1 or sample, 4)``: what `frame` says of the grips, where they have at most one batch
        axis; kernels that `split` have it.
    weights
        What they are told of the cost, as `cost_weights` has it.
    """

    __slots__ = ("_axis", "axes", "weights")

    def __init__(self, grips: FloatArray, settings: Settings):
        self._axis = frame(grips)
        self.axes = self._axis.reshape(-1, 4)
        self.weights = cost_weights(settings.torque_weight, settings.include_induced)

    def __call__(self, applied: FloatArray) -> Answer:
        """The manipulation wrenches."""
        axis = self._axis
        is_row_by_row = applied.ndim == 3 and axis.shape[:-1] in ((), applied.shape[:1])
        board, parts = sharing_rows(len(applied) if is_row_by_row else 0)
        if parts == 1:
            return Answer(decompose_on_axis(applied, axis, self.weights))
        manipulation = np.empty_like(applied)
        _decompose_all(board, parts, applied, self.axes, self.weights, manipulation)
        return Answer(manipulation)


def prepare(grips: FloatArray, settings: Settings) -> Solve:
    """Return the solver for any number of applied wrenches at these grips.

    Parameters
    ----------
    grips
        ``(..., 2, 2)`` for which this `applies` [m].
    settings
        Torque weight and whether induced torque is costed.
    """
    return OnAxis(grips, settings)


def applies(grips: FloatArray) -> BoolArray:
    """Whether each set of grips is two planar positions on a line through the centre of mass."""
    if grips.shape[-2:] != (2, 2):
        return np.zeros(grips.shape[:-2], dtype=np.bool_)
    longest = np.hypot(grips[..., 0], grips[..., 1]).max(axis=-1)
    first, apart = grips[..., 0, :], grips[..., 1, :] - grips[..., 0, :]
    area = np.abs(first[..., 0] * apart[..., 1] - first[..., 1] * apart[..., 0])
    distance = np.hypot(apart[..., 0], apart[..., 1])
    # the line's distance from the centre of mass is area / distance
    on_line = area <= ON_AXIS * longest * np.minimum(distance, longest)
    return np.asarray(on_line | (distance <= COINCIDENT * longest))


def frame(grips: FloatArray) -> FloatArray:
    """Direction of the line (towards the farther grip) and both signed levers ``(..., 4)`` [m].

    The columns are `COS`, `SIN`, `FIRST` and `SECOND` of `lens`.

    Grips that coincide but for rounding count as one place: their levers are the same.
    """
    length = np.hypot(grips[..., 0], grips[..., 1])
    longest = length.max(axis=-1, keepdims=True)
    farther = np.take_along_axis(grips, length.argmax(axis=-1)[..., None, None], axis=-2)
    direction = farther[..., 0, :] / np.where(longest > 0, longest, 1.0)
    direction = np.where(longest > 0, direction, [1.0, 0.0])
    lever = (grips * direction[..., None, :]).sum(axis=-1)
    lever = np.where(length <= ON_AXIS * longest, 0.0, lever)
    apart = grips[..., :1, :] - grips[..., 1:, :]
    one_place = np.hypot(apart[..., 0], apart[..., 1]) <= COINCIDENT * longest
    lever = np.where(one_place, longest, lever)
    return np.concatenate([direction, lever], axis=-1)


class Prices(NamedTuple):
    """What a unit costs."""

    force: float  # 1 − w
    induced1: float  # of v, for the torque it induces at effector 1
    induced2: float
    torque: float  # of v, for the pure torque it leaves


class Piece(NamedTuple):
    """What stays the same between two kinks of the cost."""

    low_is_1: bool  # whether the arc of effector 1 bounds the lens on the left
    high_is_1: bool  # on the right
    sign1: float  # of the force that is left to effector 1 across the line
    sign2: float
    sign_torque: float  # of the pure torque T(v)


class Case(NamedTuple):
    """All that the slope of the cost depends on, beside v."""

    forces: tuple[float, float, float, float]  # f_1 and f_2
    prices: Prices
    piece: Piece


@compiled
def _arc(v, dx, dy, side):
    """Right (side 1) or left (-1) end of a disc at height v, and the unit tangent upwards there."""
    left, right = chord(v, dx, dy)
    radius = max(0.5 * sqrt(dx * dx + dy * dy), TINY)
    tangent_x = side * (0.5 * dy - v) / radius
    tangent_y = sqrt(max(0.25 * dx * dx + v * (dy - v), 0.0)) / radius
    return (right if side > 0.0 else left), tangent_x, tangent_y


@compiled
def _direction(x, y, tangent_x, tangent_y, sign):
    """Unit vector of a force; one that vanishes does so along the tangent."""
    force = sqrt(x * x + y * y)
    per_force = 1.0 / max(force, VANISHED)
    if force > VANISHED:
        return x * per_force, y * per_force
    return sign * tangent_x, sign * tangent_y


@compiled
def _slope(v, case):
    """Derivative of the cost along the path (best u(v), v), of the sign of d cost / d v.

    Where the path runs along an arc it is taken per unit of arc length, which keeps it finite
    where the arc is level.
    """
    f1x, f1y, f2x, f2y = case.forces
    prices, piece = case.prices, case.piece
    sign1, sign2 = piece.sign1, piece.sign2
    climb = -prices.induced1 * sign1 + prices.induced2 * sign2 + prices.torque * piece.sign_torque
    across1, across2 = f1y - v, f2y + v
    for side in (1.0, -1.0):
        first = piece.high_is_1 if side > 0.0 else piece.low_is_1
        dx, dy = (f1x, f1y) if first else (-f2x, -f2y)
        u, tx, ty = _arc(v, dx, dy, side)
        e1x, e1y = _direction(f1x - u, across1, tx, ty, sign1)
        e2x, e2y = _direction(f2x + u, across2, tx, ty, sign2)
        if side * (e2x - e1x) < -LEVEL:  # the cost falls beyond the arc: the path is on it
            return prices.force * ((e2x - e1x) * tx + (e2y - e1y) * ty) + climb * ty
    along, rise = f1x + f2x, abs(across1) + abs(across2)
    length = sqrt(along * along + rise * rise)
    steepness = (rise + TINY) / (length + TINY)  # 1 where both vanish
    return prices.force * (sign2 - sign1) * steepness + climb


_root = root_of(_slope)


@compiled
def _ordered(a, b):
    return min(a, b), max(a, b)


@compiled
def _edges(forces, low, high, no_torque, a1, a2):
    """Ends and kinks of the cost in ascending order; kinks outside fall on an end."""
    k1, k2 = _ordered(min(max(no_torque, low), high), min(max(vertex(forces), low), high))
    if a1 != 0.0 and a2 != 0.0:  # then forces keep their sign across the line, and so does v
        return (low, k1, k2, high, high, high, high)
    no_f1y, no_f2y = min(max(forces[1], low), high), min(max(-forces[3], low), high)
    k3, k4 = _ordered(no_f1y, no_f2y)
    k5 = min(max(0.0, low), high)
    k1, k3 = _ordered(k1, k3)  # merge two sorted pairs,
    k2, k4 = _ordered(k2, k4)
    k2, k3 = _ordered(k2, k3)
    k4, k5 = _ordered(k4, k5)  # and let the fifth sink to its place
    k3, k4 = _ordered(k3, k4)
    k2, k3 = _ordered(k2, k3)
    k1, k2 = _ordered(k1, k2)
    return (low, k1, k2, k3, k4, k5, high)


@compiled
def _piece(forces, applied_torque, lever, v):
    """Piece of the cost that contains v."""
    f1x, f1y, f2x, f2y = forces
    low1, high1 = chord(v, f1x, f1y)
    low2, high2 = chord(v, -f2x, -f2y)
    sign1 = 1.0 if f1y - v > 0.0 else -1.0
    sign2 = 1.0 if f2y + v > 0.0 else -1.0
    sign_torque = 1.0 if applied_torque + lever * v > 0.0 else -1.0
    return Piece(low1 >= low2, high1 <= high2, sign1, sign2, sign_torque)


@compiled
def _minimise(forces, prices, applied_torque, a1, a2, low, high):
    """Minimiser v of the convex cost on [low, high]; exact where it is a kink or an end."""
    lever = a1 - a2
    edges = _edges(forces, low, high, -applied_torque / nonzero(lever), a1, a2)
    for k in range(6):
        left, right = edges[k], edges[k + 1]
        if right <= left:
            continue
        case = Case(forces, prices, _piece(forces, applied_torque, lever, 0.5 * (left + right)))
        slope_left = _slope(left, case)
        if slope_left >= 0.0:
            return left
        slope_right = _slope(right, case)
        if slope_right > 0.0:
            fine = resolution(forces, lever)
            return _root(left, slope_left, right, slope_right, case, fine)
    return high


@compiled
def _solve(forces, torques, a1, a2, w, induced):
    """Best internal force (u, v) on effector 1 and the pure torque T that remains needed."""
    lever, applied_torque = a1 - a2, torques[0] + torques[1]
    low, high = heights_on_axis(forces, torques, a1, a2)
    prices = Prices(1.0 - w, induced * w * abs(a1), induced * w * abs(a2), w * (1.0 + TIE) * lever)
    v = low
    if high > low:
        v = _minimise(forces, prices, applied_torque, a1, a2, low, high)
    return heron_in_lens(v, forces), v, remainder(applied_torque, lever * v)


@compiled
def _decompose(applied, axis, weights, manipulation):
    """Write the manipulation wrench of one sample; see `decompose_on_axis`."""
    forces, torques, scale = in_frame(applied, axis)
    w, induced = weights[TORQUE_WEIGHT], weights[INCLUDE_INDUCED]
    u, v, torque = _solve(forces, torques, axis[FIRST], axis[SECOND], w, induced)
    write(applied, axis, u, v, torques, torque, scale, manipulation)


@gufunc("(n,k),(a),(p)->(n,k)", "void(float64[:,:], float64[:], float64[:], float64[:,:])")
def decompose_on_axis(applied, axis, weights, manipulation):
    """Write the manipulation wrench of one sample.

    ``axis`` is what `frame` says of the grips, ``weights`` are those of `cost_weights`.
    """
    _decompose(applied, axis, weights, manipulation)


@inlined
def split(applied, k, axes, weights, manipulation):
    """`decompose_on_axis` of row ``k`` of a batch along one axis; ``axes`` as `OnAxis` has them."""
    _decompose(applied[k], axes[k if len(axes) > 1 else 0], weights, manipulation[k])


@compiled
def _decompose_part(start, stop, applied, axes, weights, manipulation):
    for k in range(start, stop):
        split(applied, k, axes, weights, manipulation)


@compiled
def _decompose_all(board, parts, applied, axes, weights, manipulation):
    """`decompose_on_axis` of a batch along one axis, `spread`."""
    arguments = (applied, axes, weights, manipulation)
    spread(board, parts, len(applied), _decompose_part, arguments)
