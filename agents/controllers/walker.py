"""Scripted controllers of a walker: the human pushes, the drive turns it and brakes."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, positive
from coopenv.compiled import compiled
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry import frames
from coopenv.geometry.clearance import WALLS, ways_to_boxes, ways_to_walls
from coopenv.geometry.frames import rotated_back, wrapped
from coopenv.geometry.routes import next_stops
from coopenv.physics.body import Body
from coopenv.pushes import nearest
from coopenv.transition import Transition

from .wrenches import require_wrenches

_WALLS = np.array(WALLS)


class AvoidanceDrive:
    """The drive's force against running into obstacles and walls.

        f_x = −(1/C − 1/C_max) / C² · u,    C < C_max and closing in

    with C the clearance between the outline and the obstacle and u the speed towards it. The way
    to an obstacle at an angle φ off the heading counts with cos²φ: what is passed by does not
    brake. Of several obstacles the one that brakes most counts.

    The drive is the last agent. Its force is held over a control step and grows without bound as
    C falls, so it is taken for the speed at the step's end (backward Euler), given the forces
    that the others applied in the last step, as its sensors show them: it cannot reverse the
    motion by itself, and tends to the formula as the control step falls.

    Parameters
    ----------
    config
        Of the environment it acts in.
    reach
        C_max [m].

    Source: Donner, Endo & Buss 2018, section V-A. Deviations: the print drops C_max and the dot
    over the position; cos²φ; backward Euler.
    """

    def __init__(self, config: TransportConfig, *, reach: float = 2.0):
        self.config = config
        self.reach = positive(reach, "reach", unit="m")
        self.agent = config.num_agents - 1

    def __call__(self, transition: Transition) -> FloatArray:
        """The force along the object's x, ``(world,)`` [N]."""
        state, load = transition.next_state, transition.conditions.load
        heading = np.stack([np.cos(state.pose[:, 2]), np.sin(state.pose[:, 2])], axis=-1)
        speed = np.einsum("ki,ki->k", heading, state.twist[:, :2])
        others = np.delete(transition.applied[..., 0], self.agent, axis=1).sum(axis=1)
        response = transition.dt / load.mass  # [m/s per N]
        coming = speed + response * (others - load.linear_drag * speed)
        distance, toward = self.ways(transition)
        facing = np.einsum("kji,ki->kj", toward, heading)
        closing = facing * coming[:, None] > 0
        damping = np.where(closing, _damping(distance, self.reach) * facing**2, 0.0).max(axis=1)
        return -damping * coming / (1 + damping * response)

    def ways(self, transition: Transition) -> tuple[FloatArray, FloatArray]:
        """Clearance ``(world, solid)`` [m] and direction ``(world, solid, 2)`` of every solid.

        First the boxes, then the four walls; world frame.
        """
        pose, room = transition.next_state.pose, transition.conditions.room
        outline = transition.conditions.load.outline
        boxes = ways_to_boxes(outline, pose, room.boxes, room.count)
        walls = np.maximum(ways_to_walls(outline, pose, room.size), 0.0)
        toward = np.broadcast_to(_WALLS, (len(pose), 4, 2))
        distance = np.concatenate([boxes[..., 0], walls], axis=1)
        return distance, np.concatenate([boxes[..., 1:3], toward], axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerGains:
    """How briskly the walker is led."""

    approach: float = 1.0  # [1/s] wanted speed per metre left
    speed: float = 1.0  # [m/s] at most
    spin: float = 1.0  # [rad/s] at most, and 0.9 of what the torque makes against the drag
    braking: float = 0.5  # [m/s²] the speed leaves room to brake so hard before the goal
    heading: float = 2.5  # [1/s] wanted spin per radian off the way
    arrival: float = 0.6  # [1/s] wanted spin per radian between the way and the goal's angle
    damping: float = 5.0  # [1/s] wanted acceleration per unit of speed error
    near: float = 0.06  # [m] from the goal only its angle counts
    margin: float = 0.05  # [m] kept from obstacles on the way round them


class WalkerController:
    """Drive a body on wheels to its goal: the human pushes along it, the drive turns it.

    Turns towards the way, drives with a swing that ends in the goal's angle (polar coordinates,
    Aicardi et al. 1995), and turns on the spot where that is left over. Obstacles are passed on
    the shortest way for a disc about the body (`coopenv.geometry.routes`). Inverse dynamics make
    the wrench; agent 0 gives the force along x, the last agent the torque, so none of it is
    internal.

    Stateless. With ``action="force"`` agent 0 turns the body by pushing across it.

    Parameters
    ----------
    config
        Of the environment it acts in.
    gains
        How briskly.
    avoid
        Whether the drive also brakes at obstacles (`AvoidanceDrive`).

    Raises
    ------
    InvalidInput
        If nobody could turn the body.
    """

    def __init__(
        self, config: TransportConfig, *, gains: WalkerGains | None = None, avoid: bool = False
    ):
        self.config = config
        self.gains = gains if gains is not None else WalkerGains()
        self._width, self._table = ACTIONS[config.action], config.table
        self._drive = AvoidanceDrive(config) if avoid else None
        bodies = (config.body,) if isinstance(config.body, Body) else config.body
        lever = min(abs(body.grips[0][0]) for body in bodies)  # [m]
        if self._width == 2 and lever < 1e-3:
            raise InvalidInput(
                "body.grips must give agent 0 a lever along x to turn the body with forces, got "
                f"{lever} m; use action='wrench'"
            )

    def __call__(self, obs: npt.NDArray, transition: Transition) -> npt.NDArray:
        """Actions ``(world, learner, action_size)``, or numbers of the nearest pushes."""
        require_wrenches(self.config, "a scripted controller")
        return self._actions(self.applied(transition), transition)

    def applied(self, transition: Transition) -> FloatArray:
        """The agents' wrenches ``(world, agent, 3)`` [N, N·m], object frame, before any limit."""
        team = transition.team
        force, torque = self.object_wrench(transition)
        applied = self._shared(force, torque, team.grips)
        if self._drive is not None:
            applied[:, self._drive.agent, 0] += self._drive(transition)
        return applied

    def parts(self, grips: FloatArray) -> FloatArray:
        """Each agent's part ``(world, agent, 3, 3)`` of an object wrench, for these ``grips``.

        What acts across the wheels is nobody's.
        """
        none, all_of_it = np.zeros(len(grips)), np.ones(len(grips))
        parts = np.zeros((*grips.shape[:2], 3, 3))
        parts[..., 0] = self._shared(all_of_it, none, grips)
        parts[..., 2] = self._shared(none, all_of_it, grips)
        return parts

    def _shared(self, force: FloatArray, torque: FloatArray, grips: FloatArray) -> FloatArray:
        """Wrenches ``(world, agent, 3)`` that make force along x and torque on the body."""
        applied = np.zeros((*grips.shape[:2], 3))
        applied[:, 0, 0] = force
        if self._width >= 3:
            applied[:, -1, 2] = torque
        else:
            applied[:, 0, 1] = torque / grips[:, 0, 0]
        return applied

    def object_wrench(self, transition: Transition) -> tuple[FloatArray, FloatArray]:
        """Force along x [N] and torque [N·m] that the body needs, ``(world,)`` each."""
        state, load, gains = transition.next_state, transition.conditions.load, self.gains
        wanted = self._led(transition)
        c, s = np.cos(state.pose[:, 2]), np.sin(state.pose[:, 2])
        speed, spin = rotated_back(c, s, *state.twist[:, :2].T)[0], state.twist[:, 2]
        force = load.mass * gains.damping * (wanted[:, 0] - speed) + load.linear_drag * speed
        turning = load.inertia * gains.damping * (wanted[:, 1] - spin)
        return force, turning + load.angular_drag * wanted[:, 1]

    def wanted_motion(self, transition: Transition) -> tuple[FloatArray, float]:
        """Twist ``(world, 3)`` [m/s, rad/s] and acceleration to aim for, world frame."""
        wanted, angle = self._led(transition), transition.next_state.pose[:, 2]
        along, spin = wanted.T
        return np.stack([along * np.cos(angle), along * np.sin(angle), spin], axis=-1), 0.0

    def _led(self, transition: Transition) -> FloatArray:
        """Forward speed and spin to aim for, ``(world, 2)`` [m/s, rad/s]."""
        state, conditions, gains = transition.next_state, transition.conditions, self.gains
        load, room = conditions.load, conditions.room
        radius = np.linalg.norm(load.outline, axis=2).max(axis=1) + gains.margin
        stop, way = next_stops(state.pose, state.goal, room.boxes, room.count, room.size, radius)
        leading = _Leading(
            gains.approach, gains.speed, gains.braking, gains.heading, gains.arrival, gains.near
        )
        spins = self._spins(transition)
        return _wanted(state.pose, state.goal, stop, way[:, 0], spins, leading)

    def _spins(self, transition: Transition) -> FloatArray:
        """How fast each body is to turn at most, ``(world,)`` [rad/s]."""
        team, drag = transition.team, transition.conditions.load.angular_drag
        torque = team.limits[:, -1, 1]  # [N·m]
        if self._width == 2:
            torque = team.limits[:, 0, 0] * np.abs(team.grips[:, 0, 0])
        return np.minimum(self.gains.spin, 0.9 * torque / np.maximum(drag, 1e-9))

    def _actions(self, applied: FloatArray, transition: Transition) -> npt.NDArray:
        team = transition.team
        action = frames.actions_from_wrenches(applied, team.frame, team.limits, self._width)
        clipped = np.clip(action, -1.0, 1.0)
        given = clipped if self.config.partner is None else clipped[:, list(self.config.learners)]
        return nearest(given, self._table)


def _damping(distance: FloatArray, reach: float) -> FloatArray:
    """(1/C − 1/C_max) / C² [N·s/m]; 0 beyond C_max."""
    clearance = np.maximum(distance, 1e-3)  # [m] in contact the walls stop it anyway
    return np.where(distance < reach, (1 / clearance - 1 / reach) / clearance**2, 0.0)


class _Leading(NamedTuple):
    """The entries of `WalkerGains` that say where to and how fast."""

    approach: float
    speed: float
    braking: float
    heading: float
    arrival: float
    near: float


@compiled
def _wanted(pose, goal, stop, length, spin, leading):
    """Forward speed and spin to lead with, ``(world, 2)`` [m/s, rad/s]; ``spin`` at most.

    ``length`` is the way round obstacles that is left to the goal, ``(world,)`` [m].
    """
    approach, speed, braking, heading, arrival, near = leading
    wanted = np.empty((len(pose), 2))
    for k in range(len(pose)):
        dx, dy, angle = stop[k, 0] - pose[k, 0], stop[k, 1] - pose[k, 1], pose[k, 2]
        way, left = np.arctan2(dy, dx), np.hypot(dx, dy)
        last = stop[k, 0] == goal[k, 0] and stop[k, 1] == goal[k, 1]
        into, out_of, sense = wrapped(way - angle), 0.0, 1.0
        if last and left < near:
            wanted[k, 0] = approach * rotated_back(np.cos(angle), np.sin(angle), dx, dy)[0]
            wanted[k, 1] = heading * wrapped(goal[k, 2] - angle)
        else:
            if last:
                out_of = wrapped(goal[k, 2] - way)
                if abs(into) + abs(out_of) > np.pi:  # backwards it has less to turn
                    into, out_of, sense = wrapped(into + np.pi), wrapped(out_of + np.pi), -1.0
            else:
                left = length[k]
            fast = min(speed, approach * left, np.sqrt(2 * braking * left))
            wanted[k, 0] = sense * fast * max(np.cos(into), 0.0)
            wanted[k, 1] = heading * into - arrival * out_of
        if abs(wanted[k, 1]) > spin[k]:  # slower, so that the bend stays as it is
            wanted[k, 0] *= spin[k] / abs(wanted[k, 1])
            wanted[k, 1] = spin[k] * np.sign(wanted[k, 1])
    return wanted
