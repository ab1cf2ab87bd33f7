"""Wrenches by motion: how hands have to move so that their springs give what is wanted."""

import numpy as np

from coopenv.arrays import BoolArray, FloatArray
from coopenv.compiled import compiled, inlined
from coopenv.config import ACTIONS, TransportConfig
from coopenv.geometry.frames import rotated_back
from coopenv.physics.hands import SPEED
from coopenv.transition import Transition
from coopenv.wrench.grasp import grasp_matrix

from .guidance import triple

REACH = 0.8  # of a hand's speed that a plan may ask for; what is left makes forces


class HandMotions:
    """Actions with which hands give wanted wrenches, as far as their speed goes.

    A hand that moves with u where its grip moves with v gives in the mean of a control step

        f = K (s + (u − v) dt / 2) + B (u − v),    hence  u = v + (f − K s) / (B + K dt / 2)

    with s the way from the grip to the hand's reference; torques alike. Since s is what it is, no
    reference runs away. Where a hand would have to be faster than it is, all hands of its world go
    the same part of the way from what they give to what is wanted: if neither loads the object
    from within, nor does anything in between.

    With ``action="impedance"`` stiffness and damping stay in the middle of their bounds.

    Parameters
    ----------
    config
        Of an environment with hands.
    agents
        Numbers of the agents whose hands are moved.
    """

    def __init__(self, config: TransportConfig, agents: tuple[int, ...]):
        hands = config.hands
        assert hands is not None
        self._agents, self._width, self._dt = np.array(agents), ACTIONS[config.action], config.dt
        self._factors = np.ones(4)
        if self._width == 5:
            stiffer, damped = np.sqrt(np.prod([hands.stiffness_factors, hands.damping_factors], 1))
            self._factors = np.array([stiffer, stiffer, damped, damped])

    def springs(self, hands: FloatArray) -> FloatArray:
        """K, κ, B and β ``(world, agent, 4)`` of hands ``(world, agent, 6)`` in a step."""
        return hands[..., :4] * self._factors

    def parts(self, grips: FloatArray, hands: FloatArray, wheels: BoolArray) -> FloatArray:
        """Each hand's part ``(world, agent, 3, 3)`` of an object wrench, object frame.

        That of hands whose references move as one rigid body, W Gᵀ (G W Gᵀ)⁻¹, with W what hands
        give for a unit of velocity. What acts across ``wheels`` ``(world,)`` is nobody's.
        """
        springs = self.springs(hands)
        reply = (springs[..., :2] * self._dt / 2 + springs[..., 2:])[..., [0, 0, 1]]
        grasp = grasp_matrix(grips)
        grasp[wheels, 1] = 0.0
        moved = reply.reshape(len(grips), -1, 1) * np.swapaxes(grasp, 1, 2)
        parts = moved @ np.linalg.pinv(grasp @ moved, hermitian=True)
        return parts.reshape(*grips.shape[:2], 3, 3)

    def __call__(self, wrench: FloatArray, twist: FloatArray, transition: Transition) -> FloatArray:
        """Actions ``(world, hand, action_size)`` in [−1, 1].

        Parameters
        ----------
        wrench
            ``(world, hand, 3)`` wanted in the mean of the coming step, object frame [N, N·m].
        twist
            ``(world, 3)`` that the object will have in the middle of it, world frame.
        transition
            The step that led here.
        """
        team, pose, stretch = transition.team, transition.next_state.pose, transition.stretch
        assert stretch is not None
        out = np.zeros((*wrench.shape[:2], self._width))
        hands = team.grips, team.frame, self.springs(team.hands), team.hands[..., SPEED:]
        _write(wrench, pose, twist, stretch, hands, self._agents, self._dt, out)
        return out


@inlined
def paced_twist(wanted, pose, k, grips, fastest):
    """One of `paced`, that of world ``k``; ``fastest`` are speeds and turn rates of its hands."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    vx, vy = rotated_back(c, s, wanted[0], wanted[1])
    spin, most = wanted[2], 1.0
    for i in range(grips.shape[1]):
        x, y = vx - spin * grips[k, i, 1], vy + spin * grips[k, i, 0]
        most = max(most, np.sqrt(x * x + y * y) / (REACH * fastest[k, i, 0]))
        most = max(most, abs(spin) / (REACH * fastest[k, i, 1]))
    return wanted[0] / most, wanted[1] / most, spin / most


@compiled
def paced(wanted, pose, grips, fastest):
    """Twists ``(world, 3)``, world frame, slowed down to what every hand can follow.

    Both parts alike, so that the object's path stays as it is; each hand keeps `REACH` of its speed
    and turn rate, ``fastest`` ``(world, agent, 2)``.
    """
    slowed = np.empty_like(wanted)
    for k in range(len(wanted)):
        slowed[k] = paced_twist(triple(wanted, k), triple(pose, k), k, grips, fastest)
    return slowed


@compiled
def _write(wrench, pose, twist, stretch, hands, agents, dt, out):
    """Actions into ``out``, axes of the agents as they are in the middle of the step."""
    grips, frame, spring, fastest = hands
    change = np.empty((len(agents), 3))
    for k in range(len(pose)):
        spin, half = twist[k, 2], twist[k, 2] * dt / 2
        c, s = np.cos(pose[k, 2] + half), np.sin(pose[k, 2] + half)
        vx, vy = rotated_back(c, s, twist[k, 0], twist[k, 1])
        c, s = np.cos(half), np.sin(half)
        part = 1.0
        for number, i in enumerate(agents):
            axis_x, axis_y = frame[k, i, 0], frame[k, i, 1]
            x, y = rotated_back(
                axis_x, axis_y, vx - spin * grips[k, i, 1], vy + spin * grips[k, i, 0]
            )
            speed, rate = fastest[k, i, 0], fastest[k, i, 1]
            out[k, number, 0], out[k, number, 1] = x / speed, y / speed
            out[k, number, 2] = spin / rate
            x, y = rotated_back(
                c, s,
                wrench[k, number, 0] - spring[k, i, 0] * stretch[k, i, 0],
                wrench[k, number, 1] - spring[k, i, 0] * stretch[k, i, 1],
            )  # fmt: skip
            x, y = rotated_back(axis_x, axis_y, x, y)
            torque = wrench[k, number, 2] - spring[k, i, 1] * stretch[k, i, 2]
            reply = (spring[k, i, 2] + spring[k, i, 0] * dt / 2) * speed
            turn_reply = (spring[k, i, 3] + spring[k, i, 1] * dt / 2) * rate
            change[number, 0], change[number, 1] = x / reply, y / reply
            change[number, 2] = torque / turn_reply if turn_reply > 0 else 0.0  # a ball joint
            for j in range(3):
                part = min(part, _possible(out[k, number, j], change[number, j]))
        for number in range(len(agents)):
            for j in range(3):
                given = out[k, number, j] + part * change[number, j]
                out[k, number, j] = min(max(given, -1.0), 1.0)


@inlined
def _possible(action, change):
    """What part of a ``change`` leaves an action within [−1, 1], or outside no farther out."""
    if change > 0 and action + change > 1:
        return max(1 - action, 0.0) / change
    if change < 0 and action + change < -1:
        return max(1 + action, 0.0) / -change
    return 1.0
