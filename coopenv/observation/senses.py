"""What a hand feels: wrench and stretch at its grip, the grip's motion, and what it accelerates by.

All are along the agent's own axes; those of the end of the step, but for the acceleration.
"""

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.geometry.displacement import turned
from coopenv.geometry.frames import rotated_back
from coopenv.observation.block import Block
from coopenv.transition import Transition


def _felt_wrench(transition: Transition) -> FloatArray:
    """What a sensor at the grip reads at the end; a wrench that is held is the same all through."""
    felt = transition.felt_wrench
    return along_own_axes(transition.applied if felt is None else felt, transition.team.frame)


def _stretch(transition: Transition) -> FloatArray:
    return along_own_axes(of_hands(transition.stretch, "stretch"), transition.team.frame)


def _own_motion(transition: Transition) -> FloatArray:
    team, state = transition.team, transition.next_state
    return grip_motion(state.pose, state.twist, team.grips, team.frame)


def _acceleration(transition: Transition) -> FloatArray:
    team, before, after = transition.team, transition.state, transition.next_state
    ends = before.pose, before.twist, after.pose, after.twist
    gravity = transition.conditions.room.gravity
    return specific_force(ends, team.grips, team.frame, gravity, transition.dt)


SENSES = (
    Block(
        name="felt_wrench",
        size=3,
        describe="force and torque that a sensor at this agent's grip reads at the end of the step",
        read=_felt_wrench,
        unit="N, N, N·m",
        frame="agent",
    ),
    Block(
        name="stretch",
        size=3,
        describe="from the grip to the hand's reference, and the angle between them",
        read=_stretch,
        unit="m, m, rad",
        frame="agent",
        needs_hands=True,
    ),
    Block(
        name="own_motion",
        size=3,
        describe="velocity of this agent's grip, and its spin",
        read=_own_motion,
        unit="m/s, m/s, rad/s",
        frame="agent",
    ),
    Block(
        name="acceleration",
        size=2,
        describe="specific force at this agent's grip, mean over the step, as an inertial unit "
        "reads it: change of the grip's velocity by time, less gravity",
        read=_acceleration,
        unit="m/s²",
        frame="agent",
    ),
)


def of_hands(value: FloatArray | None, what: str) -> FloatArray:
    """``value``, which is ``None`` where no hands carry out the actions; then `InvalidInput`."""
    if value is None:
        raise InvalidInput(
            f"{what} must be read where hands carry out the actions, got a step without them; "
            "choose action='motion' or 'impedance'"
        )
    return value


@compiled
def along_own_axes(vectors, frame):
    """Vectors of each agent, x, y and a turn ``(world, agent, 3)``, from object to agent frame."""
    num_worlds, num_agents = frame.shape[:2]
    seen = np.empty((num_worlds, num_agents, 3))
    for k in range(num_worlds):
        for i in range(num_agents):
            seen[k, i, 0], seen[k, i, 1] = rotated_back(
                frame[k, i, 0], frame[k, i, 1], vectors[k, i, 0], vectors[k, i, 1]
            )
            seen[k, i, 2] = vectors[k, i, 2]
    return seen


@compiled
def grip_motion(pose, twist, grips, frame):
    """Velocity of each agent's grip and spin, ``(world, agent, 3)`` [m/s, rad/s], agent frame.

    ``pose`` and ``twist`` ``(world, 3)`` in the world frame, ``grips`` and ``frame``
    ``(world, agent, 2)`` of the team.
    """
    num_worlds, num_agents = frame.shape[:2]
    seen = np.empty((num_worlds, num_agents, 3))
    for k in range(num_worlds):
        c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        vx, vy = rotated_back(c, s, twist[k, 0], twist[k, 1])
        spin = twist[k, 2]
        for i in range(num_agents):
            grip_vx, grip_vy = vx - spin * grips[k, i, 1], vy + spin * grips[k, i, 0]
            seen[k, i, 0], seen[k, i, 1] = rotated_back(
                frame[k, i, 0], frame[k, i, 1], grip_vx, grip_vy
            )
            seen[k, i, 2] = spin
    return seen


@compiled
def specific_force(ends, grips, frame, gravity, dt):
    """What an accelerometer at each grip reads, mean over the step.

    a_i = R_i(θ̄)ᵀ ((ṗ_i − ṗ_i,before) / dt − g), with ṗ_i the velocity of the grip in the world, g
    gravity in the plane and R_i(θ̄) agent i's axes in the middle of the turn. Impulses of contacts
    are in it. At rest it is what bears the unit, −g, and in free fall 0. After a reset, which
    nothing led to, it reads as at rest.

    Parameters
    ----------
    ends
        Pose and twist before the step and after it, ``(world, 3)`` each, world frame.
    grips, frame
        ``(world, agent, 2)`` of the team.
    gravity
        ``(world, 2)`` [m/s²].
    dt
        Of the step [s].

    Returns
    -------
    ``(world, agent, 2)`` [m/s²], agent frame.
    """
    pose, twist, next_pose, next_twist = ends
    num_worlds, num_agents = frame.shape[:2]
    seen = np.empty((num_worlds, num_agents, 2))
    for k in range(num_worlds):
        angle, spin, next_spin = pose[k, 2], twist[k, 2], next_twist[k, 2]
        turn = turned(angle, spin, next_pose[k, 2], next_spin, dt)
        middle = angle + turn / 2
        c, s = np.cos(middle), np.sin(middle)
        dvx, dvy = rotated_back(
            c, s, next_twist[k, 0] - twist[k, 0], next_twist[k, 1] - twist[k, 1]
        )
        gx, gy = rotated_back(c, s, gravity[k, 0], gravity[k, 1])
        half_c, half_s = np.cos(turn / 2), np.sin(turn / 2)
        across, along = half_c * (next_spin - spin), half_s * (next_spin + spin)
        for i in range(num_agents):
            x, y = grips[k, i, 0], grips[k, i, 1]
            ax = (dvx - across * y - along * x) / dt - gx
            ay = (dvy + across * x - along * y) / dt - gy
            seen[k, i, 0], seen[k, i, 1] = rotated_back(frame[k, i, 0], frame[k, i, 1], ax, ay)
    return seen
