"""The paper's two simulations of a walker, run in `coopenv.Transport` and recorded.

A human follows a plan of minimum jerk by inverse dynamics and an impedance, and gives force along
the walker only; the drive gives the torque, and in the second one the force that keeps it off an
obstacle. Length, time and gains are not in print: the defaults here are ours.

Source: Donner, Endo & Buss 2018, section V-A, Figs. 9-11.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial.legendre import leggauss

from coopenv.arrays import FloatArray, positive, positive_range, whole
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry import frames
from coopenv.physics.body import Body
from coopenv.physics.scene import Box, Scene
from coopenv.tasks import RollingTask
from coopenv.tasks.reference import minimum_jerk
from coopenv.transition import State, Transition
from coopenv.transport import Transport

from ...controllers.walker import AvoidanceDrive

_LIMIT = 1e4  # [N], [N·m] no limit: the paper's agents have none
_NODES, _WEIGHTS = (1 + leggauss(8)[0]) / 2, leggauss(8)[1] / 2
_NEVER = RollingTask(position_tolerance=1e-9, speed_tolerance=1e-9)  # runs to its horizon


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """What a simulation showed; row k is the state at ``time[k]`` and the wrench held from then."""

    time: FloatArray  # (step,) [s]
    pose: FloatArray  # (step, 3) [m, rad], world frame
    twist: FloatArray  # (step, 3) [m/s, rad/s], world frame
    applied: FloatArray  # (step, agent, 3) [N, N·m], object frame
    planned: FloatArray  # (step, 3) the human's planned pose
    grips: FloatArray  # (agent, 2) [m], object frame
    clearance: FloatArray  # (step,) [m] from the nearest obstacle or wall

    @property
    def twist_object(self) -> FloatArray:
        """The twist in the object frame, as `coopenv.wrench.energy_share` wants it."""
        c, s = np.cos(self.pose[:, 2]), np.sin(self.pose[:, 2])
        x, y, spin = self.twist.T
        return np.stack([*frames.rotated_back(c, s, x, y), spin], axis=-1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Impedance:
    """How firmly a plan is followed."""

    stiffness: float = 40.0  # [N/m]
    damping: float = 60.0  # [N·s/m]
    turning_stiffness: float = 40.0  # [N·m/rad]
    turning_damping: float = 40.0  # [N·m·s]

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "turning_stiffness", "turning_damping"):
            value = positive(getattr(self, name), f"impedance.{name}", or_zero=True)
            object.__setattr__(self, name, value)


@dataclass(frozen=True, slots=True, kw_only=True)
class RollingPlan:
    """Roll ``length`` in ``duration`` with minimum jerk, turning by ``turn`` on the way.

    The turn, of minimum jerk too, takes the part ``turning`` of the time.
    """

    length: float = 3.0  # [m]
    duration: float = 8.0  # [s]
    turn: float = 0.0  # [rad], counter-clockwise
    turning: tuple[float, float] = (0.3, 0.7)  # [of the duration]

    def __post_init__(self) -> None:
        positive(self.length, "plan.length", unit="m")
        positive(self.duration, "plan.duration", unit="s")
        begin, end = positive_range(self.turning, "plan.turning", or_zero=True, at_most=1.0)
        if begin == end:
            raise InvalidInput(
                f"plan.turning must last, got {self.turning}; pass for example (0.3, 0.7)"
            )

    def rolled(self, time: FloatArray) -> FloatArray:
        """Way, speed and acceleration along the path, ``(..., 3)`` [m, m/s, m/s²]."""
        return self.length * _rest_to_rest(time, self.duration)

    def turned(self, time: FloatArray) -> FloatArray:
        """Heading and its two rates, ``(..., 3)`` [rad, rad/s, rad/s²]."""
        begin, end = np.multiply(self.turning, self.duration)
        return self.turn * _rest_to_rest(time - begin, end - begin)

    def poses(self, time: FloatArray) -> FloatArray:
        """Planned poses from (0, 0, 0) on, ``(step, 3)``, at ascending times that begin with 0."""
        spans = np.diff(time)
        inner = time[:-1, None] + spans[:, None] * _NODES  # (span, node) [s]
        heading, speed = self.turned(inner)[..., 0], self.rolled(inner)[..., 1]
        paths = np.stack([speed * np.cos(heading), speed * np.sin(heading)], axis=-1)
        steps = np.einsum("kij,i->kj", paths, _WEIGHTS) * spans[:, None]
        poses = np.zeros((len(time), 3))
        poses[1:, :2] = np.cumsum(steps, axis=0)
        poses[:, 2] = self.turned(time)[:, 0]
        return poses


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerTurn:
    """Straight on, a turn, straight on (Figs. 9, 10)."""

    plan: RollingPlan = field(default_factory=lambda: RollingPlan(turn=np.pi / 2))
    impedance: Impedance = field(default_factory=Impedance)
    body: Body = field(default_factory=Body.walker)
    dt: float = 0.01  # [s]

    def run(self) -> Recording:
        """Run it and record every control step."""
        config = _config(self.body, Scene(size=(40.0, 40.0)), self.dt, self.plan.duration)
        return _recorded(config, self.plan, _followers(self.body, self.plan, self.impedance))


@dataclass(frozen=True, slots=True, kw_only=True)
class WalkerAvoid:
    """The human plans straight through an obstacle, the drive stops short of it (Fig. 11).

    The default human is compliant: a stiff one pushes harder the longer the drive holds, so that
    the internal force goes on growing after the two forces first were equal.
    """

    plan: RollingPlan = field(default_factory=lambda: RollingPlan(duration=5.0))
    impedance: Impedance = field(default_factory=lambda: Impedance(stiffness=6.0, damping=4.0))
    body: Body = field(default_factory=Body.walker)
    obstacle: float = 1.2  # [m] from the start's centre of mass to the obstacle's front
    reach: float = 2.0  # [m] C_max
    seconds: float = 8.0  # [s] recorded; the plan ends before it
    dt: float = 0.01  # [s]

    def run(self) -> Recording:
        """Run it and record every control step."""
        front = max(x for x, _ in self.body.outline)
        if not front < self.obstacle < self.plan.length + front:
            raise InvalidInput(
                f"obstacle must stand between the walker and the end of the plan, {front} to "
                f"{self.plan.length + front} m ahead, got {self.obstacle}; move it"
            )
        box = Box(center=(self.obstacle + 0.25, 0.0), size=(0.5, 2.0))
        config = _config(
            self.body, Scene(size=(40.0, 40.0), obstacles=(box,)), self.dt, self.seconds
        )
        drive = AvoidanceDrive(config, reach=self.reach)
        followers = _followers(self.body, self.plan, self.impedance)

        def policy(transition: Transition, planned: FloatArray) -> FloatArray:
            applied = followers(transition, planned)
            applied[:, 1, 0] += drive(transition)
            return applied

        return _recorded(config, self.plan, policy)


_Agents = Callable[[Transition, FloatArray], FloatArray]


def _config(body: Body, scene: Scene, dt: float, seconds: float) -> TransportConfig:
    if body.num_agents != 2:
        raise InvalidInput(
            f"body.grips must be the human's and the drive's, got {body.num_agents}; give two"
        )
    steps = whole(round(positive(seconds, "duration", unit="s") / dt), "horizon", at_least=1)
    return TransportConfig(
        task=_NEVER, body=body, scene=scene, dt=dt, horizon=steps, observe=("goal",),
        force_limit=_LIMIT, torque_limit=_LIMIT,
    )  # fmt: skip


def _followers(body: Body, plan: RollingPlan, impedance: Impedance) -> _Agents:
    """The human follows the plan along the walker's x, the drive follows its heading."""

    def applied(transition: Transition, planned: FloatArray) -> FloatArray:
        state = transition.next_state
        (_, speed, acceleration), (_, spin, spinning) = (
            motion[0] for motion in (plan.rolled(state.time), plan.turned(state.time))
        )
        behind, slow, off, late = _errors(state, planned, speed, spin)
        wrench = np.zeros((1, 2, 3))
        wrench[0, 0, 0] = (
            body.mass * acceleration
            + body.linear_drag * speed
            + impedance.stiffness * behind
            + impedance.damping * slow
        )
        wrench[0, 1, 2] = (
            (body.inertia or 0.0) * spinning
            + body.angular_drag * spin
            + impedance.turning_stiffness * off
            + impedance.turning_damping * late
        )
        return wrench

    return applied


def _errors(
    state: State, planned: FloatArray, speed: float, spin: float
) -> tuple[float, float, float, float]:
    """How far the walker is behind its plan: along its x [m], in speed, in heading, in spin."""
    x, y, angle = state.pose[0].tolist()
    vx, vy, turning = state.twist[0].tolist()
    c, s = np.cos(angle), np.sin(angle)
    behind, _ = frames.seen_from(x, y, c, s, planned[0], planned[1])
    forward, _ = frames.rotated_back(c, s, vx, vy)
    return behind, speed - forward, frames.wrapped(planned[2] - angle), spin - turning


def _recorded(config: TransportConfig, plan: RollingPlan, agents: _Agents) -> Recording:
    core = Transport(num_worlds=1, config=config)
    time = config.dt * np.arange(config.horizon, dtype=np.float64)
    planned = plan.poses(time)
    core.reset(pose=(0.0, 0.0, 0.0), goal=planned[-1])
    measure, rows = AvoidanceDrive(config), []
    for k in range(config.horizon):
        before = core.transition
        assert before is not None
        wrench = agents(before, planned[k])
        clearance = measure.ways(before)[0].min()
        core.step(frames.actions_from_wrenches(wrench, core.team.frame, core.team.limits, 3))
        assert core.transition is not None
        state, applied = before.next_state, core.transition.applied[0]
        rows.append((state.pose[0], state.twist[0], applied, clearance))
    pose, twist, applied, clearance = (np.array(column) for column in zip(*rows, strict=True))
    return Recording(
        time=time,
        pose=pose,
        twist=twist,
        applied=applied,
        planned=planned,
        grips=core.team.grips[0],
        clearance=clearance,
    )


def _rest_to_rest(time: FloatArray, duration: float) -> FloatArray:
    """From 0 to 1 in ``duration``: place and its two rates, ``(..., 3)``; at rest outside."""
    fraction = np.clip(np.asarray(time, dtype=np.float64) / duration, 0.0, 1.0)
    place, rate, change = minimum_jerk(fraction)
    return np.stack([place, rate / duration, change / duration**2], axis=-1)
