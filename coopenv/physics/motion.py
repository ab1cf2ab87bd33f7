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
    RUBS,
    SPEED_GAIN,
    SPIN_COAST,
    SPIN_DECAY,
    SPIN_GAIN,
    TURN_GAIN,
    WHEELS,
)
from coopenv.physics.contacts import lasting
from coopenv.physics.friction import rubbed
from coopenv.physics.surroundings import add_wheels


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
    return borne(table, k, expected, lasting_part(table, k, start, expected, moved, step))


@inlined
def lasting_part(table, k, start, expected, moved, step):
    """The part of the contact that bears a body in `supported`, which writes what that lends."""
    contact = expected[k, CONTACT], expected[k, CONTACT + 1], expected[k, CONTACT + 2]
    part = 0.0
    if contact[0] != 0.0 or contact[1] != 0.0 or contact[2] != 0.0:
        forced = moved[3] - start[0], moved[4] - start[1], moved[5] - start[2]
        mean = moved[0] / step, moved[1] / step, moved[2] / step
        part = lasting(table[k, MASS], table[k, INERTIA], contact, forced, mean)
    for i in range(3):
        expected[k, LENT + i] = part * contact[i]
    return part


@inlined
def borne(table, k, expected, part):
    """Change of pose by a part of the contact of the substep before."""
    lasts = part * table[k, PATH_GAIN] / table[k, SPEED_GAIN]  # [s] path a unit of velocity
    lasts_turn = part * table[k, TURN_GAIN] / table[k, SPIN_GAIN]
    return (
        lasts * expected[k, CONTACT],
        lasts * expected[k, CONTACT + 1],
        lasts_turn * expected[k, CONTACT + 2],
    )


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
def drive(rows, table, pose, twist, wrench, step, command, expected, around, special):
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
        pose at the end if nothing is touched. The rest, what contacts did before, is read.
    around
        ``(world, 4)``: what wheels hold is added (`coopenv.physics.surroundings`).
    special
        None where no body has wheels, weight or friction, and code for them is not compiled.
    """
    for k in range(len(rows)):
        motion = Motion(
            pose[k, 2], twist[k, 0], twist[k, 1], twist[k, 2],
            wrench[k, 0], wrench[k, 1], wrench[k, 2],
        )  # fmt: skip
        if special is not None and table[k, WHEELS]:
            dx, dy, turn, vx, vy, spin = roll(table, k, motion)
            roll_on(table, k, motion, spin, step, around)
        else:
            dx, dy, turn, vx, vy, spin = advance(table, k, motion)
            moved = dx, dy, turn, vx, vy, spin
            if special is not None and table[k, HEAVY]:
                dx, dy, turn, vx, vy, spin = _fallen(table, k, motion, expected, moved, step)
            if special is not None and table[k, RUBS]:
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
