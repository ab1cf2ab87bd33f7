"""Coefficients of a body's motion over a substep, and columns of what kernels keep of it.

All of `coopenv.physics.motion` that depends only on body, scene and step is tabulated once, a row a
world.
"""

import numpy as np
from numpy.polynomial.legendre import leggauss

from coopenv.arrays import BoolArray, FloatArray

_NODES = (1 + np.array([-np.sqrt(3 / 5), 0.0, np.sqrt(3 / 5)])) / 2
_FINE, _FINE_WEIGHTS = (1 + leggauss(64)[0]) / 2, leggauss(64)[1] / 2  # integrates the table

# Columns of the coefficient table, one row a world.
DECAY, COAST, SPIN_DECAY, SPIN_COAST = 0, 1, 2, 3  # what is left of v, ω; path a unit of it covers
SPIN_GAIN, TURN_GAIN = 4, 5  # ω and θ gained a unit of torque
NODE_COAST, NODE_TURN = 6, 9  # the angle at each node, a unit of ω and of torque
NODE_SPEED, NODE_PATH = 12, 15  # velocity and path gained a unit of force, by node
MASS, INERTIA, WHEELS, REACH = 18, 19, 20, 21
HEAVY, RUBS = 22, 23  # whether there is gravity in the plane, and friction on the ground
SPECIAL = [WHEELS, HEAVY, RUBS]  # what most bodies have not, and kernels for these cannot do
FALL_SPEED, FALL_PATH = 24, 26  # velocity and path gained by gravity, x and y each
SPEED_GAIN, PATH_GAIN = 28, 29  # velocity and path gained a unit of force that does not turn
GROUND_FORCE, GROUND_TORQUE = 30, 31  # the most that friction on the ground can hold [N, N·m]
NUM_COEFFICIENTS = 32

# Columns of what is expected of a substep: twist and pose if nothing is touched, and two that only
# bodies with weight have: what contacts made of the twist in the substep before, and the part of it
# that the path counts on.
CONTACT, LENT = 6, 9
NUM_EXPECTED = 12

# On wheels, in place of NODE_SPEED and NODE_PATH: path a unit of speed, and of force, by node.
NODE_ROLL, NODE_PUSH = NODE_SPEED, NODE_PATH


def coefficients(
    mass: FloatArray,
    inertia: FloatArray,
    linear_drag: FloatArray,
    angular_drag: FloatArray,
    step: float,
    wheels: BoolArray | None = None,
    reach: FloatArray | None = None,
    gravity: FloatArray | None = None,
    ground: FloatArray | None = None,
) -> FloatArray:
    """Tabulate the motion over one substep of ``step`` seconds, ``(world, NUM_COEFFICIENTS)``.

    ``wheels`` ``(world,)`` marks the bodies that do not slip sideways. ``reach`` ``(world,)`` [m],
    the longest lever of a contact, is for `collect`. ``gravity`` ``(world, 2)`` [m/s²] is that in
    the plane, ``ground`` ``(world, 2)`` [N, N·m] the most that friction on the ground can hold;
    neither is for bodies on wheels.
    """
    rate, spin_rate = linear_drag / mass, angular_drag / inertia  # [1/s]
    table = np.empty((len(mass), NUM_COEFFICIENTS))
    table[:, DECAY] = np.exp(-rate * step)
    table[:, COAST] = _coasted(rate, step)
    table[:, SPIN_DECAY] = np.exp(-spin_rate * step)
    table[:, SPIN_COAST] = _coasted(spin_rate, step)
    table[:, SPIN_GAIN] = _coasted(spin_rate, step) / inertia
    table[:, TURN_GAIN] = _pushed(spin_rate, step) / inertia
    table[:, WHEELS] = rolls = np.zeros(len(mass), dtype=np.bool_) if wheels is None else wheels
    # A slipping body's force at a fine point acts over the rest of the substep, `left`; a rolling
    # one's speed there is what decayed or grew over the part before it, `gone`.
    left, gone = step * (1 - _FINE), step * _FINE  # [s]
    time = np.where(rolls[:, None], gone, left)  # (world, fine point)
    decayed = np.exp(-rate[:, None] * time)
    coasted = _coasted(rate[:, None], time)
    weight = np.where(rolls, 1.0, mass)
    for i, node in enumerate(_NODES):
        others = np.delete(_NODES, i)
        share = np.prod((_FINE[:, None] - others) / (node - others), axis=1)  # Lagrange polynomial
        table[:, NODE_COAST + i] = _coasted(spin_rate, node * step)
        table[:, NODE_TURN + i] = _pushed(spin_rate, node * step) / inertia
        weights = share * _FINE_WEIGHTS  # not by @, whose rounding depends on the number of worlds
        table[:, NODE_SPEED + i] = (decayed * weights).sum(axis=1) * step / weight
        table[:, NODE_PATH + i] = (coasted * weights).sum(axis=1) * step / mass
    table[:, MASS], table[:, INERTIA] = mass, inertia
    table[:, REACH] = np.inf if reach is None else reach
    pulled = np.zeros((len(mass), 2)) if gravity is None else gravity
    held = np.zeros((len(mass), 2)) if ground is None else ground
    table[:, HEAVY], table[:, RUBS] = (pulled != 0).any(axis=1), (held > 0).any(axis=1)
    pushed = _pushed(rate, step)
    table[:, FALL_SPEED : FALL_SPEED + 2] = table[:, COAST, None] * pulled
    table[:, FALL_PATH : FALL_PATH + 2] = pushed[:, None] * pulled
    table[:, SPEED_GAIN], table[:, PATH_GAIN] = table[:, COAST] / mass, pushed / mass
    table[:, GROUND_FORCE : GROUND_TORQUE + 1] = held
    return table


def _coasted(rate: FloatArray, time: float | FloatArray) -> FloatArray:
    """Path of a unit velocity that decays: ∫₀ᵗ exp(−rate·s) ds [s]."""
    slow = rate * time < 1e-12
    return np.where(slow, time, -np.expm1(-rate * time) / np.where(slow, 1, rate))


def _pushed(rate: FloatArray, time: float) -> FloatArray:
    """Path under a unit acceleration held for ``time``: ∫₀ᵗ ∫₀ˢ exp(−rate·u) du ds [s²]."""
    x = rate * time
    series = time**2 * (1 / 2 - x / 6 + x**2 / 24 - x**3 / 120 + x**4 / 720)
    near = x < 1e-2
    return np.where(near, series, (time - _coasted(rate, time)) / np.where(near, 1, rate))
