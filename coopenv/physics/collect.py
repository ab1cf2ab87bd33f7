"""Collect: what came of a substep in pymunk, and what contacts did to each body in it."""

import numpy as np

from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated_back
from coopenv.physics.coefficients import CONTACT, HEAVY, INERTIA, LENT, MASS, REACH, RUBS, WHEELS
from coopenv.physics.contacts import spent, yielded
from coopenv.physics.surroundings import add_contacts


@compiled
def collect(rows, table, rooms, report, expected, pose, twist, impulse, shift, around, special):
    """Read pymunk's buffer back and add up what contacts did to each body.

    The impulse of a substep is the least total of contact impulses that explains the change of
    momentum p and of angular momentum L against the free motion: max(‖Δp‖, |ΔL| / reach) [N·s].
    The weight of a body that rests is in it.
    A body on wheels takes of the contacts what `yielded` says: its velocity stays along its x. No
    body takes more of them than `spent` says: contacts give no energy.

    pymunk parts what overlaps by moving the body apart from its velocity, in the substep after it
    found the overlap: no momentum, so no impulse. The shift of a substep is how far that moved the
    farthest of the body's points, at most: ‖Δ position‖ + reach · |Δ angle| against the free path
    [m]. Wheels may be shifted sideways.

    Parameters
    ----------
    rows, table, expected, special
        As in `drive`.
    rooms
        ``(world, 4)`` [m]: the origin of each world in pymunk's space, and how far from it along x
        and y a body may be.
    report
        ``(row, 6)``: position, angle, velocity, angular velocity.
    pose, twist, impulse, shift, around
        ``(world, 3)`` twice, ``(world,)`` twice and ``(world, 4)``, written; the last three are
        added. ``around`` is what `coopenv.physics.surroundings` says, object frame.

    Returns
    -------
    A world whose body is farther from its origin than it may be, or −1.
    """
    lost = -1
    for k in range(len(rows)):
        at = report[rows[k]]
        origin_x, origin_y, farthest_x, farthest_y = rooms[k]
        pose[k, 0], pose[k, 1], pose[k, 2] = at[0] - origin_x, at[1] - origin_y, at[2]
        moved = _shifted(table, k, at, expected, pose)
        shift[k] += moved
        dx, dy, spin = at[3] - expected[k, 0], at[4] - expected[k, 1], at[5] - expected[k, 2]
        speed = np.sqrt(dx * dx + dy * dy)
        rounding = 1e-12 * (1 + abs(at[3]) + abs(at[4]) + abs(at[5]))
        c, s, rolling, pressed = 1.0, 0.0, 0.0, 0.0
        touched = speed > rounding or abs(spin) > rounding
        if special is not None and table[k, WHEELS]:
            # Where it heads is not as foreseen while pymunk parts what overlaps
            c, s = np.cos(at[2]), np.sin(at[2])
            rolling, _ = rotated_back(c, s, expected[k, 0], expected[k, 1])
        twist[k, 0], twist[k, 1], twist[k, 2] = at[3], at[4], at[5]
        if touched:
            push = max(table[k, MASS] * speed, table[k, INERTIA] * abs(spin) / table[k, REACH])
            mass, inertia = table[k, MASS], table[k, INERTIA]
            vx, vy = expected[k, 0], expected[k, 1]
            if special is not None and table[k, WHEELS]:
                along, pressed = rotated_back(c, s, dx, dy)
                along, spin, factor = yielded(mass, inertia, along, dx, dy, spin)
                push, pressed = factor * push, factor * mass * pressed
                vx, vy, dx, dy = rolling, 0.0, along, 0.0  # along its x and across
            part = spent(mass, inertia, (vx, vy, expected[k, 2]), (dx, dy, spin))
            if part < 1 or table[k, WHEELS]:
                twist[k, 0], twist[k, 1] = vx + part * dx, vy + part * dy
                twist[k, 2] = expected[k, 2] + part * spin
                rolling = twist[k, 0]
            impulse[k] += part * push
            pressed *= part
            if special is not None and table[k, HEAVY]:
                for i in range(3):
                    expected[k, CONTACT + i] = twist[k, i] - expected[k, i]
        else:
            if special is not None and table[k, RUBS]:  # else rounding lets what is at rest creep
                twist[k, 0], twist[k, 1], twist[k, 2] = (
                    expected[k, 0], expected[k, 1], expected[k, 2],
                )  # fmt: skip
            if special is not None and table[k, HEAVY]:
                borne = _let_go(table, k, expected, twist)
                impulse[k] += borne
                touched = borne > 0.0
        if table[k, WHEELS]:
            twist[k, 0], twist[k, 1] = rolling * c, rolling * s
        if touched or moved > 0.0:
            add_contacts(table, k, expected, pose, twist, pressed, around, special)
        if not (abs(pose[k, 0]) <= farthest_x and abs(pose[k, 1]) <= farthest_y):  # or NaN
            lost = k
    return lost


@inlined
def _let_go(table, k, expected, twist):
    """End the contact of the substep before, and return the impulse [N·s] that the path had of it.

    What bore the body over the path acted, so that the body feels it once more: else it would be
    as fast as one that fell, and higher.
    """
    dx, dy, spin = expected[k, LENT], expected[k, LENT + 1], expected[k, LENT + 2]
    for i in range(3):
        twist[k, i] += expected[k, LENT + i]
        expected[k, CONTACT + i] = 0.0
    push = table[k, MASS] * np.sqrt(dx * dx + dy * dy)
    return max(push, table[k, INERTIA] * abs(spin) / table[k, REACH])


@inlined
def _shifted(table, k, at, expected, pose):
    """How far the body was moved off its free path [m], 0 where rounding explains it."""
    dx, dy, turn = (
        pose[k, 0] - expected[k, 3],
        pose[k, 1] - expected[k, 4],
        pose[k, 2] - expected[k, 5],
    )
    rounding = 1e-13 * (1 + abs(at[0]) + abs(at[1]) + abs(at[2]))
    moved = 0.0
    if abs(dx) > rounding or abs(dy) > rounding:
        moved += np.sqrt(dx * dx + dy * dy)
    if abs(turn) > rounding:
        moved += table[k, REACH] * abs(turn)
    return moved
