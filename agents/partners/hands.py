"""The step of scripted partners, compiled: what they feel, want and give in every world."""

from math import cos, exp, sin
from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.chance import Keys, fraction, mixed, polar_normal
from coopenv.compiled import compiled, inlined
from coopenv.geometry.frames import rotated, rotated_back

from ..controllers.guidance import (
    APPROACH,
    DAMPING,
    LOOK_AHEAD,
    MARGIN,
    SPEED,
    SPIN,
    Outline,
    guiding_twist,
    object_wrench,
    triple,
)
from ..controllers.hand_motions import paced_twist
from .feeling import give_way, half_gained, lead_on, missing_motion
from .traits import (
    AWAY_TURN,
    AWAY_X,
    AWAY_Y,
    DELAY,
    EAGERNESS,
    EASING,
    FOLLOWS,
    FORCE_NOISE,
    GAINS,
    GUIDES,
    HEAVINESS,
    LEAD,
    PLANS,
    ROLE,
    SHARE,
    SHARES,
    STAY,
    STRENGTH,
    TORQUE_NOISE,
    TURN_LEAD,
    TURN_YIELDING,
    WALKS,
    YIELDING,
    YIELDS,
)

_SWITCH, _NOISE = np.uint64(0), np.uint64(1)  # which of a step's random numbers


class Mind(NamedTuple):
    """What a player keeps of the episodes under way; all but traits and keys change in a step."""

    traits: FloatArray  # (world, 2, NUM_TRAITS)
    keys: Keys  # (world,) of the episode's random numbers
    now: IntArray  # (world,) which of the two rows of traits holds
    steps: IntArray  # (world,) since the episode began
    wanted_twist: FloatArray  # (world, 3) the motion a follower wants, world frame [m/s, rad/s]
    given: FloatArray  # (world, delay + 1, driven, 3) its last wrenches, object frame [N, N·m]


class Seen(NamedTuple):
    """What is seen of all worlds, world frame but for the last two.

    Without hands there is no stretch; nobody then asks for it.
    """

    pose: FloatArray  # (world, 3) [m, rad]
    twist: FloatArray  # (world, 3) [m/s, rad/s]
    twist_before: FloatArray  # (world, 3) at the last step's begin
    goal: FloatArray  # (world, 3) [m, rad]
    ahead: FloatArray  # (world, 3) where who walks wants the object next, on the way to its plan
    applied: FloatArray  # (world, agent, 3) in the last step, object frame [N, N·m]
    stretch: FloatArray  # (world, agent, 3) from grip to reference, object frame [m, rad]


class Carried(NamedTuple):
    """The object of every world and its room; the first five as in `coopenv.conditions.Load`."""

    mass: FloatArray
    inertia: FloatArray
    linear_drag: FloatArray
    angular_drag: FloatArray
    outline: FloatArray
    reach: FloatArray  # (world,) [m] from the object's origin to its farthest vertex
    room: FloatArray  # (world, 2) [m], inner width and height
    gravity: FloatArray  # (world, 2) [m/s²], in the plane


class Held(NamedTuple):
    """The team of every world; the first three as in `coopenv.conditions.Team`."""

    grips: FloatArray
    frame: FloatArray
    limits: FloatArray
    allocation: FloatArray  # (world, agent, 3, 3), each agent's part of an object wrench
    parts_on_way: FloatArray  # (world, agent, 3, 3) likewise, where somebody walks
    driven: IntArray  # (driven,) numbers of the agents that are driven
    springs: FloatArray  # (world, agent, 4) K, κ, B and β of their hands
    fastest: FloatArray  # (world, agent, 2) speed and turn rate of their hands


@compiled
def act(mind, seen, carried, team, dt):
    """Wrenches ``(world, driven, 3)`` [N, N·m], object frame; the player's mind moves on.

    All but ``dt`` are plain tuples, which numba recognises faster than named ones; in a small batch
    that is most of a call.

    Parameters
    ----------
    mind, seen, carried, team
        The fields of `Mind`, `Seen`, `Carried` and `Held`, in their order.
    dt
        Control step [s].
    """
    # Taken apart once: a field that is read inside the loop costs a count of references each time
    traits, keys, now, steps, wanted_twist, given = mind
    pose, twist, twist_before, goal, ahead, applied, stretch = seen
    mass, inertia, linear_drag, angular_drag, outline, reach, room, gravity = carried
    grips, frame, limits, allocation, parts_on_way, driven, springs, fastest = team
    out, parts = np.empty((len(traits), len(driven), 3)), np.empty((grips.shape[1], 3))
    for k in range(len(traits)):
        draw = mixed(keys[k], np.uint64(steps[k]))
        now[k] = n = _row(traits, k, now[k], steps[k], draw, dt)
        role, slot = traits[k, n, ROLE], steps[k] % given.shape[1]
        down = gravity[k, 0], gravity[k, 1]
        load = (mass[k], inertia[k], linear_drag[k], angular_drag[k], *down)
        here, moving, before = triple(pose, k), triple(twist, k), triple(twist_before, k)

        # What the object is to be given
        wanted, walks = moving, role == WALKS
        wrench = 0.0, 0.0, 0.0
        if walks or role == PLANS:
            to = triple(ahead, k) if walks else _plan(traits, k, n, goal)
            gains = _gains(traits, k, n)
            lead = guiding_twist(
                gains, here, to, (room[k, 0], room[k, 1]), Outline(outline, k, reach[k])
            )
            dragged = moving
            if fastest.shape[1] > 0:
                dragged = lead = paced_twist(lead, here, k, grips, fastest)
            wrench = _scaled(
                object_wrench(gains, here, moving, lead, dragged, load), traits[k, n, STRENGTH]
            )
        elif role == GUIDES:
            wrench = missing_motion(
                _gains(traits, k, n), here, moving, triple(ahead, k), k, grips, fastest
            )  # no wrench yet
        elif role == YIELDS:
            wrench = half_gained(here, moving, before)  # nor here
        else:
            wrench = _felt((here, moving, before), load, applied, grips, driven, k, dt)
        if role == FOLLOWS:
            tastes = (traits[k, n, HEAVINESS], traits[k, n, EAGERNESS])
            wrench = _unloaded(wrench, here[2], load, 1 - len(driven) / len(parts))
            wanted, wrench = _follow(
                tastes, wrench, here, moving, triple(wanted_twist, k), load, dt
            )
        wanted_twist[k, 0], wanted_twist[k, 1], wanted_twist[k, 2] = wanted

        # This partner's part of it
        if role == SHARES:
            share = traits[k, n, SHARE]
            each = _scaled(wrench, share / (1 - share) / len(driven))
            _carry(each, grips, driven, given, k, slot)
        elif role in (YIELDS, GUIDES):
            _part(_weight(here[2], load), allocation, frame, limits, parts, k)
            _feel(
                traits[k, n], wrench, parts, (grips, driven, springs), stretch, given, k, slot, dt
            )
        else:
            shares = parts_on_way if walks else allocation
            largest = _part(wrench, shares, frame, limits, parts, k)
            _give(parts, largest, driven, given, k, slot)

        # An unsteady hand, and a late one
        _shake(traits[k, n, FORCE_NOISE], traits[k, n, TORQUE_NOISE], draw, given, k, slot)
        _recall(given, k, steps[k], int(traits[k, n, DELAY]), out)
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
        traits[k, n, GAINS + APPROACH],
        traits[k, n, GAINS + DAMPING],
        traits[k, n, GAINS + SPEED],
        traits[k, n, GAINS + SPIN],
        traits[k, n, GAINS + MARGIN],
        traits[k, n, GAINS + LOOK_AHEAD],
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
def _felt(motion, load, applied, grips, driven, k, dt):
    """Wrench on the object in the last step that was not this partner's: M (v̇ − g) + D v − h.

    Object frame. ``motion`` is the object's pose and twist now, and its twist one step before.
    """
    pose, twist, before = motion
    mass, inertia, linear_drag, angular_drag, down_x, down_y = load
    rate_x, rate_y = (twist[0] - before[0]) / dt - down_x, (twist[1] - before[1]) / dt - down_y
    wx = mass * rate_x + linear_drag * (twist[0] + before[0]) / 2
    wy = mass * rate_y + linear_drag * (twist[1] + before[1]) / 2
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
def _unloaded(felt, angle, load, share):
    """What is felt of the others less their even ``share`` of the weight, which moves nothing."""
    weight = load[0] * share
    x, y = rotated_back(cos(angle), sin(angle), weight * load[4], weight * load[5])
    return felt[0] + x, felt[1] + y, felt[2]


@inlined
def _follow(tastes, felt, pose, twist, wanted, load, dt):
    """Let a lighter object answer what is felt; its motion, and what the real one needs for it."""
    mass, inertia, linear_drag, angular_drag, down_x, down_y = load
    heaviness, eagerness = tastes
    c, s = cos(pose[2]), sin(pose[2])
    left, gain = _response(mass, linear_drag, dt)
    push_x, push_y = rotated(c, s, felt[0], felt[1])
    vx = left * wanted[0] + gain * push_x / heaviness
    vy = left * wanted[1] + gain * push_y / heaviness
    left, gain = _response(inertia, angular_drag, dt)
    omega = left * wanted[2] + gain * felt[2] / heaviness
    fx = linear_drag * vx + mass * (eagerness * (vx - twist[0]) - down_x)
    fy = linear_drag * vy + mass * (eagerness * (vy - twist[1]) - down_y)
    torque = angular_drag * omega + inertia * eagerness * (omega - twist[2])
    along, across = rotated_back(c, s, fx, fy)
    return (vx, vy, omega), (along, across, torque)


@inlined
def _response(weight, drag, dt):
    """What a step leaves of a velocity, and what it adds for each unit of force."""
    left = exp(-drag / weight * dt)
    return left, ((1 - left) / drag if drag > 0 else dt / weight)


@inlined
def _weight(angle, load):
    """Wrench that bears the object, object frame."""
    x, y = rotated_back(cos(angle), sin(angle), -load[0] * load[4], -load[0] * load[5])
    return x, y, 0.0


@inlined
def _feel(row, motion, weights, team, stretch, given, k, slot, dt):
    """What each hand gives that gives way, or that shows the way.

    ``motion`` is the one that the object will have gained, or that it is missing.
    """
    grips, driven, springs = team
    for number in range(len(driven)):
        i = driven[number]
        own = triple(weights, i)
        if row[ROLE] == YIELDS:
            rates = row[YIELDING], row[TURN_YIELDING]
            wrench = give_way(rates, motion, own, k, i, grips, stretch, springs, dt)
        else:
            tastes = row[LEAD], row[TURN_LEAD], row[EASING]
            wrench = lead_on(tastes, motion, own, k, i, grips, stretch, springs, dt)
        for j in range(3):
            given[k, slot, number, j] = wrench[j]


@inlined
def _part(wrench, allocation, frame, limits, parts, k):
    """Every agent's part of an object wrench into ``parts``, and how far one exceeds a limit.

    Like `ImpedanceController`, it presumes that the others do their parts and have limits too, so
    that equal plans make equal wrenches. What exceeds no limit gives 1.
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
    return largest


@inlined
def _give(parts, largest, driven, given, k, slot):
    """Give the driven agents' parts, all of them scaled down where anybody's limit is met."""
    for number in range(len(driven)):
        for j in range(3):
            given[k, slot, number, j] = parts[driven[number], j] / largest


@inlined
def _carry(wrench, grips, driven, given, k, slot):
    """Let each driven agent apply, at its grip, what equals this wrench at the centre of mass."""
    x, y, torque = wrench
    for number in range(len(driven)):
        i = driven[number]
        given[k, slot, number, 0], given[k, slot, number, 1] = x, y
        given[k, slot, number, 2] = torque - (grips[k, i, 0] * y - grips[k, i, 1] * x)


@inlined
def _shake(force, torque, draw, given, k, slot):
    """Add the noise of an unsteady hand, of these standard deviations [N], [N·m]."""
    if force == 0 and torque == 0:
        return
    noise = mixed(draw, _NOISE)
    for number in range(given.shape[2]):
        for j in range(3):
            spread = force if j < 2 else torque
            given[k, slot, number, j] += spread * polar_normal(
                mixed(noise, np.uint64(3 * number + j))
            )


@inlined
def _recall(given, k, step, delay, out):
    """Copy the wrenches of ``delay`` steps ago to ``out``; zero before the episode began."""
    then, begun = (step - delay) % given.shape[1], step >= delay
    for number in range(given.shape[2]):
        for j in range(3):
            out[k, number, j] = given[k, then, number, j] if begun else 0.0
