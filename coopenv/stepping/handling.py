"""Handling: how the actions of a step move the worlds, by held wrenches or by compliant hands."""

from typing import Any, NamedTuple

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.compiled import compiled
from coopenv.compiled.parallel import sharing_rows, spread
from coopenv.conditions import Team
from coopenv.config import TransportConfig
from coopenv.geometry.frames import moved, rotated, write_wrench
from coopenv.physics.compliance import Hold
from coopenv.physics.hands import (
    DAMPING,
    SPEED,
    STIFFNESS,
    TORQUE_DAMPING,
    TORQUE_STIFFNESS,
    TURN_RATE,
)
from coopenv.physics.world import World
from coopenv.wrench.grasp import write_sum


class Given(NamedTuple):
    """What agents did in a step; `coopenv.Transition` has the fields of the same names."""

    action: FloatArray  # (world, agent, a)
    applied: FloatArray  # (world, agent, 3)
    stretch: FloatArray | None = None  # (world, agent, 3)
    felt_wrench: FloatArray | None = None  # (world, agent, 3)
    stored_energy: FloatArray | None = None  # (world, agent)


class HeldWrenches:
    """Actions are wrenches, each held during its step: nothing is remembered.

    `CompliantHands` overrides all methods; `handling_of` chooses between the two.
    """

    def begin(self, worlds: IntArray, pose: FloatArray, team: Team) -> None:
        """Start an episode in ``worlds``, bodies at ``pose``, held by ``team``; one row each."""

    def move(self, world: World, action: FloatArray, team: Team) -> Given:
        """Step ``world`` under all agents' finite actions ``(world, agent, a)``."""
        clipped, applied = np.empty(action.shape), np.empty((*action.shape[:2], 3))
        wrench = np.empty((len(action), 3))
        _give(
            *sharing_rows(len(action)), action, team.frame, team.limits, team.grips,
            clipped, applied, wrench,
        )  # fmt: skip
        world.step(wrench)
        return Given(clipped, applied)

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What is remembered of ``worlds``, one row each."""
        return {}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""


class CompliantHands(HeldWrenches):
    """Actions are velocities of hands, and perhaps how stiff and damped they are in this step.

    Agents whose partner gives wrenches have no hand: as elsewhere, they hold what it gives.

    Where stiffness rises from a step to the next, the reference is drawn nearer, so that force and
    torque stay, and the energy stored falls; where it falls, the reference stays, and with it falls
    the energy. So a change of stiffness never gives energy.

    Parameters
    ----------
    config
        Of the environment; it has hands.
    num_worlds
        Worlds stepped together.
    has_hand
        ``(agent,)``: whether its actions move a hand.
    """

    def __init__(self, config: TransportConfig, num_worlds: int, has_hand: BoolArray):
        hands = config.hands
        assert hands is not None
        self._has_hand = has_hand
        factors = np.array([hands.stiffness_factors, hands.damping_factors])
        self._middle, self._spread = (
            np.log(factors).mean(axis=1),
            np.ptp(np.log(factors), axis=1) / 2,
        )
        self._half_step = config.dt / 2  # [s]
        shape = num_worlds, config.num_agents
        self._reference = np.zeros((*shape, 3))  # world frame, its angle going on as the body's
        self._stiffness = np.zeros((*shape, 2))  # of the last step [N/m, N·m/rad]

    def begin(self, worlds: IntArray, pose: FloatArray, team: Team) -> None:
        """Put the references of ``worlds`` onto the grips."""
        for k, at, grips in zip(worlds.tolist(), pose, team.grips, strict=True):
            self._reference[k, :, :2], self._reference[k, :, 2] = moved(grips, at), at[2]
        self._stiffness[worlds] = team.hands[..., [STIFFNESS, TORQUE_STIFFNESS]]

    def move(self, world: World, action: FloatArray, team: Team) -> Given:
        """See `HeldWrenches.move`."""
        clipped, velocity, spring, held = _read(
            action, team.frame, team.limits, team.hands, self._has_hand, self._middle, self._spread,
            world.pose[:, 2] + world.twist[:, 2] * self._half_step,
        )  # fmt: skip
        _stiffen(spring, self._stiffness, self._reference, world.pose, team.grips)
        shape = clipped.shape[:2]
        hold = Hold(
            velocity=velocity,
            spring=spring,
            limit=team.limits,
            grips=team.grips,
            held=held,
            reference=self._reference,
            stretch=np.empty((*shape, 3)),
            applied=np.zeros((*shape, 3)),
            felt=np.empty((*shape, 3)),
            energy=np.empty(shape),
        )
        world.hold(hold)
        return Given(clipped, hold.applied, hold.stretch, hold.felt, hold.energy)

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """See `HeldWrenches.get_state`."""
        return {"reference": self._reference[worlds], "stiffness": self._stiffness[worlds]}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """See `HeldWrenches.set_state`."""
        self._reference[worlds], self._stiffness[worlds] = state["reference"], state["stiffness"]


def handling_of(config: TransportConfig, num_worlds: int, has_hand: BoolArray) -> HeldWrenches:
    """How actions of the configuration's kind move ``num_worlds`` worlds.

    ``has_hand`` ``(agent,)`` says who has a hand if any are there; others' actions are wrenches.
    """
    return HeldWrenches() if config.hands is None else CompliantHands(config, num_worlds, has_hand)


@compiled
def _give_part(start, stop, action, frame, limits, grips, clipped, applied, wrench):
    for k in range(start, stop):
        write_wrench(action, frame, limits, k, clipped, applied)
        write_sum(applied[k], grips[k], wrench[k])


@compiled
def _give(board, parts, action, frame, limits, grips, clipped, applied, wrench):
    """Write clipped actions, the wrenches that they are, and what these come to together.

    The last is ``(world, 3)``, at the centre of mass; all are in the object frame.
    """
    arguments = (action, frame, limits, grips, clipped, applied, wrench)
    spread(board, parts, len(action), _give_part, arguments)


@compiled
def _read(action, frame, limits, hands, has_hand, middle, spread, angle):
    """Clipped actions, and what they stand for: velocities, springs and held wrenches.

    Parameters
    ----------
    action
        ``(world, agent, 3 or 5)``, agent frame.
    frame, limits, hands
        Of the team.
    has_hand
        ``(agent,)``: others' actions are wrenches.
    middle, spread
        ``(2,)``: logarithms of the factors of stiffness and of damping that an action of 0 stands
        for, and by how much 1 raises them.
    angle
        ``(world,)`` of the bodies in the middle of the step, if they turn on as they do [rad]: a
        hand that goes round with its body then keeps to the circle.

    Returns
    -------
    As `Hold` has them, after ``(world, agent, a)``.
    """
    num_worlds, num_agents, width = action.shape
    clipped = np.empty((num_worlds, num_agents, width))
    velocity, held = np.zeros((num_worlds, num_agents, 3)), np.zeros((num_worlds, num_agents, 3))
    spring = np.zeros((num_worlds, num_agents, 4))
    for k in range(num_worlds):
        c, s = np.cos(angle[k]), np.sin(angle[k])
        for i in range(num_agents):
            for j in range(width):
                clipped[k, i, j] = min(max(action[k, i, j], -1.0), 1.0)
            x, y = rotated(frame[k, i, 0], frame[k, i, 1], clipped[k, i, 0], clipped[k, i, 1])
            turning = clipped[k, i, 2]
            if not has_hand[i]:
                held[k, i, 0], held[k, i, 1] = limits[k, i, 0] * x, limits[k, i, 0] * y
                held[k, i, 2] = limits[k, i, 1] * turning
                continue
            x, y = rotated(c, s, x, y)
            velocity[k, i, 0], velocity[k, i, 1] = hands[k, i, SPEED] * x, hands[k, i, SPEED] * y
            velocity[k, i, 2] = hands[k, i, TURN_RATE] * turning
            stiffer = damped = 1.0
            if width == 5:
                stiffer = np.exp(middle[0] + spread[0] * clipped[k, i, 3])
                damped = np.exp(middle[1] + spread[1] * clipped[k, i, 4])
            spring[k, i, 0] = stiffer * hands[k, i, STIFFNESS]
            spring[k, i, 1] = stiffer * hands[k, i, TORQUE_STIFFNESS]
            spring[k, i, 2] = damped * hands[k, i, DAMPING]
            spring[k, i, 3] = damped * hands[k, i, TORQUE_DAMPING]
    return clipped, velocity, spring, held


@compiled
def _stiffen(spring, stiffness, reference, pose, grips):
    """Draw references nearer where stiffness rises; ``stiffness`` becomes that of ``spring``."""
    for k in range(len(pose)):
        for i in range(grips.shape[1]):
            if spring[k, i, 0] > stiffness[k, i, 0]:
                c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])  # here, as few steps need them
                x, y = rotated(c, s, grips[k, i, 0], grips[k, i, 1])
                x, y = pose[k, 0] + x, pose[k, 1] + y
                part = stiffness[k, i, 0] / spring[k, i, 0]
                reference[k, i, 0] = x + part * (reference[k, i, 0] - x)
                reference[k, i, 1] = y + part * (reference[k, i, 1] - y)
            if spring[k, i, 1] > stiffness[k, i, 1]:
                part = stiffness[k, i, 1] / spring[k, i, 1]
                reference[k, i, 2] = pose[k, 2] + part * (reference[k, i, 2] - pose[k, 2])
            stiffness[k, i, 0], stiffness[k, i, 1] = spring[k, i, 0], spring[k, i, 1]
