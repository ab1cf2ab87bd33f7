"""Hands that feel, compiled: how one gives way to what it feels, and how one shows the way."""

from math import cos, sin, sqrt

from coopenv.compiled import inlined
from coopenv.geometry.frames import rotated_back

from ..controllers.guidance import APPROACH, SPEED, SPIN
from ..controllers.hand_motions import paced_twist


@inlined
def give_way(rates, gained, weight, k, i, grips, stretch, springs, dt):
    """What hand i gives while it goes with its grip and away from what it feels, object frame.

    u = v − c (f − w), with v what its grip will move with in the middle of the step, which is what
    the object has ``gained`` by then (vx, vy, ω, object frame) more than now, and f what it will
    give at the step's end, going so:

        f = K (s + (u − v) dt) + B (u − v),  hence  u = v − c (K s − w) / (1 + c (B + K dt))

    with w its part ``weight`` of the object's weight and c the ``rates`` [m/s/N], [rad/s/(N·m)];
    turning likewise. Were f that of the step before, c (B + K dt / 2) > 1 would make it overshoot;
    were v that of now, it would hold back whatever speeds up.
    """
    stiff, turn_stiff = springs[k, i, 0], springs[k, i, 1]
    rate = rates[0] / (1 + rates[0] * (springs[k, i, 2] + stiff * dt))
    turn_rate = rates[1] / (1 + rates[1] * (springs[k, i, 3] + turn_stiff * dt))
    x = gained[0] - gained[2] * grips[k, i, 1] - rate * (stiff * stretch[k, i, 0] - weight[0])
    y = gained[1] + gained[2] * grips[k, i, 0] - rate * (stiff * stretch[k, i, 1] - weight[1])
    turn = gained[2] - turn_rate * (turn_stiff * stretch[k, i, 2] - weight[2])
    return _moved(k, i, stretch, springs, dt, x, y, turn)


@inlined
def half_gained(pose, twist, before):
    """What twist (vx, vy, ω), object frame, an object gains in half a step, if as in the last."""
    x, y = (twist[0] - before[0]) / 2, (twist[1] - before[1]) / 2
    x, y = rotated_back(cos(pose[2]), sin(pose[2]), x, y)
    return x, y, (twist[2] - before[2]) / 2


@inlined
def lead_on(tastes, missing, weight, k, i, grips, stretch, springs, dt):
    """What hand i gives while its reference goes on along the plan, object frame.

    The lead s of the reference over what bears the ``weight`` grows by the motion that is
    ``missing`` (vx, vy, ω, object frame), falls by itself, and is bounded:

        s ← P(s + dt (v_d − v − λ s))

    ``tastes`` are its bounds [m], [rad] and λ [1/s].
    """
    lead, turn_lead, easing = tastes
    x, y = missing[0] - missing[2] * grips[k, i, 1], missing[1] + missing[2] * grips[k, i, 0]
    stiff, turn_stiff = springs[k, i, 0], springs[k, i, 1]
    ahead_x, ahead_y = stretch[k, i, 0] - weight[0] / stiff, stretch[k, i, 1] - weight[1] / stiff
    ahead_turn = stretch[k, i, 2] - (weight[2] / turn_stiff if turn_stiff > 0 else 0.0)
    left = 1 - min(easing * dt, 1.0)
    to_x, to_y, to_turn = left * ahead_x + x * dt, left * ahead_y + y * dt, left * ahead_turn
    to_turn = min(max(to_turn + missing[2] * dt, -turn_lead), turn_lead)
    part = min(1.0, lead / max(sqrt(to_x * to_x + to_y * to_y), 1e-12))
    x, y = (part * to_x - ahead_x) / dt, (part * to_y - ahead_y) / dt
    return _moved(k, i, stretch, springs, dt, x, y, (to_turn - ahead_turn) / dt)


@inlined
def missing_motion(gains, pose, twist, ahead, k, grips, fastest):
    """Twist (vx, vy, ω), object frame, that the object lacks on its way to a point ``ahead``.

    Wanted is no more than the gains say, nor than all hands can follow.
    """
    speed, spin = gains[SPEED], gains[SPIN]
    vx, vy = gains[APPROACH] * (ahead[0] - pose[0]), gains[APPROACH] * (ahead[1] - pose[1])
    omega = min(max(gains[APPROACH] * (ahead[2] - pose[2]), -spin), spin)
    slower = min(1.0, speed / max(sqrt(vx * vx + vy * vy), 1e-12))
    vx, vy, omega = paced_twist((slower * vx, slower * vy, omega), pose, k, grips, fastest)
    x, y = rotated_back(cos(pose[2]), sin(pose[2]), vx - twist[0], vy - twist[1])
    return x, y, omega - twist[2]


@inlined
def _moved(k, i, stretch, springs, dt, x, y, turn):
    """Mean wrench of a step in which a reference goes (x, y, turn) a second beside its grip."""
    stiff, turn_stiff = springs[k, i, 0], springs[k, i, 1]
    reply, turn_reply = springs[k, i, 2] + stiff * dt / 2, springs[k, i, 3] + turn_stiff * dt / 2
    return (
        stiff * stretch[k, i, 0] + reply * x,
        stiff * stretch[k, i, 1] + reply * y,
        turn_stiff * stretch[k, i, 2] + turn_reply * turn,
    )
