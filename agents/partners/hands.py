"""What the hands of every scripted partner do in a step, all worlds in one compiled pass."""

import numpy as np
from numba import njit

from ..guidance import NUM_GAINS, object_wrench
from .chance import fraction, mixed, normal
from .traits import (
    AWAY_X,
    DELAY,
    EAGERNESS,
    FOLLOWS,
    FORCE_NOISE,
    GAINS,
    HEAVINESS,
    PLANS,
    ROLE,
    SHARE,
    STAY,
    STRENGTH,
    TORQUE_NOISE,
)

_SWITCH, _NOISE = np.uint64(0), np.uint64(1)  # which of a step's random numbers


@njit(cache=True, nogil=True, error_model="numpy")
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
):  # pragma: no cover - compiled
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
    out = np.empty((len(traits), len(driven), 3))
    parts, plan, slots = np.empty((len(grips[0]), 3)), np.empty(3), memory.shape[1]
    for k in range(len(traits)):
        draw = mixed(keys[k], np.uint64(steps[k]))
        stay = traits[k, now[k], STAY]
        if stay > 0 and steps[k] > 0 and fraction(mixed(draw, _SWITCH)) < 1 - np.exp(-dt / stay):
            now[k] = 1 - now[k]
        row = traits[k, now[k]]
        load = (mass[k], inertia[k], linear_drag[k], angular_drag[k])
        held = memory[k, steps[k] % slots]
        if row[ROLE] == PLANS:
            for j in range(3):
                plan[j] = goal[k, j] + row[AWAY_X + j]
            x, y, torque = object_wrench(
                row[GAINS : GAINS + NUM_GAINS], pose[k], twist[k], plan,
                *load, outline[k], size[k], reach[k],
            )  # fmt: skip
            strength = row[STRENGTH]
            _give_part(
                strength * x, strength * y, strength * torque,
                allocation[k], frame[k], limits[k], driven, parts, held,
            )  # fmt: skip
            for j in range(3):
                wanted_twist[k, j] = twist[k, j]
        else:
            x, y, torque = _felt(
                pose[k], twist[k], twist_before[k], applied[k], grips[k], driven, load, dt
            )
            if row[ROLE] == FOLLOWS:
                _follow(
                    row, x, y, torque, pose[k], twist[k], load, wanted_twist[k],
                    allocation[k], frame[k], limits[k], driven, parts, held, dt,
                )  # fmt: skip
            else:
                part = row[SHARE] / (1 - row[SHARE]) / len(driven)
                _carry(part * x, part * y, part * torque, grips[k], driven, held)
                for j in range(3):
                    wanted_twist[k, j] = twist[k, j]
        _shake(row, draw, held)
        delay = int(row[DELAY])
        then, begun = (steps[k] - delay) % slots, steps[k] >= delay
        for number in range(len(driven)):
            for j in range(3):  # element by element: copies of slices take longer than all else
                out[k, number, j] = memory[k, then, number, j] if begun else 0.0
        steps[k] += 1
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _felt(pose, twist, before, applied, grips, driven, load, dt):  # pragma: no cover - compiled
    """What moved the object in the last step beside this partner, object frame: M v̇ + D v − h."""
    mass, inertia, linear_drag, angular_drag = load
    wx = mass * (twist[0] - before[0]) / dt + linear_drag * (twist[0] + before[0]) / 2
    wy = mass * (twist[1] - before[1]) / dt + linear_drag * (twist[1] + before[1]) / 2
    torque = inertia * (twist[2] - before[2]) / dt + angular_drag * (twist[2] + before[2]) / 2
    middle = pose[2] - dt * (twist[2] + before[2]) / 4  # where the object pointed in between
    c, s = np.cos(middle), np.sin(middle)
    x, y = c * wx + s * wy, c * wy - s * wx
    for i in driven:
        x -= applied[i, 0]
        y -= applied[i, 1]
        torque -= grips[i, 0] * applied[i, 1] - grips[i, 1] * applied[i, 0] + applied[i, 2]
    return x, y, torque


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(
    row, x, y, torque, pose, twist, load, wanted, allocation, frame, limits, driven, parts, out, dt
):  # pragma: no cover - compiled
    """Let a lighter object answer what is felt, and do the own part to move the real one so."""
    mass, inertia, linear_drag, angular_drag = load
    c, s = np.cos(pose[2]), np.sin(pose[2])
    felt_x, felt_y = c * x - s * y, s * x + c * y
    fx = _answered(row, 0, felt_x, twist, wanted, mass, linear_drag, dt)
    fy = _answered(row, 1, felt_y, twist, wanted, mass, linear_drag, dt)
    needed = _answered(row, 2, torque, twist, wanted, inertia, angular_drag, dt)
    _give_part(
        c * fx + s * fy, c * fy - s * fx, needed,
        allocation, frame, limits, driven, parts, out,
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def _answered(row, j, felt, twist, wanted, weight, drag, dt):  # pragma: no cover - compiled
    """Move one component of the wanted motion on, and what the object needs to move so."""
    left = np.exp(-drag / weight * dt)
    gain = (1 - left) / drag if drag > 0 else dt / weight
    wanted[j] = left * wanted[j] + gain * felt / row[HEAVINESS]
    return drag * wanted[j] + weight * row[EAGERNESS] * (wanted[j] - twist[j])


@njit(cache=True, nogil=True, error_model="numpy")
def _give_part(
    x, y, torque, allocation, frame, limits, driven, parts, out
):  # pragma: no cover - compiled
    """The driven agents' parts of an object wrench, scaled down where anybody's limit is met.

    Like `ImpedanceController`, it presumes that the others do their parts and have limits too, so
    that equal plans make equal wrenches.
    """
    largest = 1.0
    for i in range(len(parts)):
        for j in range(3):
            parts[i, j] = (
                allocation[i, j, 0] * x + allocation[i, j, 1] * y + allocation[i, j, 2] * torque
            )
        c, s = frame[i, 0], frame[i, 1]
        along, across = c * parts[i, 0] + s * parts[i, 1], c * parts[i, 1] - s * parts[i, 0]
        largest = max(largest, max(abs(along), abs(across)) / limits[i, 0])
        largest = max(largest, abs(parts[i, 2]) / limits[i, 1])
    for number in range(len(driven)):
        for j in range(3):
            out[number, j] = parts[driven[number], j] / largest


@njit(cache=True, nogil=True, error_model="numpy")
def _carry(x, y, torque, grips, driven, out):  # pragma: no cover - compiled
    """Give each driven agent this wrench at the centre of mass, moved to its grip."""
    for number in range(len(driven)):
        i = driven[number]
        out[number, 0], out[number, 1] = x, y
        out[number, 2] = torque - (grips[i, 0] * y - grips[i, 1] * x)


@njit(cache=True, nogil=True, error_model="numpy")
def _shake(row, draw, out):  # pragma: no cover - compiled
    """Add the noise of an unsteady hand."""
    if row[FORCE_NOISE] == 0 and row[TORQUE_NOISE] == 0:
        return
    noise = mixed(draw, _NOISE)
    for number in range(len(out)):
        for j in range(3):
            spread = row[FORCE_NOISE] if j < 2 else row[TORQUE_NOISE]
            out[number, j] += spread * normal(mixed(noise, np.uint64(3 * number + j)))
