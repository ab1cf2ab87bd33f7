"""What the hands of every scripted partner do in a step, all worlds in one compiled pass."""

from math import cos, exp, sin

import numpy as np

from coopenv.chance import fraction, mixed, polar_normal
from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated, rotated_back

from ..controllers.guidance import object_wrench, triple
from .traits import (
    AWAY_TURN,
    AWAY_X,
    AWAY_Y,
    DELAY,
    EAGERNESS,
    FOLLOWS,
    FORCE_NOISE,
    GAINS,
    HEAVINESS,
    PLANS,
    ROLE,
    SHARE,
    SHARES,
    STAY,
    STRENGTH,
    TORQUE_NOISE,
)

_SWITCH, _NOISE = np.uint64(0), np.uint64(1)  # which of a step's random numbers


@compiled
def act(
    traits,
    keys,
    now,
    steps,
    wanted_twist,
    memory,
    pose,
    twist,
    twist_before,
    goal,
    applied,
    mass,
    inertia,
    linear_drag,
    angular_drag,
    outline,
    size,
    reach,
    grips,
    frame,
    limits,
    allocation,
    driven,
    dt,
):
    """Wrenches ``(world, driven, 3)`` [N, N·m], object frame; the partner's memory moves on.

    Parameters
    ----------
    traits
        ``(world, 2, NUM_TRAITS)``.
    keys
        ``(world,)`` of the episode's random numbers.
    now, steps
        ``(world,)``, changed: which row of traits holds, and steps since the episode began.
    wanted_twist
        ``(world, 3)``, changed: the motion a follower wants, world frame.
    memory
        ``(world, delay + 1, driven, 3)``, changed: its last wrenches.
    pose, twist, twist_before, goal
        ``(world, 3)``, world frame.
    applied
        ``(world, agent, 3)`` in the last step.
    mass, …, reach
        Of the objects and rooms.
    grips, frame, limits
        ``(world, agent, 2)``.
    allocation
        ``(world, agent, 3, 3)``: each agent's part of an object wrench.
    driven
        Numbers of the agents that are driven.
    dt
        Control step [s].
    """
    out, parts = np.empty((len(traits), len(driven), 3)), np.empty((grips.shape[1], 3))
    for k in range(len(traits)):
        draw = mixed(keys[k], np.uint64(steps[k]))
        now[k] = n = _row(traits, k, now[k], steps[k], draw, dt)
        role = traits[k, n, ROLE]
        load = (mass[k], inertia[k], linear_drag[k], angular_drag[k])
        here, moving = triple(pose, k), triple(twist, k)
        if role == PLANS:
            wrench = object_wrench(
                _gains(traits, k, n), here, moving, _plan(traits, k, n, goal),
                load, (size[k, 0], size[k, 1]), outline, k, reach[k],
            )  # fmt: skip
            wrench = _scaled(wrench, traits[k, n, STRENGTH])
        else:
            before = triple(twist_before, k)
            wrench = _felt(here, moving, before, applied, grips, k, driven, load, dt)
        if role == FOLLOWS:
            tastes = (traits[k, n, HEAVINESS], traits[k, n, EAGERNESS])
            wanted, wrench = _follow(
                tastes, wrench, here, moving, triple(wanted_twist, k), load, dt
            )
        else:
            wanted = moving
        wanted_twist[k, 0], wanted_twist[k, 1], wanted_twist[k, 2] = wanted
        slot = steps[k] % memory.shape[1]
        if role == SHARES:
            share = traits[k, n, SHARE]
            _carry(
                _scaled(wrench, share / (1 - share) / len(driven)), grips, driven, memory, k, slot
            )
        else:
            _give_part(wrench, allocation, frame, limits, driven, parts, memory, k, slot)
        _shake(traits[k, n, FORCE_NOISE], traits[k, n, TORQUE_NOISE], draw, memory, k, slot)
        _recall(memory, k, steps[k], int(traits[k, n, DELAY]), out)
        steps[k] += 1
    return out


@inlined
def _row(traits, k, n, step, draw, dt):
    """Which row of traits holds in this step: the other one if it is time to switch."""
    stay = traits[k, n, STAY]
    if stay > 0 and step > 0 and fraction(mixed(draw, _SWITCH)) < 1 - exp(-dt / stay):
        return 1 - n
    return n


@inlined
def _gains(traits, k, n):
    return (
        traits[k, n, GAINS],
        traits[k, n, GAINS + 1],
        traits[k, n, GAINS + 2],
        traits[k, n, GAINS + 3],
        traits[k, n, GAINS + 4],
        traits[k, n, GAINS + 5],
    )


@inlined
def _plan(traits, k, n, goal):
    return (
        goal[k, 0] + traits[k, n, AWAY_X],
        goal[k, 1] + traits[k, n, AWAY_Y],
        goal[k, 2] + traits[k, n, AWAY_TURN],
    )


@inlined
def _scaled(wrench, factor):
    return factor * wrench[0], factor * wrench[1], factor * wrench[2]


@inlined
def _felt(pose, twist, before, applied, grips, k, driven, load, dt):
    """What moved the object in the last step beside this partner, object frame: M v̇ + D v − h."""
    mass, inertia, linear_drag, angular_drag = load
    wx = mass * (twist[0] - before[0]) / dt + linear_drag * (twist[0] + before[0]) / 2
    wy = mass * (twist[1] - before[1]) / dt + linear_drag * (twist[1] + before[1]) / 2
    torque = inertia * (twist[2] - before[2]) / dt + angular_drag * (twist[2] + before[2]) / 2
    middle = pose[2] - dt * (twist[2] + before[2]) / 4  # where the object pointed in between
    x, y = rotated_back(cos(middle), sin(middle), wx, wy)
    for i in driven:
        fx, fy = applied[k, i, 0], applied[k, i, 1]
        x -= fx
        y -= fy
        torque -= grips[k, i, 0] * fy - grips[k, i, 1] * fx + applied[k, i, 2]
    return x, y, torque


@inlined
def _follow(tastes, felt, pose, twist, wanted, load, dt):
    """Let a lighter object answer what is felt; its motion, and what the real one needs for it."""
    mass, inertia, linear_drag, angular_drag = load
    heaviness, eagerness = tastes
    c, s = cos(pose[2]), sin(pose[2])
    left, gain = _response(mass, linear_drag, dt)
    push_x, push_y = rotated(c, s, felt[0], felt[1])
    vx = left * wanted[0] + gain * push_x / heaviness
    vy = left * wanted[1] + gain * push_y / heaviness
    left, gain = _response(inertia, angular_drag, dt)
    omega = left * wanted[2] + gain * felt[2] / heaviness
    fx = linear_drag * vx + mass * eagerness * (vx - twist[0])
    fy = linear_drag * vy + mass * eagerness * (vy - twist[1])
    torque = angular_drag * omega + inertia * eagerness * (omega - twist[2])
    along, across = rotated_back(c, s, fx, fy)
    return (vx, vy, omega), (along, across, torque)


@inlined
def _response(weight, drag, dt):
    """What a step leaves of a velocity, and what it adds for each unit of force."""
    left = exp(-drag / weight * dt)
    return left, ((1 - left) / drag if drag > 0 else dt / weight)


@inlined
def _give_part(wrench, allocation, frame, limits, driven, parts, memory, k, slot):
    """The driven agents' parts of an object wrench, scaled down where anybody's limit is met.

    Like `ImpedanceController`, it presumes that the others do their parts and have limits too, so
    that equal plans make equal wrenches.
    """
    x, y, torque = wrench
    largest = 1.0
    for i in range(len(parts)):
        for j in range(3):
            parts[i, j] = (
                allocation[k, i, j, 0] * x
                + allocation[k, i, j, 1] * y
                + allocation[k, i, j, 2] * torque
            )
        along, across = rotated_back(frame[k, i, 0], frame[k, i, 1], parts[i, 0], parts[i, 1])
        largest = max(largest, max(abs(along), abs(across)) / limits[k, i, 0])
        largest = max(largest, abs(parts[i, 2]) / limits[k, i, 1])
    for number in range(len(driven)):
        for j in range(3):
            memory[k, slot, number, j] = parts[driven[number], j] / largest


@inlined
def _carry(wrench, grips, driven, memory, k, slot):
    """Give each driven agent this wrench at the centre of mass, moved to its grip."""
    x, y, torque = wrench
    for number in range(len(driven)):
        i = driven[number]
        memory[k, slot, number, 0], memory[k, slot, number, 1] = x, y
        memory[k, slot, number, 2] = torque - (grips[k, i, 0] * y - grips[k, i, 1] * x)


@inlined
def _shake(force, torque, draw, memory, k, slot):
    """Add the noise of an unsteady hand, of these standard deviations [N], [N·m]."""
    if force == 0 and torque == 0:
        return
    noise = mixed(draw, _NOISE)
    for number in range(memory.shape[2]):
        for j in range(3):
            spread = force if j < 2 else torque
            key = mixed(noise, np.uint64(3 * number + j))
            memory[k, slot, number, j] += spread * polar_normal(key)


@inlined
def _recall(memory, k, step, delay, out):
    """What was right ``delay`` steps ago, nothing before the episode began."""
    then, begun = (step - delay) % memory.shape[1], step >= delay
    for number in range(memory.shape[2]):
        for j in range(3):
            out[k, number, j] = memory[k, then, number, j] if begun else 0.0
