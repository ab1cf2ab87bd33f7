"""What must hold in every step of every environment: finite, within bounds, balanced, added up."""

from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv import Transport
from coopenv.arrays import BoolArray, FloatArray
from coopenv.info import Info
from coopenv.physics.hands import SPEED, TURN_RATE
from coopenv.physics.scene import WALL_THICKNESS
from coopenv.wrench.grasp import sum_at_centre

UNBALANCED = ("virtual_linkage",)  # methods that need not balance: docs/decomposition.md
BALANCED, PLAUSIBLE, ADDED = 1e-9, 1e-8, 1e-12  # in parts of the largest force or torque; of reward
TINY = 1e-140  # [N] squares of smaller numbers are not held by floats
GAINED = 1e-9  # part of √(2E) that is no gain
SLACK = 0.01  # [m] beyond a substep's way
DEEPER = 1.5  # of that way, as a body may turn on what it has met: docs/accuracy.md
DEEPEST = WALL_THICKNESS / 4  # [m] way from which on a body may be parted to the other side
OVERLAPPED = 0.9**60  # part of an overlap that pymunk leaves after a second, its default


class Watch:
    """A look at every step of a batch; raises an `AssertionError` where one shows what it must not.

    Parameters
    ----------
    core
        Whose steps they are.
    name
        What the batch is called in messages.

    Attributes
    ----------
    lost
        The world whose body went through a wall and was so fast that it might (`actions.held`).
    """

    def __init__(self, core: Transport, name: str):
        self._core, self._name, self._steps = core, name, 0
        self.lost: int | None = None
        self._rooms = np.array([scene.size for scene in core.scenes]) / 2  # [m]
        self._has_hand = core.driven.have_hands(core.num_agents) & (core.config.hands is not None)
        self._stored = np.zeros(core.num_worlds)  # [J] in springs of hands
        self._commanded = np.zeros((core.num_worlds, core.num_agents, 3))  # parts of full speed
        self._speed = np.zeros(core.num_worlds)  # √(2E/m) [m/s]
        self._fastest = np.zeros(core.num_worlds)  # the same since nothing was left to be parted

    def look(
        self, obs: npt.NDArray[np.float32], reward: FloatArray, info: Info, again: BoolArray
    ) -> None:
        """At what a step returned; ``again``: which worlds began anew with it."""
        place = f"{self._name}, step {self._steps}"
        self._steps += 1
        core = self._core
        check_finite({"observation": obs, "reward": reward, **info}, place)
        low, high = core.observation.low, core.observation.high
        outside = np.argwhere((obs < low) | (obs > high))
        assert not len(outside), f"{place}: feature {outside[0].tolist()} is outside its space"
        assert obs.dtype == np.float32, f"{place}: observations are {obs.dtype}"
        parts = list(info["reward_terms"].values())
        off = np.abs(sum(parts) - reward) / (1.0 + sum(map(np.abs, parts)))
        assert off.max() <= ADDED, f"{place}: reward is {off.max():.1e} off the sum of its parts"
        self._look_inside(place, again)
        self._look_at_energy(place, again)
        check_decomposition(core, place)

    def may_lose(self, world: int) -> bool:
        """Whether a body may be so fast in the step to come that a wall does not hold it."""
        speed = np.maximum(self._fastest, self._speed)
        speed += self._gain(np.sqrt(2) * self._core.team.limits)
        return bool(self._core.world.substep * speed[world] >= DEEPEST)

    def _look_inside(self, place: str, again: BoolArray) -> None:
        """A centre is about as deep in a wall as a substep's way, which is parted slowly.

        Contacts make speed of spin, so that all of the kinetic energy counts.
        """
        core, transition = self._core, self._core.transition
        assert transition is not None
        given = np.stack([
            np.linalg.norm(transition.applied[..., :2], axis=-1), np.abs(transition.applied[..., 2])
        ], axis=-1)  # fmt: skip
        if core.config.hands is not None:  # the mean of a step, which may have been more within it
            given = np.sqrt(2) * core.team.limits
        speed = self._speed_of(transition.state.twist) + self._gain(given)
        fastest = np.maximum(np.where(again, 0.0, self._fastest), speed)
        way = core.world.substep * fastest
        beyond = (np.abs(core.world.pose[:, :2]) - self._rooms).max(axis=-1)
        deeper = beyond - np.where(way < DEEPEST, DEEPER * way + SLACK, np.inf)
        parting = core.world.contact_shift > SLACK * (1 - OVERLAPPED**core.dt)
        self._fastest = np.where((beyond > 0) | parting, fastest, 0.0)
        self._speed = self._speed_of(core.world.twist)
        worst = int(np.argmax(deeper))
        assert deeper[worst] <= 0, f"{place}: world {worst} is {deeper[worst]:.3f} m in a wall"

    def _look_at_energy(self, place: str, again: BoolArray) -> None:
        """√(2E) grows by what held wrenches and weight give; E by the work of references too.

        E counts what springs of hands hold, which the parting of overlaps may stretch.
        """
        core, transition = self._core, self._core.transition
        assert transition is not None
        load, team = core.conditions.load, core.team
        before, self._stored = np.where(again, 0.0, self._stored), np.zeros(core.num_worlds)
        if transition.stored_energy is not None:
            self._stored = transition.stored_energy.sum(axis=-1)
        inertia = np.stack([load.mass, load.mass, load.inertia], axis=-1)
        held = np.where(self._has_hand[:, None], 0.0, transition.applied)
        wrench = sum_at_centre(held, team.grips)
        push = np.sqrt((wrench**2 / inertia).sum(axis=-1)) + np.sqrt(load.mass) * self._weights()
        energy = (inertia * transition.state.twist**2).sum(axis=-1) + 2 * before
        now = np.sqrt((inertia * core.world.twist**2).sum(axis=-1) + 2 * self._stored)
        most = np.sqrt(energy + 2 * self._work(again)) + core.dt * push
        beyond = now - most * (1 + GAINED) - GAINED
        worst = int(np.argmax(beyond))
        has, may = now[worst] ** 2 / 2, most[worst] ** 2 / 2
        assert beyond[worst] <= 0, f"{place}: world {worst} has {has:.9g} J, at most {may:.9g}"

    def _work(self, again: BoolArray) -> FloatArray:
        """The most [J] that references of hands did in the step, and that parting stretched them.

        References go as fast as is commanded; behind actuators no faster than was commanded so far.
        """
        core, transition = self._core, self._core.transition
        assert transition is not None
        if core.config.hands is None:
            return np.zeros(core.num_worlds)
        commanded = np.abs(transition.action[..., :3])
        if core.config.actuators is not None:
            so_far = np.where(again[:, None, None], 0.0, self._commanded)
            commanded = self._commanded = np.maximum(so_far, commanded)
        force, torque = np.moveaxis(core.team.limits * self._has_hand[:, None], -1, 0)
        speed = np.hypot(commanded[..., 0], commanded[..., 1]) * core.team.hands[..., SPEED]
        rate = commanded[..., 2] * core.team.hands[..., TURN_RATE]
        reach = np.array([body.reach for body in core.bodies])
        parted = core.world.contact_shift * (force.sum(axis=-1) + torque.sum(axis=-1) / reach)
        return core.dt * (speed * force + rate * torque).sum(axis=-1) + parted

    def _weights(self) -> FloatArray:
        """Strength of gravity in the plane, of the episodes under way [m/s²]."""
        return np.linalg.norm(self._core.conditions.room.gravity, axis=-1)

    def _speed_of(self, twist: FloatArray) -> FloatArray:
        """√(2E/m) [m/s] of the kinetic energy alone."""
        load = self._core.conditions.load
        spin = load.inertia / load.mass * twist[:, 2] ** 2
        return np.sqrt(twist[:, 0] ** 2 + twist[:, 1] ** 2 + spin)

    def _gain(self, given: FloatArray) -> FloatArray:
        """√(2E/m) [m/s] that forces and torques ``(world, agent, 2)`` may add in a control step."""
        load, lever = self._core.conditions.load, np.linalg.norm(self._core.team.grips, axis=-1)
        force = given[..., 0].sum(axis=-1)
        torque = (given[..., 1] + lever * given[..., 0]).sum(axis=-1)
        push = np.hypot(force, torque * np.sqrt(load.mass / load.inertia)) / load.mass
        return self._core.dt * (push + self._weights())


def check_finite(shown: dict[str, npt.NDArray[Any]], place: str) -> None:
    """Raise unless every number is one."""
    for name, value in shown.items():
        bad = ~np.isfinite(value)
        assert not bad.any(), (
            f"{place}: {name} is {value[bad][0]} at {np.argwhere(bad)[0].tolist()}"
        )


def check_decomposition(core: Transport, place: str) -> None:
    """Raise where the split does not balance, or blames somebody for what was not done."""
    assert core.transition is not None
    found, settings = core.transition.decomposition, core.config.decomposition
    force = np.linalg.norm(found.applied[..., :2], axis=-1).sum(axis=-1)
    torque = np.abs(found.applied[..., 2]).sum(axis=-1)
    lever = np.linalg.norm(found.grips, axis=-1).max(axis=-1)
    unit = TINY + force + torque + lever * force
    left = found.residuals()
    if settings.method not in UNBALANCED:
        off = (left.balance / unit).max()
        assert off <= BALANCED, f"{place}: {settings.method} is {off:.1e} off balance"
    if settings.plausible:
        off = (np.max(left[1:], axis=0) / unit).max()
        assert off <= PLAUSIBLE, f"{place}: {settings.method} is {off:.1e} beyond eqs. 9-11"
