"""Exact planar motion of a dragged rigid body under a wrench held in the object frame.

    m v̇ = R(θ) f − d v,    J ω̇ = τ − D ω,    θ̇ = ω

The angle has a closed form; the velocity is the convolution of the turning force with the drag's
exponential. The force is taken at three Gauss–Legendre nodes and the exponential integrated exactly
between them: a force that does not turn is met exactly under any drag, and the error of one that
turns is of order ω⁶ h⁶ (rounding at the step sizes used here). All that depends only on the body
and the step is tabulated once.

A body on wheels does not slip sideways: with u its speed along its own x, e(θ) that direction,

    m u̇ = f_x − d u,    ṗ = u e(θ)

u has a closed form too, and the path is the integral of u, met exactly, times e at the same nodes.

Gravity in the plane adds m g to the force; it is constant in the world, so that it is met exactly.
Friction on the ground is in `coopenv.physics.friction`.
"""

from typing import NamedTuple

import numpy as np

from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated, rotated_back
from coopenv.physics.coefficients import (
    COAST,
    CONTACT,
    DECAY,
    FALL_PATH,
    FALL_SPEED,
    GROUND_FORCE,
    GROUND_TORQUE,
    HEAVY,
    INERTIA,
    LENT,
    MASS,
    NODE_COAST,
    NODE_PATH,
    NODE_PUSH,
    NODE_ROLL,
    NODE_SPEED,
    NODE_TURN,
    PATH_GAIN,
    REACH,
    RUBS,
    SPEED_GAIN,
    SPIN_COAST,
    SPIN_DECAY,
    SPIN_GAIN,
    TURN_GAIN,
    WHEELS,
)
from coopenv.physics.contacts import lasting, spent, yielded
from coopenv.physics.friction import rubbed
from coopenv.physics.surroundings import add_contacts, add_wheels


class Motion(NamedTuple):
    """How a body moves at the beginning of a substep, and the wrench it is under all through it."""

    angle: float  # [rad]
    vx: float  # world frame [m/s]
    vy: float
    spin: float  # [rad/s]
    fx: float  # object frame [N]
    fy: float
    torque: float  # [N·m]


@inlined
def advance(table, k, motion):
    """Pose change and twist after one substep: ``(dx, dy, dθ, vx, vy, ω)``, world frame.

    ``k`` is the world's row of the coefficient table, ``motion`` a `Motion`.
    """
    dx, dy = table[k, COAST] * motion.vx, table[k, COAST] * motion.vy
    vx, vy = table[k, DECAY] * motion.vx, table[k, DECAY] * motion.vy
    for i in range(3):
        at = _angle_at(table, k, i, motion)
        force_x, force_y = rotated(np.cos(at), np.sin(at), motion.fx, motion.fy)
        dx += table[k, NODE_PATH + i] * force_x
        dy += table[k, NODE_PATH + i] * force_y
        vx += table[k, NODE_SPEED + i] * force_x
        vy += table[k, NODE_SPEED + i] * force_y
    turn, spin = _turned(table, k, motion)
    return dx, dy, turn, vx, vy, spin


@inlined
def roll(table, k, motion):
    """`advance` for a body on wheels; of velocity and force only the parts along its x count."""
    speed, _ = rotated_back(np.cos(motion.angle), np.sin(motion.angle), motion.vx, motion.vy)
    dx, dy = 0.0, 0.0
    for i in range(3):
        at = _angle_at(table, k, i, motion)
        path = table[k, NODE_ROLL + i] * speed + table[k, NODE_PUSH + i] * motion.fx
        dx += path * np.cos(at)
        dy += path * np.sin(at)
    turn, spin = _turned(table, k, motion)
    speed = table[k, DECAY] * speed + table[k, COAST] / table[k, MASS] * motion.fx
    end = motion.angle + turn
    return dx, dy, turn, speed * np.cos(end), speed * np.sin(end), spin


@inlined
def roll_on(table, k, motion, end_spin, step, around):
    """Add what wheels hold over a free substep at whose end the spin is ``end_spin``."""
    speed, _ = rotated_back(np.cos(motion.angle), np.sin(motion.angle), motion.vx, motion.vy)
    rolling, push = (speed, motion.spin, end_spin), (motion.fx, motion.fy)
    add_wheels(table, k, rolling, push, step, around)


@inlined
def _angle_at(table, k, i, motion):
    """The angle at node ``i`` of the substep."""
    coasted = motion.angle + table[k, NODE_COAST + i] * motion.spin
    return coasted + table[k, NODE_TURN + i] * motion.torque


@inlined
def _turned(table, k, motion):
    """The change of the angle over the substep, and the spin at its end."""
    turn = table[k, SPIN_COAST] * motion.spin + table[k, TURN_GAIN] * motion.torque
    return turn, table[k, SPIN_DECAY] * motion.spin + table[k, SPIN_GAIN] * motion.torque


@inlined
def _fallen(table, k, motion, expected, moved, step):
    """What gravity adds to a substep of free motion ``moved``, with the support that lasts."""
    dx, dy, turn, vx, vy, spin = moved
    dx, dy = dx + table[k, FALL_PATH], dy + table[k, FALL_PATH + 1]
    vx, vy = vx + table[k, FALL_SPEED], vy + table[k, FALL_SPEED + 1]
    start, moved = (motion.vx, motion.vy, motion.spin), (dx, dy, turn, vx, vy, spin)
    support_x, support_y, support_turn = supported(table, k, start, expected, moved, step)
    return dx + support_x, dy + support_y, turn + support_turn, vx, vy, spin


@inlined
def supported(table, k, start, expected, moved, step):
    """Change of pose by the support that lasts, of a substep that begins with the twist ``start``.

    A contact acts at the end of a substep, after the path. Its impulse of the substep before is
    taken to bear the body over the path too, as far as `lasting` says: a body that rests does not
    sink in, only to be parted from the floor again. ``moved`` is the motion without support.
    """
    contact = expected[k, CONTACT], expected[k, CONTACT + 1], expected[k, CONTACT + 2]
    dx, dy, turn, part = 0.0, 0.0, 0.0, 0.0
    if contact[0] != 0.0 or contact[1] != 0.0 or contact[2] != 0.0:
        forced = moved[3] - start[0], moved[4] - start[1], moved[5] - start[2]
        mean = moved[0] / step, moved[1] / step, moved[2] / step
        part = lasting(table[k, MASS], table[k, INERTIA], contact, forced, mean)
        lasts = part * table[k, PATH_GAIN] / table[k, SPEED_GAIN]  # [s] path a unit of velocity
        dx, dy = lasts * contact[0], lasts * contact[1]
        turn = part * table[k, TURN_GAIN] / table[k, SPIN_GAIN] * contact[2]
    for i in range(3):
        expected[k, LENT + i] = part * contact[i]
    return dx, dy, turn


@inlined
def _rubbed(table, k, motion, moved, step):
    """What friction on the ground leaves of a substep of free motion ``moved``."""
    dx, dy, turn, vx, vy, spin = moved
    limits = table[k, GROUND_FORCE], table[k, GROUND_TORQUE]
    gains = (
        table[k, SPEED_GAIN], table[k, PATH_GAIN], table[k, SPIN_GAIN], table[k, TURN_GAIN],
    )  # fmt: skip
    start = motion.vx, motion.vy, motion.spin
    path, end = rubbed(limits, gains, step, start, (dx, dy, turn), (vx, vy, spin))
    return path[0], path[1], path[2], end[0], end[1], end[2]


@compiled
def drive(rows, table, pose, twist, wrench, step, command, expected, around):
    """Fill pymunk's buffer so that its own integrator lands where `advance` does.

    Chipmunk moves each body by its velocity, then finds contacts, then accelerates it. So the
    velocity is set to the mean over the substep and the force to what brings it to the end value.

    Parameters
    ----------
    rows
        ``(world,)`` the row each world has in pymunk's buffer.
    table
        ``(world, NUM_COEFFICIENTS)``.
    pose, twist, wrench
        ``(world, 3)``; pose and twist world frame, wrench object frame.
    step
        Substep [s].
    command
        ``(row, 6)`` written: velocity, angular velocity, force, torque.
    expected
        ``(world, 6)``, or ``(world, NUM_EXPECTED)`` where there is gravity: written, twist and
        pose at the end if nothing is touched. Of the rest, what contacts did in the substep before
        is read.
    around
        ``(world, 4)``: what wheels hold is added; see `coopenv.physics.surroundings`.
    """
    for k in range(len(rows)):
        motion = Motion(
            pose[k, 2], twist[k, 0], twist[k, 1], twist[k, 2],
            wrench[k, 0], wrench[k, 1], wrench[k, 2],
        )  # fmt: skip
        if table[k, WHEELS]:
            dx, dy, turn, vx, vy, spin = roll(table, k, motion)
            roll_on(table, k, motion, spin, step, around)
        else:
            dx, dy, turn, vx, vy, spin = advance(table, k, motion)
            if table[k, HEAVY]:
                moved = dx, dy, turn, vx, vy, spin
                dx, dy, turn, vx, vy, spin = _fallen(table, k, motion, expected, moved, step)
            if table[k, RUBS]:
                moved = dx, dy, turn, vx, vy, spin
                dx, dy, turn, vx, vy, spin = _rubbed(table, k, motion, moved, step)
        free = dx, dy, turn, vx, vy, spin
        command_to(table, k, rows[k], pose, step, free, command, expected)


@inlined
def command_to(table, k, at, pose, step, free, command, expected):
    """Write into row ``at`` of pymunk's buffer what brings world ``k``'s body where ``free`` says.

    ``free`` is as `advance` returns it; see `drive`.
    """
    dx, dy, turn, vx, vy, spin = free
    mean_x, mean_y, mean_spin = dx / step, dy / step, turn / step
    command[at, 0], command[at, 1], command[at, 2] = mean_x, mean_y, mean_spin
    command[at, 3] = table[k, MASS] * (vx - mean_x) / step
    command[at, 4] = table[k, MASS] * (vy - mean_y) / step
    command[at, 5] = table[k, INERTIA] * (spin - mean_spin) / step
    expected[k, 0], expected[k, 1], expected[k, 2] = vx, vy, spin
    expected[k, 3], expected[k, 4] = pose[k, 0] + dx, pose[k, 1] + dy
    expected[k, 5] = pose[k, 2] + turn


@compiled
def collect(rows, table, rooms, report, expected, pose, twist, impulse, shift, around):
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
    rows, table, expected
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
        if table[k, WHEELS]:  # where it heads is not as foreseen while pymunk parts what overlaps
            c, s = np.cos(at[2]), np.sin(at[2])
            rolling, _ = rotated_back(c, s, expected[k, 0], expected[k, 1])
        twist[k, 0], twist[k, 1], twist[k, 2] = at[3], at[4], at[5]
        if touched:
            push = max(table[k, MASS] * speed, table[k, INERTIA] * abs(spin) / table[k, REACH])
            mass, inertia = table[k, MASS], table[k, INERTIA]
            vx, vy = expected[k, 0], expected[k, 1]
            if table[k, WHEELS]:
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
            if table[k, HEAVY]:
                for i in range(3):
                    expected[k, CONTACT + i] = twist[k, i] - expected[k, i]
        else:
            if table[k, RUBS]:  # else rounding would let what is at rest creep
                twist[k, 0], twist[k, 1], twist[k, 2] = (
                    expected[k, 0], expected[k, 1], expected[k, 2],
                )  # fmt: skip
            if table[k, HEAVY]:
                borne = _let_go(table, k, expected, twist)
                impulse[k] += borne
                touched = borne > 0.0
        if table[k, WHEELS]:
            twist[k, 0], twist[k, 1] = rolling * c, rolling * s
        if touched or moved > 0.0:
            add_contacts(table, k, expected, pose, twist, pressed, around)
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


@compiled
def collect_and_drive(rows, table, rooms, buffers, expected, reached, wrench, step):
    """`collect` one substep and `drive` the next, in one call from Python.

    ``buffers`` are report and command, ``reached`` what `collect` writes; the rest as there.
    """
    report, command = buffers
    pose, twist, impulse, shift, around = reached
    lost = collect(rows, table, rooms, report, expected, pose, twist, impulse, shift, around)
    drive(rows, table, pose, twist, wrench, step, command, expected, around)
    return lost
