"""The beam of section V-C: rotate, rotate and translate, translate, free of internal wrench.

The motions run side by side, each for every moment of inertia. In each, the virtual mass m* of
(30) and the share α^d of (34) go through the same four sections, so that every combination of
motion, m* = 1 or not and α^d = ½ or not occurs. The paper prints neither its ways nor its
schedules; these are declared here:

    section     m* [kg]         α^d
    1           1               ½
    2           1 → 4 → 1       ½
    3           1               ½ → 1 → 0 → ½
    4           1 → 4 → 1       ½ → 1 → 0 → ½
"""

from dataclasses import dataclass

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, positive
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry import frames
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks import TransportTask
from coopenv.tasks.reference import minimum_jerk
from coopenv.transport import Transport
from coopenv.wrench import allocate

MOTIONS = ("rotate", "rotate and translate", "translate", "translate askew")
"""The paper's three, and one of ours in which the force is neither along the beam nor across it."""
PAPER = MOTIONS[:3]
WAYS = ((0.0, 0.0, 2.0), (1.8, 1.2, 2.0), (2.0, 0.0, 0.0), (1.8, 1.2, 0.0))  # [m, m, rad]
STARTS = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -0.4))  # [m, m, rad]
SECTIONS = 4
ROUNDING = 1e-9  # departure from m* = 1 or α^d = ½ that is none


@dataclass(frozen=True, slots=True, kw_only=True)
class BeamConfig:
    """The simulation; the defaults are the paper's where it prints them."""

    inertias: tuple[float, ...] = (1.0, 1 / 3)
    """Moments of inertia [kg·m²]: as printed, and what the printed formula m·l²/12 gives."""
    duration: float = 6.0
    """Of each motion [s]."""
    dt: float = 0.01
    """Control step [s]."""
    stiffness: float = 4.0
    """Of the impedance about the plan, per unit of inertia [1/s²]."""
    damping: float = 4.0
    """Of the impedance about the plan, per unit of inertia [1/s]."""
    largest_mass: float = 4.0
    """Largest virtual mass m* [kg]; the smallest is 1."""

    def __post_init__(self) -> None:
        if not self.inertias:
            raise InvalidInput("inertias must not be empty, got (); give one or more [kg·m²]")
        for inertia in self.inertias:
            positive(inertia, "inertias", unit="kg·m²")
        for name in ("duration", "dt", "largest_mass"):
            positive(getattr(self, name), name)
        for name in ("stiffness", "damping"):
            positive(getattr(self, name), name, or_zero=True)
        steps = self.duration / self.dt
        if abs(steps - round(steps)) > 1e-9 * steps or round(steps) < 10 * SECTIONS:
            raise InvalidInput(
                f"duration must be a multiple of dt, of at least {10 * SECTIONS} steps, got "
                f"{self.duration} s in steps of {self.dt} s; change either"
            )

    @property
    def steps(self) -> int:
        """Control steps of a motion."""
        return round(self.duration / self.dt)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BeamRun:
    """What was recorded; first axis inertia, second motion, third time."""

    time: FloatArray  # (time,) at the middle of each control step [s]
    virtual_mass: FloatArray  # (time,) m* [kg]
    wanted_share: FloatArray  # (time,) α^d
    applied: FloatArray  # (inertia, motion, time, 2, 3), object frame [N, N·m]
    object_wrench: FloatArray  # (inertia, motion, time, 3), as planned, object frame [N, N·m]
    pose: FloatArray  # (inertia, motion, time, 3) at the end of each step [m, rad]
    planned: FloatArray  # (motion, time, 3) at the same instants [m, rad]
    twist: FloatArray  # (inertia, motion, time, 3), object frame, middle of the step [m/s, rad/s]
    grips: FloatArray  # (2, 2) object frame [m]
    inertias: tuple[float, ...]  # [kg·m²]

    @property
    def heavy(self) -> BoolArray:
        """``(time,)``: where m* is not 1."""
        return np.abs(self.virtual_mass - 1) > ROUNDING

    @property
    def shifted(self) -> BoolArray:
        """``(time,)``: where α^d is not ½."""
        return np.abs(self.wanted_share - 0.5) > ROUNDING

    @property
    def tracking_error(self) -> FloatArray:
        """``(inertia, motion, time, 2)``: distance [m] and angle [rad] between plan and body."""
        error = self.pose - self.planned
        turn = frames.wrapped(error[..., 2])
        return np.stack([np.linalg.norm(error[..., :2], axis=-1), np.abs(turn)], axis=-1)


def simulate(config: BeamConfig | None = None) -> BeamRun:
    """Carry the beam in `Transport` and record what both agents applied.

    The wrench that inverse dynamics asks for at the middle of a control step, with an impedance
    about the plan, is shared by (30) with the virtual mass m* of both agents and J* = 1, then
    shifted along the beam by (34).
    """
    config = config if config is not None else BeamConfig()
    core = _transport(config)
    plan = _Plan(config)
    num_worlds, steps = core.num_worlds, config.steps
    poses, twists = np.empty((2, steps, num_worlds, 3))
    applied, wanted = np.empty((steps, num_worlds, 2, 3)), np.empty((steps, num_worlds, 3))
    core.reset(seed=0, pose=plan.start, goal=_out_of_the_way(core))
    for step in range(steps):
        transition = core.transition
        assert transition is not None
        before = transition.next_state
        wanted[step] = plan.object_wrench(step, before.pose, before.twist)
        shared = share(
            wanted[step], core.team.grips[0], plan.virtual_mass[step], plan.wanted_share[step]
        )
        core.step(frames.actions_from_wrenches(shared, core.team.frame, core.team.limits, 3))
        after = core.transition
        assert after is not None
        applied[step], poses[step] = after.applied, after.next_state.pose
        twists[step] = object_twist(before, after.next_state)

    def split(recorded: FloatArray) -> FloatArray:
        shape = (steps, len(config.inertias), len(MOTIONS), *recorded.shape[2:])
        return np.moveaxis(recorded.reshape(shape), 0, 2)

    return BeamRun(
        time=plan.middle,
        virtual_mass=plan.virtual_mass,
        wanted_share=plan.wanted_share,
        applied=split(applied),
        object_wrench=split(wanted),
        pose=split(poses),
        planned=plan.poses_after[: len(MOTIONS)],
        twist=split(twists),
        grips=core.team.grips[0].copy(),
        inertias=config.inertias,
    )


def share(
    object_wrench: FloatArray, grips: FloatArray, virtual_mass: float, wanted_share: float
) -> FloatArray:
    """Applied wrenches ``(..., 2, 3)``: (30) with equal m* and J* = 1, then the shift (34).

    h = G_M⁺ h_o,    h ← h + (2α^d − 1) f_GM,1x [1 0 0 −1 0 0]ᵀ
    """
    applied = allocate(
        object_wrench,
        grips,
        "parametrized",
        virtual_masses=[virtual_mass, virtual_mass],
        virtual_inertias=[1.0, 1.0],
    )
    shift = (2 * wanted_share - 1) * applied[..., 0, 0]
    applied[..., 0, 0] += shift
    applied[..., 1, 0] -= shift
    return applied


class _Plan:
    """Where each world is to be, and the schedules; worlds are inertia-major, motion-minor."""

    def __init__(self, config: BeamConfig):
        steps, dt = config.steps, config.dt
        self.middle = dt * (np.arange(steps, dtype=np.float64) + 0.5)
        self.virtual_mass, self.wanted_share = _schedules(self.middle / config.duration, config)
        count = len(config.inertias)
        way = np.tile(np.array(WAYS), (count, 1))
        self.start = np.tile(np.array(STARTS), (count, 1))
        inertia = np.repeat(np.array(config.inertias), len(MOTIONS))
        self._inertia = np.stack([np.ones_like(inertia), np.ones_like(inertia), inertia], axis=-1)
        self._gains = config.stiffness, config.damping
        s, ds, dds = minimum_jerk(self.middle / config.duration)
        self._velocity = ds[:, None, None] / config.duration * way
        self._acceleration = dds[:, None, None] / config.duration**2 * way
        self._angle = self.start[:, 2] + s[:, None] * way[:, 2]
        s, ds, _ = minimum_jerk(dt * np.arange(steps + 1, dtype=np.float64) / config.duration)
        poses = self.start[:, None] + s[:, None] * way[:, None]
        self.poses_before, self.poses_after = poses[:, :-1], poses[:, 1:]
        self._velocity_before = ds[:-1, None, None] / config.duration * way

    def object_wrench(self, step: int, pose: FloatArray, twist: FloatArray) -> FloatArray:
        """What the beam needs over a control step ``(world, 3)``, object frame [N, N·m]."""
        error = self.poses_before[:, step] - pose
        error[:, 2] = frames.wrapped(error[:, 2])
        rate_error = self._velocity_before[step] - twist
        stiffness, damping = self._gains
        correction = stiffness * error + damping * rate_error
        wrench = self._inertia * (self._acceleration[step] + correction) + self._velocity[step]
        c, s = np.cos(self._angle[step]), np.sin(self._angle[step])
        wrench[:, 0], wrench[:, 1] = frames.rotated_back(c, s, wrench[:, 0], wrench[:, 1])
        return wrench


def _schedules(fraction: FloatArray, config: BeamConfig) -> tuple[FloatArray, FloatArray]:
    """m* and α^d at a ``fraction`` of a motion, as in the table above."""
    section = np.minimum((fraction * SECTIONS).astype(np.int64), SECTIONS - 1)
    within = fraction * SECTIONS - section
    bump = np.sin(np.pi * within) ** 2
    swing = np.sin(2 * np.pi * within)
    mass = np.where(section % 2 == 1, 1 + (config.largest_mass - 1) * bump, 1.0)
    share = np.where(section >= 2, 0.5 + 0.5 * swing, 0.5)
    return mass, share


def sections(run: BeamRun) -> BoolArray:
    """``(4, time)``: which samples are in which section of the schedules."""
    heavy, shifted = run.heavy, run.shifted
    return np.array([~heavy & ~shifted, heavy & ~shifted, ~heavy & shifted, heavy & shifted])


def _transport(config: BeamConfig) -> Transport:
    bodies = tuple(
        Body.beam(
            length=2.0,
            mass=1.0,
            inertia=inertia,
            linear_drag=1.0,
            angular_drag=1.0,
            grips=((-1.0, 0.0), (1.0, 0.0)),
        )
        for inertia in config.inertias
        for _ in MOTIONS
    )
    return Transport(
        num_worlds=len(bodies),
        config=TransportConfig(
            body=bodies,
            scene=Scene(size=(12.0, 12.0)),
            task=TransportTask(position_tolerance=1e-9),  # the plan ends the run, not the task
            force_limit=64.0,
            torque_limit=64.0,
            horizon=config.steps,
            dt=config.dt,
        ),
    )


def _out_of_the_way(core: Transport) -> FloatArray:
    """A goal that no motion comes near."""
    return np.tile([-4.0, -4.0, 0.0], (core.num_worlds, 1))


def object_twist(before, after) -> FloatArray:
    """Mean twist over a step in the object frame at its middle ``(world, 3)``."""
    twist = (before.twist + after.twist) / 2
    turn = frames.wrapped(after.pose[:, 2] - before.pose[:, 2])
    angle = before.pose[:, 2] + turn / 2
    own = frames.rotated_back(np.cos(angle), np.sin(angle), twist[:, 0], twist[:, 1])
    return np.stack([*own, twist[:, 2]], axis=-1)
