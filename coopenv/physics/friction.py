"""Coulomb friction between a body and the ground that it lies on, translation and rotation coupled.

The wrench of friction lies in the ellipsoid (Howe & Cutkosky 1996)

    ‖f‖² / F² + τ² / T² ≤ 1,    F = μ m g,    T = μ m g r̄

with r̄ the mean distance of the outline from the centre of mass: under even pressure T is the torque
that resists pure spin, and F the force that resists pure sliding. Of all in it, a sliding body
feels the one that takes most power (maximum dissipation): −(F² v, T² ω) / √(F² v² + T² ω²).

A substep solves that for the twist at its end, in one equation: friction can bring a body to rest
but never reverse it, and takes from each part of the twist.

Source: R. D. Howe and M. R. Cutkosky, "Practical force-motion models for sliding manipulation",
Int. J. Robotics Research 15 (6), 1996; the surface of limits itself is of S. Goyal, A. Ruina and
J. Papadopoulos, "Planar sliding with dry friction", Wear 143, 1991.
"""

from math import asinh, hypot

import numpy as np

from coopenv.compiled import compiled
from coopenv.physics.body import Body, Points
from coopenv.physics.scene import Scene

_ROUNDS = 30  # of Newton's method, which needs one for pure sliding and some five otherwise
_ENOUGH = 1e-14  # part of the multiplier


def held(body: Body, scene: Scene) -> tuple[float, float]:
    """The most force [N] and torque [N·m] that friction on the ground can hold."""
    if body.ground_friction == 0.0:
        return 0.0, 0.0
    force = body.ground_friction * body.mass * scene.normal_gravity
    return force, force * mean_distance(body.outline)


def mean_distance(outline: Points) -> float:
    """Mean distance of a convex outline's points from the centre of mass [m]: ∫ ‖r‖ dA / A."""
    area = total = 0.0
    for (x, y), (u, v) in zip(outline, outline[1:] + outline[:1], strict=True):
        length = hypot(u - x, v - y)
        if length == 0.0:
            continue
        doubled = abs(x * v - y * u)  # the triangle with the centre
        area += doubled / 2
        away = doubled / length  # of the edge's line from the centre
        first, last = (x * (u - x) + y * (v - y)) / length, (u * (u - x) + v * (v - y)) / length
        total += _swept(away, last) - _swept(away, first)
    return total / area


def _swept(away: float, along: float) -> float:
    """∫ ‖r‖ dA over the triangle from an edge's foot, ``away`` [m], to ``along`` it [m³]."""
    if away == 0.0:
        return 0.0
    return (away * along * hypot(away, along) + away**3 * asinh(along / away)) / 6


@compiled
def rubbed(limits, gains, step, start, path, end):
    """What friction leaves of a substep of free motion.

    Parameters
    ----------
    limits
        F [N] and T [N·m]; one of them positive.
    gains
        Velocity, path, spin and turn gained a unit of force or torque held over the substep.
    step
        Substep [s].
    start, path, end
        Twist at the start, pose change, and twist at the end without friction, world frame,
        ``(x, y, θ)`` each.

    Returns
    -------
    Pose change and twist at the end.
    """
    force, torque = limits
    speed_gain, path_gain, spin_gain, turn_gain = gains
    vx, vy, spin = end
    most, most_spin = speed_gain * force, spin_gain * torque  # what friction can take [m/s, rad/s]
    if _inside(most, most_spin, end) <= 1.0:
        part = until_rest(most, most_spin, start, end) * step / 2  # velocity falls evenly to 0
        return (part * start[0], part * start[1], part * start[2]), (0.0, 0.0, 0.0)
    multiplier = _multiplier(force, torque, most, most_spin, end)
    held = force * force / (multiplier + most * force)  # [N·s/m]
    held_spin = torque * torque / (multiplier + most_spin * torque)
    fx, fy, turning = -held * vx, -held * vy, -held_spin * spin
    dx, dy, turn = path
    left, left_spin = multiplier + most * force, multiplier + most_spin * torque
    return (
        (dx + path_gain * fx, dy + path_gain * fy, turn + turn_gain * turning),
        (multiplier / left * vx, multiplier / left * vy, multiplier / left_spin * spin),
    )


@compiled
def _inside(most, most_spin, twist):
    """A twist against what friction can take: at most 1 if it can take all of it."""
    vx, vy, spin = twist
    square = 0.0
    if vx != 0.0 or vy != 0.0:
        square += (vx * vx + vy * vy) / (most * most)
    if spin != 0.0:
        square += spin * spin / (most_spin * most_spin)
    return square


@compiled
def until_rest(most, most_spin, start, end):
    """Part of a substep, in [0, 1], after which a body is at rest that friction stops in it.

    The first σ at which what friction can take in that part is all that there is:
    ‖start + σ (end − start)‖ = σ, in the norm of `_inside`.
    """
    begins = _inside(most, most_spin, start)
    if begins == 0.0:
        return 0.0
    dx, dy, spin = end[0] - start[0], end[1] - start[1], end[2] - start[2]
    curve = _inside(most, most_spin, (dx, dy, spin)) - 1.0
    slope = (start[0] * dx + start[1] * dy) / (most * most)
    if start[2] != 0.0:
        slope += start[2] * spin / (most_spin * most_spin)
    root = np.sqrt(max(slope * slope - curve * begins, 0.0))
    return min(max(begins / (root - slope), 0.0), 1.0)


@compiled
def _multiplier(force, torque, most, most_spin, end):
    """The λ of maximum dissipation, w = −E² v' / λ, at which the wrench is on the ellipsoid.

    Σ (E_i v_i / (λ + A_i E_i²))² = 1 falls with λ from above 1; its root's inverse is nearly
    straight, and Newton's method on that rises to λ from 0.
    """
    across = force * np.hypot(end[0], end[1])  # [N·m/s]
    around = torque * abs(end[2])
    multiplier = 0.0
    for _ in range(_ROUNDS):
        a, b = multiplier + most * force, multiplier + most_spin * torque
        x = across / a if across > 0.0 else 0.0
        y = around / b if around > 0.0 else 0.0
        square = x * x + y * y
        falls = (x * x / a if across > 0.0 else 0.0) + (y * y / b if around > 0.0 else 0.0)
        change = (np.sqrt(square) - 1.0) * square / falls
        multiplier += change
        if abs(change) <= _ENOUGH * multiplier:
            break
    return max(multiplier, 0.0)
