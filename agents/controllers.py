"""Scripted policies: an impedance controller with load allocation, and a random one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from coopenv import frames
from coopenv.arrays import FloatArray
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import UnknownName
from coopenv.transition import Transition
from coopenv.wrench import allocate
from coopenv.wrench.pseudoinverse import ALLOCATIONS

_TORQUE_FREE = 1e-9  # [kg·m²] virtual inertia that leaves all torque to the forces' levers
_LOOK_AHEAD = 9  # angles looked at between here and the end of the look-ahead


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """How briskly the object is led; the defaults use the default beam's strength.

    The object is to move towards its goal with a velocity proportional to the way that is left,
    up to ``speed`` and ``spin``; an impedance makes it do so.
    """

    approach: float = 3.0  # [1/s] wanted velocity per unit of way left
    damping: float = 10.0  # [1/s] wanted acceleration per unit of velocity error
    speed: float = 2.5  # [m/s] at most
    spin: float = 3.0  # [rad/s] at most
    margin: float = 0.05  # [m] kept from the walls
    look_ahead: float = 0.8  # [rad] of the turn for which room is made in advance


class ImpedanceController:
    """Inverse dynamics and impedance towards the goal, the wrench shared by an allocation.

        h_o = M (k_d (v_d − v)) + D v,    v_d = saturated k_p (goal − pose)

    Stateless; masses, drag and room are those of the episodes under way. The object keeps off the
    walls while it turns: where the coming turn needs more room than there is, it moves away from
    the wall first. Obstacles are not avoided. Tasks that ask for more have controllers of their
    own, which override `wanted_motion`; see `coopenv.agents.scripted.find_controller`.

    Where an agent would exceed a limit, all agents' wrenches are scaled down together, so that
    the object wrench keeps its direction and the split its proportions.

    Parameters
    ----------
    config
        Of the environment it acts in: the kind of action, the number of agents.
    method
        ``"moore_penrose"``, ``"nonsqueezing"`` or ``"parametrized"``; see
        `coopenv.wrench.allocate`. Agents that give forces only (``action="force"``) share by
        ``"parametrized"`` without virtual inertia, whatever is asked for.
    virtual_masses, virtual_inertias
        For ``"parametrized"``: one an agent [kg], [kg·m²].
    gains
        How briskly.

    Raises
    ------
    UnknownName
        If the method does not exist.
    """

    def __init__(
        self,
        config: TransportConfig,
        *,
        method: str = "moore_penrose",
        virtual_masses: Sequence[float] | None = None,
        virtual_inertias: Sequence[float] | None = None,
        gains: Gains | None = None,
    ):
        if method not in ALLOCATIONS:
            raise UnknownName("method", method, ALLOCATIONS)
        self.config, self.method = config, method
        self.gains = gains if gains is not None else Gains()
        self._width = ACTIONS[config.action]
        if self._width == 2:
            self.method, virtual_inertias = "parametrized", [_TORQUE_FREE] * config.num_agents
        self._masses, self._inertias = virtual_masses, virtual_inertias

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, learner, action_size)``; it counts on a partner to do its part."""
        team = transition.team
        applied = allocate(
            self.object_wrench(transition),
            team.grips,
            self.method,
            virtual_masses=self._masses,
            virtual_inertias=self._inertias,
        )
        action = frames.actions_from_wrenches(applied, team.frame, team.limits, self._width)
        largest = np.abs(action).max(axis=(1, 2), keepdims=True)
        scaled = action / np.maximum(largest, 1.0)
        return scaled if self.config.partner is None else scaled[:, list(self.config.learners)]

    def object_wrench(self, transition: Transition) -> FloatArray:
        """Wrench ``(world, 3)`` [N, N·m] that the object needs, object frame."""
        state, load = transition.next_state, transition.conditions.load
        inertia = np.stack([load.mass, load.mass, load.inertia], axis=-1)
        drag = np.stack([load.linear_drag, load.linear_drag, load.angular_drag], axis=-1)
        twist, acceleration = self.wanted_motion(transition)
        acceleration = acceleration + self.gains.damping * (twist - state.twist)
        wrench = inertia * acceleration + drag * state.twist  # world frame
        c, s = np.cos(state.pose[:, 2]), np.sin(state.pose[:, 2])
        x, y = wrench[:, 0].copy(), wrench[:, 1].copy()
        wrench[:, 0], wrench[:, 1] = c * x + s * y, c * y - s * x
        return wrench

    def wanted_motion(self, transition: Transition) -> tuple[FloatArray, FloatArray | float]:
        """Twist ``(world, 3)`` [m/s, rad/s] and acceleration to aim for, world frame."""
        state, conditions = transition.next_state, transition.conditions
        half = conditions.room.size / 2
        return approach(
            state.pose, state.goal, conditions.load.outline, -half, half, self.gains
        ), 0.0


def approach(
    pose: FloatArray,
    goal: FloatArray,
    outline: FloatArray,
    low: FloatArray,
    high: FloatArray,
    gains: Gains,
) -> FloatArray:
    """Twist ``(world, 3)`` that leads an object to a goal within a rectangle, world frame.

    Parameters
    ----------
    pose, goal
        ``(world, 3)``.
    outline
        ``(world, vertex, 2)`` [m], object frame.
    low, high
        Corners ``(world, 2)`` [m] of what is free.
    gains
        How briskly.
    """
    turn = wrapped(goal[:, 2] - pose[:, 2])
    ahead = np.clip(turn, -gains.look_ahead, gains.look_ahead)
    angles = pose[:, 2, None] + ahead[:, None] * np.linspace(0, 1, _LOOK_AHEAD)
    low, high = _free_box(angles, outline, low + gains.margin, high - gains.margin)
    position = pose[:, :2]
    way = np.clip(goal[:, :2], low, high) - position
    cramped = np.linalg.norm(np.clip(position, low, high) - position, axis=1)  # [m]
    wanted = np.empty_like(pose)
    wanted[:, :2] = saturated(gains.approach * way, gains.speed)
    spin = gains.spin * np.clip(1 - cramped / 0.3, 0.0, 1.0)
    wanted[:, 2] = np.clip(gains.approach * turn, -spin, spin)
    return wanted


def wrapped(angle: FloatArray) -> FloatArray:
    """The same angle in (−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def saturated(velocity: FloatArray, limit: float) -> FloatArray:
    """Velocities ``(world, 2)``, the fast ones slowed down to ``limit``."""
    speed = np.linalg.norm(velocity, axis=1, keepdims=True)
    return velocity * np.minimum(1.0, limit / np.maximum(speed, 1e-12))


def _free_box(
    angles: FloatArray, outline: FloatArray, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Corners ``(world, 2)`` of where the centre may be for the object to fit at all of ``angles``.

    ``angles`` is ``(world, k)`` [rad], ``low`` and ``high`` are the corners of what is free.
    """
    c, s = np.cos(angles)[..., None], np.sin(angles)[..., None]
    x, y = outline[:, None, :, 0], outline[:, None, :, 1]
    turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)  # (world, k, vertex, 2)
    low, high = low - turned.min(axis=(1, 2)), high - turned.max(axis=(1, 2))
    middle = (low + high) / 2
    return np.minimum(low, middle), np.maximum(high, middle)


class RandomPolicy:
    """Uniform actions, independent in every step.

    Parameters
    ----------
    config
        Of the environment it acts in.
    seed
        Of its own generator.
    """

    def __init__(self, config: TransportConfig, seed: int = 0):
        self._generator = np.random.default_rng(seed)
        self._width = ACTIONS[config.action]

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, agent, action_size)``."""
        return self._generator.uniform(-1.0, 1.0, (*obs.shape[:2], self._width))
