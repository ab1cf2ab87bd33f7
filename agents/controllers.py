"""Scripted policies: an impedance controller with load allocation, and a random one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from coopenv import frames
from coopenv.arrays import FloatArray
from coopenv.body import Body
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import UnknownName
from coopenv.transition import State, Transition
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

    Stateless. The object keeps off the walls while it turns: where the coming turn needs more
    room than there is, it moves away from the wall first. Obstacles are not avoided.

    Where an agent would exceed a limit, all agents' wrenches are scaled down together, so that
    the object wrench keeps its direction and the split its proportions.

    Parameters
    ----------
    config
        Of the environment it acts in: mass, inertia and drag, the room, the kind of action.
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
        self._load: _Load | None = None

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, learner, action_size)``; it counts on a partner to do its part."""
        team = transition.team
        applied = allocate(
            self.object_wrench(transition.next_state),
            team.grips,
            self.method,
            virtual_masses=self._masses,
            virtual_inertias=self._inertias,
        )
        action = frames.actions_from_wrenches(applied, team.frame, team.limits, self._width)
        largest = np.abs(action).max(axis=(1, 2), keepdims=True)
        scaled = action / np.maximum(largest, 1.0)
        return scaled if self.config.partner is None else scaled[:, list(self.config.learners)]

    def object_wrench(self, state: State) -> FloatArray:
        """Wrench ``(world, 3)`` [N, N·m] that the object needs, object frame."""
        load = self._load_of(len(state.pose))
        wanted = self._wanted_twist(state, load)
        acceleration = self.gains.damping * (wanted - state.twist)
        wrench = load.inertia * acceleration + load.drag * state.twist  # world frame
        c, s = np.cos(state.pose[:, 2]), np.sin(state.pose[:, 2])
        x, y = wrench[:, 0].copy(), wrench[:, 1].copy()
        wrench[:, 0], wrench[:, 1] = c * x + s * y, c * y - s * x
        return wrench

    def _wanted_twist(self, state: State, load: "_Load") -> FloatArray:
        """Velocity ``(world, 3)`` towards the goal, world frame [m/s, rad/s]."""
        gains = self.gains
        turn = np.pi - (np.pi - (state.goal[:, 2] - state.pose[:, 2])) % (2 * np.pi)
        ahead = np.clip(turn, -gains.look_ahead, gains.look_ahead)
        angles = state.pose[:, 2, None] + ahead[:, None] * np.linspace(0, 1, _LOOK_AHEAD)
        low, high = load.free_box(angles, gains.margin)
        position = state.pose[:, :2]
        way = np.clip(state.goal[:, :2], low, high) - position
        cramped = np.linalg.norm(np.clip(position, low, high) - position, axis=1)  # [m]
        wanted = np.empty_like(state.twist)
        wanted[:, :2] = _saturated(gains.approach * way, gains.speed)
        spin = gains.spin * np.clip(1 - cramped / 0.3, 0.0, 1.0)
        wanted[:, 2] = np.clip(gains.approach * turn, -spin, spin)
        return wanted

    def _load_of(self, num_worlds: int) -> "_Load":
        if self._load is None or len(self._load.inertia) != num_worlds:
            self._load = _Load(self.config, num_worlds)
        return self._load


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


class _Load:
    """What is carried, and the room for it, one row a world."""

    def __init__(self, config: TransportConfig, num_worlds: int):
        bodies = config.bodies(num_worlds)
        self.inertia = np.array([[b.mass, b.mass, b.inertia] for b in bodies], dtype=np.float64)
        self.drag = np.array([[b.linear_drag, b.linear_drag, b.angular_drag] for b in bodies])
        self.half_room = np.array([s.size for s in config.scenes(num_worlds)])[:, None] / 2
        self.outline = _padded(bodies)

    def free_box(self, angles: FloatArray, margin: float) -> tuple[FloatArray, FloatArray]:
        """Where the centre may be so that the object clears the walls at all of ``angles``.

        ``angles`` is ``(world, k)`` [rad]; returns the low and the high corner ``(world, 2)`` [m].
        """
        c, s = np.cos(angles)[..., None], np.sin(angles)[..., None]
        x, y = self.outline[:, None, :, 0], self.outline[:, None, :, 1]
        turned = np.stack([c * x - s * y, s * x + c * y], axis=-1)  # (world, k, vertex, 2)
        low = (-self.half_room[:, 0] + margin) - turned.min(axis=(1, 2))
        high = (self.half_room[:, 0] - margin) - turned.max(axis=(1, 2))
        middle = (low + high) / 2
        return np.minimum(low, middle), np.maximum(high, middle)


def _padded(bodies: Sequence[Body]) -> FloatArray:
    """Outlines ``(world, vertex, 2)``; shorter ones repeat their last vertex."""
    longest = max(len(body.outline) for body in bodies)
    return np.array(
        [body.outline + body.outline[-1:] * (longest - len(body.outline)) for body in bodies]
    )


def _saturated(velocity: FloatArray, limit: float) -> FloatArray:
    speed = np.linalg.norm(velocity, axis=1, keepdims=True)
    return velocity * np.minimum(1.0, limit / np.maximum(speed, 1e-12))
