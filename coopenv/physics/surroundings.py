"""What walls, obstacles and wheels give a body in a step, and where the sum of it acts.

Contacts are read off the motion: a body that nothing touches would have moved as
`coopenv.physics.motion` says, and what it did instead is an impulse P and an angular impulse L
about the centre of mass,

    P = m Δv + d Δp,    L = J Δω + D Δθ

with Δ the difference from the free motion. The second terms are the drag that the body met where
contacts bore it or parted it from what it overlapped: so the impulses of agents and surroundings,
the weight, and the drag of the way that was really gone explain all change of momentum. Wheels hold
the velocity along the heading; across it they give m ω u − f_y, and what contacts press on them.
"""

import numpy as np

from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated_back
from coopenv.physics.coefficients import (
    COAST,
    DECAY,
    HEAVY,
    INERTIA,
    LENT,
    MASS,
    NODE_COAST,
    NODE_PUSH,
    NODE_ROLL,
    PATH_GAIN,
    SPEED_GAIN,
    SPIN_COAST,
    SPIN_DECAY,
    SPIN_GAIN,
    TURN_GAIN,
    WHEELS,
)

# Columns of what surroundings give: all of it, object frame, and what of it wheels give across.
WHEEL, NUM_GIVEN = 3, 4


@inlined
def add_wheels(table, k, rolling, push, step, around):
    """Add what wheels give over a free substep: ∫ (m ω u − f_y) dt, which has no torque.

    Parameters
    ----------
    table, k
        Coefficients, and the world's row.
    rolling
        Speed along the heading, and the spin, at the start; the spin at the end [m/s, rad/s].
    push
        Force along and across the heading [N].
    step
        Substep [s].
    around
        ``(world, NUM_GIVEN)`` added to [N·s, N·m·s].
    """
    speed, spin, end_spin = rolling
    along, across = push
    turned = 0.0  # ∫ ω u dt, at the nodes of the path
    for i in range(3):
        path = table[k, NODE_ROLL + i] * speed + table[k, NODE_PUSH + i] * along
        gone = table[k, NODE_COAST + i] / table[k, SPIN_COAST]  # of the change of the spin
        turned += path * (spin + gone * (end_spin - spin))
    held = table[k, MASS] * turned - step * across
    around[k, 1] += held
    around[k, WHEEL] += held


@inlined
def add_contacts(table, k, expected, pose, twist, pressed, around, special):
    """Add what contacts give in a substep, and wheels because of them.

    Parameters
    ----------
    table, k, around
        As in `add_wheels`.
    expected, special
        Free motion, and what kinds of bodies there are, as `coopenv.physics.motion.drive` has them.
    pose, twist
        ``(world, 3)`` at the end, world frame.
    pressed
        What contacts gave across the heading of a body on wheels [N·s].
    """
    mass, inertia = table[k, MASS], table[k, INERTIA]
    c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])
    dx, dy = twist[k, 0] - expected[k, 0], twist[k, 1] - expected[k, 1]
    x, y = rotated_back(c, s, mass * dx, mass * dy)
    torque = inertia * (twist[k, 2] - expected[k, 2])
    if special is not None and table[k, WHEELS]:
        around[k, WHEEL] += y - pressed
    dx, dy, turn = (
        pose[k, 0] - expected[k, 3],
        pose[k, 1] - expected[k, 4],
        pose[k, 2] - expected[k, 5],
    )
    if special is not None and table[k, HEAVY]:
        # The free path is told with what a lasting contact bore the body
        lasts = table[k, PATH_GAIN] / table[k, SPEED_GAIN]
        dx, dy = dx + lasts * expected[k, LENT], dy + lasts * expected[k, LENT + 1]
        turn += table[k, TURN_GAIN] / table[k, SPIN_GAIN] * expected[k, LENT + 2]
    drag = mass * (1.0 - table[k, DECAY]) / table[k, COAST]  # [N·s/m]
    spin_drag = inertia * (1.0 - table[k, SPIN_DECAY]) / table[k, SPIN_COAST]  # [N·m·s]
    dx, dy = rotated_back(c, s, drag * dx, drag * dy)
    around[k, 0] += x + dx
    around[k, 1] += y + dy
    around[k, 2] += torque + spin_drag * turn


@compiled
def acting(wrench, wheel_force, outline):
    """Where the surroundings' wrench acts, as that of one effector that grips there.

    A contact has no torque of its own: its line of action enters the outline, which is convex and
    which no wall pulls at, where it touches. That place is taken for the sum of all contacts.
    Wheels hold at the centre of mass. Where both give something, the place is that on the line of
    action of their sum that is nearest to the mean of the two, weighted by the forces.

    Only what torque no force along that direction makes at the outline is torque of its own, as
    when two walls hold a body by its ends.

    Parameters
    ----------
    wrench
        ``(world, 3)`` at the centre of mass, object frame [N, N·m].
    wheel_force
        ``(world,)`` of the wheels, along the object's y [N].
    outline
        ``(world, vertex, 2)`` convex, object frame [m].

    Returns
    -------
    The wrench at its place ``(world, 3)``, and the place ``(world, 2)``, object frame.
    """
    there, place = np.zeros(wrench.shape), np.zeros((len(wrench), 2))
    for k in range(len(wrench)):
        fx, fy, torque = wrench[k, 0], wrench[k, 1], wrench[k, 2]
        there[k, 0], there[k, 1], there[k, 2] = fx, fy, torque
        square = fx * fx + fy * fy
        if square == 0.0:
            continue
        x = y = 0.0
        touch_y = fy - wheel_force[k]
        touched, rolled = np.hypot(fx, touch_y), abs(wheel_force[k])
        if touched > 0.0:
            x, y = _entered(outline[k], fx, touch_y, torque)
            part = touched / (touched + rolled)
            x, y = part * x, part * y
        least, most = _reached(outline[k], fx, fy)
        made = min(max(torque, least), most)
        away = (made - (x * fy - y * fx)) / square
        place[k, 0], place[k, 1] = x + away * fy, y - away * fx
        there[k, 2] = torque - made
    return there, place


@inlined
def _reached(outline, fx, fy):
    """Least and most torque that a force at the outline has [N·m]."""
    least, most = np.inf, -np.inf
    for j in range(len(outline)):
        torque = outline[j, 0] * fy - outline[j, 1] * fx
        least, most = min(least, torque), max(most, torque)
    return least, most


@inlined
def _entered(outline, fx, fy, torque):
    """Where the line on which a force has a torque enters the outline, or comes nearest to it."""
    least, most = _reached(outline, fx, fy)
    torque = min(max(torque, least), most)
    x = y = 0.0
    first = np.inf
    for j in range(len(outline)):
        ax, ay = outline[j - 1, 0], outline[j - 1, 1]
        bx, by = outline[j, 0], outline[j, 1]
        a, b = ax * fy - ay * fx, bx * fy - by * fx
        if a == b or torque < min(a, b) or torque > max(a, b):
            continue  # the ends of an edge along the force are ends of others too
        part = (torque - a) / (b - a)
        px, py = ax + part * (bx - ax), ay + part * (by - ay)
        along = px * fx + py * fy
        if along < first:
            first, x, y = along, px, py
    return x, y
