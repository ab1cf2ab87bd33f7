"""Candidates for the manipulation force of a planar pair, where h_M is optimal for h = h_M + h_I.

With p, F − p, g and D as in `planar`, e_1 and e_2 the directions of p and F − p, b the price of
torque in units of that of force, and ω = ±b by the sign of the torque that is left, the conditions
of optimality are

    e_1 − e_2 + b (±(r_1 turned) − ±(r_2 turned)) + active constraints = ω (D turned)

the second term only if induced torque has a cost. An active constraint puts p on a line, as g is
known: p·g = 0 and (F − p)·g = 0 for the balls, r_1 × p = 0 and r_2 × (F − p) = 0 for the discs,
T = 0 where ω is free. So p is the crossing of two lines; or on one line, at the roots of a
polynomial; or on none, where e_1 and e_2 are known. Where g = 0, g is along a lever or nobody could
supply more torque, the conditions leave more freedom; then p is where shares, or one condition
less, say.
"""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.synthesis.polynomials import product, real_roots

ALONG = 1e-9  # sine of an angle that counts as none
POLISH = 3  # Newton steps on a root of the equation whose square was solved


class PlanarWish(NamedTuple):
    """Wishes ``(batch, ...)`` in their own units, D along x: no force or lever is much above 1."""

    force: FloatArray  # F (batch, 2)
    torque: FloatArray  # t_o (batch,)
    internal: FloatArray  # g (batch, 2)
    internal_torque: FloatArray  # t_I (batch, 2)
    force_share: FloatArray  # of effector 1 (batch,), NaN where open
    torque_share: FloatArray  # (batch,)
    grips: FloatArray  # (batch, 2, 2)
    price: FloatArray  # of torque, that of force being 1 (batch,)
    include_induced: bool


class _Lines(NamedTuple):
    """Lines p = origin + t · direction, some of them NaN."""

    origin: FloatArray  # (batch, line, 2)
    direction: FloatArray  # (batch, line, 2), of length 1


def points(wish: PlanarWish) -> FloatArray:
    """Forces p ``(batch, m, 2)`` worth trying; NaN or infinite where one does not exist."""
    lines, balances = _lines(wish), _balances(wish)
    ends = np.stack([0.0 * wish.force, wish.force], axis=1)
    found = [ends, _crossings(lines), _unconstrained(wish, balances)]
    found += _where_one_condition_holds(wish, lines, balances)
    for side in (0, 1):
        found += [_on_disc(wish, balances, side), _on_ball(wish, balances, side)]
    return np.concatenate([each.reshape(len(ends), -1, 2) for each in found], axis=1)


def torque_left(wish: PlanarWish, point: FloatArray) -> FloatArray:
    """T ``(batch, m)``, what is left to pure torques at forces p ``(batch, m, 2)``."""
    own = wish.torque - cross(wish.grips[:, 1], wish.force)
    return own[:, None] - cross((wish.grips[:, 0] - wish.grips[:, 1])[:, None], point)


def keeping(wish: PlanarWish) -> list[FloatArray]:
    """Parts of T ``(batch,)`` that effector 1 may supply: none, all, in proportion to its own."""
    own, other = wish.internal_torque.T
    both = np.where(own * other > 0.0, own + other, 1.0)
    return [0.0 * own, 0.0 * own + 1.0, np.where(own * other > 0.0, own / both, 0.5)]


def cross(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return one × other, the component across the plane."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def _turned(vector: FloatArray) -> FloatArray:
    """By a right angle."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    return (one * other).sum(axis=-1)


def _length(vector: FloatArray) -> FloatArray:
    return np.hypot(vector[..., 0], vector[..., 1])


def _lines(wish: PlanarWish) -> _Lines:
    """Lines on which a constraint is active, no torque is left, a share is met, or p is along F."""
    force, zero = wish.force, 0.0 * wish.force
    found = [(zero, _turned(wish.internal)), (force, _turned(wish.internal))]
    found += [(zero, wish.grips[:, 0]), (force, wish.grips[:, 1]), (zero, force)]
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    left = torque_left(wish, corners)
    found.append(_line(left))
    asked = wish.torque_share * wish.torque - wish.internal_torque[:, 0]
    induced = cross(wish.grips[:, None, 0], corners + wish.internal[:, None])
    found += [_line(induced + part[:, None] * left - asked[:, None]) for part in keeping(wish)]
    reached = wish.force_share - _dot(wish.internal, force) / _dot(force, force)
    found.append((reached[:, None] * force, _turned(force)))
    origin, direction = (np.stack(part, axis=1) for part in zip(*found, strict=True))
    return _Lines(origin, direction / _length(direction)[..., None])


def _line(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where linear functions are 0, from their values ``(batch, 3)`` at (0, 0), (1, 0), (0, 1)."""
    slope = values[:, 1:] - values[:, :1]
    return -values[:, :1] * slope / _dot(slope, slope)[:, None], _turned(slope)


def _crossings(lines: _Lines) -> FloatArray:
    one, other = np.triu_indices(lines.origin.shape[1], 1)
    along = lines.direction[:, other]
    reach = cross(lines.origin[:, other] - lines.origin[:, one], along)
    reach = reach / cross(lines.direction[:, one], along)
    return lines.origin[:, one] + reach[..., None] * lines.direction[:, one]


def _balances(wish: PlanarWish) -> FloatArray:
    """What e_1 − e_2 is where no constraint is active, for all signs of torques ``(batch, k, 2)``.

    First those where the induced torques have the same sign, or no cost.
    """
    first, second = (_turned(wish.grips[:, k]) for k in (0, 1))
    lever, price = first - second, wish.price[:, None]
    if not wish.include_induced:
        return np.stack([price * lever, -price * lever], axis=1)
    signs = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)]
    return np.stack(
        [
            price * (omega * lever - one * first + other * second)
            for one, other in signs
            for omega in (1.0, -1.0)
        ],
        axis=1,
    )


def _unconstrained(wish: PlanarWish, balances: FloatArray) -> FloatArray:
    """The p for which e_1 − e_2 is as the prices say, two of them."""
    across = np.sqrt(1.0 / _dot(balances, balances) - 0.25)[..., None] * _turned(balances)
    middle = np.stack([across, -across])
    first, second = middle + 0.5 * balances, middle - 0.5 * balances
    size = cross(wish.force[:, None], second) / cross(first, second)
    return np.moveaxis(size[..., None] * first, 0, 1)


def _on_disc(wish: PlanarWish, balances: FloatArray, side: int) -> FloatArray:
    """Forces along the lever of one effector, as the price along the lever says."""
    lever = wish.grips[:, side] / _length(wish.grips[:, side])[:, None]
    along, across = _dot(wish.force, lever), np.abs(cross(wish.force, lever))
    price = _dot(balances, lever[:, None]) * (1.0, -1.0)[side]
    other = np.stack([-1.0 - price, 1.0 - price])  # part of the other's direction along the lever
    own = along[:, None] - other * across[:, None] / np.sqrt(1.0 - other * other)
    found = own[..., None] * lever[:, None]
    return np.moveaxis(wish.force[:, None] - found if side else found, 0, 1)


def _on_ball(wish: PlanarWish, balances: FloatArray, side: int) -> FloatArray:
    """Forces p = t n across g, with (±n − b − e_2) × (p − g) = 0, for effector 2 likewise."""
    sign = -1.0 if side else 1.0
    internal, force = sign * wish.internal[:, None], wish.force[:, None]
    across = _turned(internal) / _length(internal)[..., None]
    rest = np.stack([across - sign * balances, -across - sign * balances], axis=-2)
    internal, force, across = internal[:, None], force[:, None], across[:, None]
    # (F − t n) × (t n − g) = (rest × (t n − g)) ‖F − t n‖
    left = [cross(force, across) + cross(across, internal), -cross(force, internal)]
    left = np.stack(left, axis=-1)
    right = np.stack([cross(rest, across), -cross(rest, internal)], axis=-1)
    constant = _dot(force, force)
    length = np.stack([constant**0, -2.0 * _dot(force, across), constant], axis=-1)
    square = -product(product(right, right), length)
    square[..., 2:] += product(left, left)
    root = _polished(real_roots(square), left, right, length)
    found = root[..., None] * across[..., None, :]
    return force[..., None, :] - found if side else found


def _polished(
    root: FloatArray, left: FloatArray, right: FloatArray, length: FloatArray
) -> FloatArray:
    """Newton steps on left(t) − right(t) √length(t), as far as they help."""

    def equation(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        factor = right[..., :1] * t + right[..., 1:]
        size = np.sqrt(np.maximum((t + length[..., 1:2]) * t + length[..., 2:], 0.0))
        slope = left[..., :1] - right[..., :1] * size
        slope = slope - factor * (t + 0.5 * length[..., 1:2]) / size
        return left[..., :1] * t + left[..., 1:] - factor * size, slope

    for _ in range(POLISH):
        miss, slope = equation(root)
        better = root - miss / slope
        root = np.where(np.abs(equation(better)[0]) < np.abs(miss), better, root)
    return root


def _where_one_condition_holds(
    wish: PlanarWish, lines: _Lines, balances: FloatArray
) -> list[FloatArray]:
    """Where on a line e_1 − e_2 is as the prices say along one axis, being free across it.

    That is D where ω is free; a lever where g is along it, as then its disc is always active.
    """
    along = np.broadcast_to([1.0, 0.0], wish.force.shape)
    differ = balances[:, 4::2, 0] if wish.include_induced else balances[:, :0, 0]
    found = [_alike(wish, lines, along), _differing(wish, lines, along, differ)]
    for grip in (wish.grips[:, 0], wish.grips[:, 1]):
        size = _length(grip) * _length(wish.internal)
        rows = np.flatnonzero(np.abs(cross(grip, wish.internal)) <= ALONG * size)
        if not len(rows):
            continue
        some = wish._replace(force=wish.force[rows])
        part = _Lines(lines.origin[rows], lines.direction[rows])
        lever = grip[rows] / _length(grip[rows])[:, None]
        differ = _dot(balances[rows], lever[:, None])
        there = _differing(some, part, lever, differ)
        point = np.full((len(grip), *there.shape[1:]), np.nan)
        point[rows] = there
        found.append(point)
    return found


def _parts(
    wish: PlanarWish, lines: _Lines, axis: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Parts of p and F − p along an axis and the squares of their lengths, as polynomials in t."""
    origin, direction = lines
    rest, axis = wish.force[:, None] - origin, axis[:, None]
    own = np.stack([_dot(direction, axis), _dot(origin, axis)], axis=-1)
    other = np.stack([-_dot(direction, axis), _dot(rest, axis)], axis=-1)
    one = 0.0 * own[..., 0] + 1.0
    length = np.stack([one, 2.0 * _dot(origin, direction), _dot(origin, origin)], axis=-1)
    beyond = np.stack([one, -2.0 * _dot(rest, direction), _dot(rest, rest)], axis=-1)
    return own, other, length, beyond


def _alike(wish: PlanarWish, lines: _Lines, axis: FloatArray) -> FloatArray:
    """Where on lines e_1 and e_2 are alike along an axis, x/‖p‖ = x'/‖F − p‖ (or F = 0 = x)."""
    own, other, length, beyond = _parts(wish, lines, axis)
    square = product(product(own, own), beyond) - product(product(other, other), length)
    root = real_roots(square[..., 1:])  # the highest powers cancel
    root = np.concatenate([root, -own[..., 1:] / own[..., :1]], axis=-1)
    return lines.origin[:, :, None] + root[..., None] * lines.direction[:, :, None]


def _differing(wish: PlanarWish, lines: _Lines, axis: FloatArray, differ: FloatArray) -> FloatArray:
    """Where on lines e_1 − e_2 is ``differ`` ``(batch, k)`` along an axis."""
    own, other, length, beyond = (part[:, :, None] for part in _parts(wish, lines, axis))
    one, two = product(product(own, own), beyond), product(product(other, other), length)
    both = product(length, beyond)
    middle = one + two - differ[:, None, :, None] ** 2 * both
    root = real_roots(product(middle, middle) - 4.0 * product(one, two))
    place = root.reshape(*root.shape[:2], -1, 1)
    return lines.origin[:, :, None] + place * lines.direction[:, :, None]
