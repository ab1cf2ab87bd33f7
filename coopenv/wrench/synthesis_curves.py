"""Candidates for wished-for wrenches of two planar effectors anywhere, with an internal wrench.

Let F be the wanted resultant force, g the wanted internal force on effector 1, p the manipulation
force of effector 1, F − p that of effector 2, D = r_1 − r_2. The x axis is laid along D, so that
the torque left to pure torques, T = t_o − r_2 × F − D × p, depends on y alone. Where h_M is optimal
for h = h_M + h_I there are multipliers (a, ω) with

    a + ω × r_i = k_i + μ_i E_i + ν_i N_i,  μ_i, ν_i ≥ 0, and 0 where the constraint is not active

k_i being the gradient of the cost, E_i and N_i outward normals of force ball and induced-torque
disc. Along D these equations do not contain ω. So p lies on one of a few curves: on the line where
a constraint is active; where k_1 and k_2 agree along D; or, where g = 0 or g is along a lever and
leaves more freedom, on the line that a share says. Along a curve the conditions change only at the
roots of `_events`, which are bracketed by a scan and closed in on by regula falsi. The roots, the
points between them, and a few ways to split T are the candidates.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.wrench.synthesis_planar import (
    Wish,
    cross,
    is_sensible,
    parts,
    shared_torque,
    torque_left,
    torque_share_misses,
    turned,
    with_torques,
)

NUM_POINTS = 200  # of the scan of each curve
NUM_SECANTS = 22
REACH = 1.56  # arc tangent of how far out a curve is scanned, in units of the wish
OPEN_SHARES = (0.5, 0.25, 0.75, 0.0, 1.0, -0.5, 1.5, -2.0, 3.0)  # tried where the share is open
NUM_AGREEING = 5
NOTHING = 1e-11  # an event that is 0 all along a curve is of this size


class _Curves(NamedTuple):
    """Lines p = origin + t · direction. After them come curves where k_1 and k_2 agree along D."""

    origin: FloatArray  # (curve, 2)
    direction: FloatArray  # (curve, 2)


def candidates(wish: Wish) -> FloatArray:
    """Manipulation wrenches ``(candidate, 2, 3)`` worth trying: plausible, with wanted shares."""
    with np.errstate(all="ignore"):  # a curve or an event that does not exist is NaN or infinite
        curves = _curves(wish)
        angle, curve = _stations(wish, curves)
        point = _points(wish, curves, angle, curve)
        point = point[np.isfinite(point).all(axis=-1)]
        splits = [part * torque_left(wish, point) for part in (*parts(wish), 0.5)]
        splits.append(shared_torque(wish, point))
        manipulation = with_torques(wish, point, splits).reshape(-1, 2, 3)
        good = is_sensible(wish, manipulation)
        return manipulation[good]


def everywhere(wish: Wish) -> tuple[IntArray, FloatArray]:
    """Curves and places on them, arc tangents of parameters: two grids ``(curve, point)``."""
    num_curves = len(_curves(wish).origin) + (NUM_AGREEING if wish.costs[2] else 1)
    grid = np.linspace(-REACH, REACH, NUM_POINTS)
    curve = np.repeat(np.arange(num_curves)[:, None], NUM_POINTS, axis=1)
    return curve, np.broadcast_to(grid, curve.shape)


def with_torque_share(wish: Wish, angle: FloatArray, curve: IntArray) -> FloatArray:
    """Manipulation wrenches ``(..., 2, 3)`` on curves, with torques as shared; NaN if not right."""
    point = _points(wish, _curves(wish), angle, curve)
    manipulation = with_torques(wish, point, [shared_torque(wish, point)])[..., 0, :, :]
    flat = manipulation.reshape(-1, 2, 3)
    flat[~is_sensible(wish, flat)] = np.nan
    return flat.reshape(manipulation.shape)


def _curves(wish: Wish) -> _Curves:
    force, zero, along = wish.force, np.zeros(2), np.array([1.0, 0.0])
    lines = [(zero, turned(wish.internal)), (force, turned(wish.internal))]  # balls
    lines += [(zero, wish.grips[0]), (force, wish.grips[1])]  # discs
    lines += [(zero, along), (force, along)]  # where both forces are along D
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    lines.append(_line(torque_left(wish, corners)))
    lines += [_line(miss) for miss in torque_share_misses(wish, corners)]
    square = force @ force
    shares: tuple[float, ...] = (wish.force_share,)
    if np.isnan(wish.force_share):
        shares = OPEN_SHARES
    elif wish.force_share in (0.0, 1.0):  # or beyond
        shares = (wish.force_share, *OPEN_SHARES[-4:])
    for share in shares:
        if square > 0.0:
            lines.append(((share - wish.internal @ force / square) * force, turned(force)))
        else:
            lines.append((np.array([share, 0.0]), turned(along)))
    origin, direction = (np.array(part) for part in zip(*lines, strict=True))
    return _Curves(origin, direction / np.hypot(direction[:, :1], direction[:, 1:]))


def _line(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Origin and direction of the line where a linear function is 0, from its values at corners."""
    slope = values[1:] - values[0]
    return -values[0] * slope / (slope @ slope), turned(slope)


def _points(wish: Wish, curves: _Curves, angle: FloatArray, curve: IntArray) -> FloatArray:
    """Forces p ``(..., 2)`` at arc tangents of the curves' parameters ``(...)``."""
    line = np.minimum(curve, len(curves.origin) - 1)
    point = curves.origin[line] + np.tan(angle)[..., None] * curves.direction[line]
    for kind in range(NUM_AGREEING if wish.costs[2] else 1):
        those = curve == len(curves.origin) + kind
        point[those] = _agreeing(wish, kind, angle[those])
    return point


def _agreeing(wish: Wish, kind: int, angle: FloatArray) -> FloatArray:
    """Where k_1 and k_2 agree along D: the cost does not change with x.

    Heron's point at height y; or, where the induced torques have opposite signs and a cost, where
    the directions of p and F − p differ along D by what that costs. The direction of p is given.
    """
    if kind == 0:
        y = np.tan(angle)
        above, below = np.abs(y), np.abs(wish.force[1] - y)
        return np.stack([wish.force[0] * above / (above + below), y], axis=-1)
    force_cost, _, induced_cost = wish.costs
    differ = 2.0 * induced_cost / force_cost * wish.grips[0, 1] * (1.0 if kind % 2 else -1.0)
    angle = angle * (np.pi / REACH)
    first = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    other = np.arccos(first[:, 0] - differ) * (1.0 if kind < 3 else -1.0)
    second = np.stack([np.cos(other), np.sin(other)], axis=-1)
    return (cross(wish.force, second) / cross(first, second))[:, None] * first


def _gradient_difference(wish: Wish, point: FloatArray) -> FloatArray:
    """k_1 − k_2 ``(..., 2)``."""
    force_cost, _, induced_cost = wish.costs
    difference = 0.0 * point
    for sign, grip, force in _both(wish, point):
        length = np.hypot(force[..., :1], force[..., 1:])
        side = np.sign(cross(grip, force))[..., None]
        difference += sign * (force_cost * force / length + induced_cost * side * turned(grip))
    return difference


def _events(wish: Wish, point: FloatArray) -> FloatArray:
    """Functions of p whose roots matter ``(..., event)``."""
    (_, grip1, first), (_, grip2, second) = _both(wish, point)
    difference = _gradient_difference(wish, point)
    ball1, ball2 = first - wish.internal, second + wish.internal
    disc1, disc2 = (np.broadcast_to(turned(grip), point.shape) for grip in (grip1, grip2))
    events = [difference[..., 0]]  # no multiplier needed
    lever, price = wish.grips[0, 0] - wish.grips[1, 0], wish.costs[1]
    for slope in (None, ball1, ball2, disc1, disc2):  # ω = ±w with one multiplier
        turning = difference[..., 1]
        if slope is not None:
            turning = turning - difference[..., 0] * slope[..., 1] / slope[..., 0]
        events += [turning - price * lever, turning + price * lever]
    events += [first @ wish.internal, second @ wish.internal]  # balls, discs become active
    events += [cross(grip1, first), cross(grip2, second), torque_left(wish, point)]
    for one, other in ((first, second), (ball1, ball2), (ball1, disc2), (disc1, ball2)):
        events.append(cross(one, other))  # two multipliers cease to do what one cannot
    reached = (point + wish.internal) @ wish.force
    events.append(reached - np.nan_to_num(wish.force_share) * (wish.force @ wish.force))
    return np.stack([*events, *torque_share_misses(wish, point)], axis=-1)


def _both(wish: Wish, point: FloatArray) -> tuple[tuple[float, FloatArray, FloatArray], ...]:
    return (1.0, wish.grips[0], point), (-1.0, wish.grips[1], wish.force - point)


def _stations(wish: Wish, curves: _Curves) -> tuple[FloatArray, IntArray]:
    """Arc tangents of parameters at the roots of all events and between them, and their curves."""
    which, grid = everywhere(wish)
    value = _events(wish, _points(wish, curves, grid, which))
    sign = np.where(np.abs(value) > NOTHING, np.sign(value), 0.0)
    curve, place, event = np.nonzero(sign[:, 1:] * sign[:, :-1] < 0.0)
    last, before = grid[curve, place], grid[curve, place + 1]
    last_value, value = value[curve, place, event], value[curve, place + 1, event]
    for _ in range(NUM_SECANTS):  # the Illinois variant of regula falsi
        middle = last - last_value * (before - last) / (value - last_value)
        middle = np.where(np.isfinite(middle), middle, last)
        found = _events(wish, _points(wish, curves, middle, curve))[np.arange(len(event)), event]
        beyond: BoolArray = found * last_value < 0.0
        value = np.where(beyond, last_value, 0.5 * value)
        before = np.where(beyond, last, before)
        last, last_value = middle, found
    angles, owners = [], []
    for k in range(len(which)):
        roots = np.unique(last[curve == k])
        edges = np.concatenate([[-REACH], roots, [REACH]])
        angles += [roots, 0.5 * (edges[1:] + edges[:-1])]
        owners.append(np.full(2 * len(roots) + 1, k))
    return np.concatenate(angles), np.concatenate(owners)
