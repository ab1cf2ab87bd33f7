"""Displacement of a step: how far a body turned, and its mean twist along its own axes."""

import numpy as np

from coopenv.compiled import inlined
from coopenv.geometry.frames import rotated_back

_SMALL = 0.5  # [rad] turn below which series replace quotients that cancel; they err by 1e-13 there


@inlined
def turned(angle, spin, next_angle, next_spin, dt):
    """How far a body turned in a step [rad], all the way round where the spins say so.

    Angles may be wrapped.
    """
    turn = next_angle - angle
    rounds = (dt * (spin + next_spin) / 2 - turn) * (0.5 / np.pi)
    return turn + 2 * np.pi * np.floor(rounds + 0.5)


@inlined
def mean_twist(pose, twist, next_pose, next_twist, k, dt):
    """Mean over a step of the velocity of the centre of mass and the spin, object frame.

    (1/dt) ∫ (R(θ)ᵀ v, ω) dt, whose product with a wrench that is held in the object frame is the
    mean of its power. It is read from the ends of the step: exact where the body turns evenly and
    its velocity changes evenly, and with an error of order dt⁴ where both are smooth. In a step
    with an impact it is off by up to (turn / 12) ‖Δv‖.

    Parameters
    ----------
    pose, twist, next_pose, next_twist
        ``(world, 3)`` each, at the beginning and at the end, world frame; angles may be wrapped.
    k
        Index of the world.
    dt
        Of the step [s].

    Returns
    -------
    Three numbers [m/s, m/s, rad/s].
    """
    angle, spin, next_spin = pose[k, 2], twist[k, 2], next_twist[k, 2]
    turn = turned(angle, spin, next_pose[k, 2], next_spin, dt)
    rate = 1 / dt
    vx, vy = rate * (next_pose[k, 0] - pose[k, 0]), rate * (next_pose[k, 1] - pose[k, 1])
    dvx, dvy = next_twist[k, 0] - twist[k, 0], next_twist[k, 1] - twist[k, 1]
    even, odd = _means(turn)
    angle = angle + turn / 2 - dt * (next_spin - spin) * (1 / 12)  # its mean over the step
    x, y = rotated_back(np.cos(angle), np.sin(angle), even * vx + odd * dvy, even * vy - odd * dvx)
    return x, y, rate * turn


@inlined
def _means(turn):
    """Means of cos(turn · s) and of s sin(turn · s) over s from −1/2 to 1/2."""
    square = turn * turn
    if square < _SMALL * _SMALL:
        even = -1 / 24 + square * (1 / 1920 + square * (-1 / 322560 + square / 92897280))
        odd = 1 / 12 + square * (-1 / 480 + square * (1 / 53760 - square / 11612160))
        return 1 + square * even, turn * odd
    sine, cosine = np.sin(turn / 2), np.cos(turn / 2)
    return 2 * sine / turn, (2 * sine / turn - cosine) / turn
