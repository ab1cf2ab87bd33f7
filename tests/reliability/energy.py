"""Search for kinetic energy that contacts give: what no wall, obstacle or wheel may do.

A substep is free motion under the held wrench, which is known exactly, and then what contacts make
of the velocity. So the energy that contacts gave is the kinetic energy after the substep less that
of the free motion, to rounding, and must not be positive. The searched environment takes control
steps of one substep each, so that every substep is seen.
"""

from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from coopenv import Body, Scene, Transport
from coopenv.arrays import FloatArray
from coopenv.envs.registry import find_config
from coopenv.physics import motion
from coopenv.physics.coefficients import NUM_EXPECTED, coefficients
from coopenv.physics.friction import held
from coopenv.physics.surroundings import NUM_GIVEN
from coopenv.physics.world import World
from coopenv.wrench.grasp import sum_at_centre

ROUNDING = 1e-12  # part of a body's kinetic energy that is no gain
_REMEMBERED = 8  # substeps that a reproduction repeats, the worst one last
_NEW_ACTION = np.array([1.0, 0.5, 0.1, 0.03])  # chance of one in a substep, by world in turn
_AT_LIMITS = 0.3  # part of the actions that are


@dataclass(frozen=True, slots=True, kw_only=True)
class Excess:
    """The most energy that a contact gave in a search; its text is a reproduction."""

    environment_id: str
    seed: int
    keywords: dict[str, Any]
    worst: float  # [J] gained beyond rounding; at most 0 where contacts only take
    energy: float  # [J] of the free motion
    step: int
    world: int
    action: list[list[float]]  # one row an agent
    body: Body
    scene: Scene
    dt: float  # [s] of a substep
    history: list[list[float]]  # rows of pose, twist and wrench before each substep, the worst last
    searched: int = 0  # substeps of all worlds together
    touched: int = 0  # of those, how many had a contact impulse

    def __str__(self) -> str:
        start = self.history[0]
        return f"""\
# {self.environment_id}, seed {self.seed}, {self.keywords}: contacts added {self.worst:.3g} J to
# {self.energy:.3g} J in step {self.step} of world {self.world} under the action {self.action}.
import numpy as np
from coopenv import Body, Box, Scene
from tests.reliability.energy import given, placed
body = {self.body}
scene = {self.scene}
world = placed(body, scene, pose={start[:3]}, twist={start[3:6]}, dt={self.dt})
for wrench in {[row[6:] for row in self.history]}:
    print(given(world, np.array([wrench])))"""


def search(
    environment_id: str, seed: int, steps: int, *, num_worlds: int = 256, **keywords: Any
) -> Excess:
    """Step an environment under random actions and return the most energy that a contact gave.

    Actions are uniform or at their limits, and held for 1 to some 30 substeps. Worlds begin anew
    where episodes end. The same arguments search the same substeps.

    Parameters
    ----------
    environment_id
        For example ``"coopenv/WalkerAvoid-v0"``.
    seed
        Of the worlds and of the actions.
    steps
        Substeps of each world, at least 1.
    num_worlds
        Worlds that are searched side by side.
    **keywords
        Fields of `coopenv.TransportConfig`. A substep takes ``dt / substeps``.
    """
    config = find_config(environment_id, keywords)
    substep = config.dt / config.substeps
    config = replace(config, dt=substep, substeps=1, horizon=config.horizon * config.substeps)
    core, generator = Transport(num_worlds=num_worlds, config=config), np.random.default_rng(seed)
    core.reset(seed=seed)
    action, touched = np.zeros((num_worlds, len(core.learners), core.action_size)), 0
    moving, history = _Motion(core.world), deque[FloatArray](maxlen=_REMEMBERED)
    found: Excess | None = None
    for step in range(steps):
        action = _next_action(generator, action)
        pose, twist = core.world.pose, core.world.twist
        *_, terminated, truncated, _ = core.advance(action)
        assert core.transition is not None
        wrench = sum_at_centre(core.transition.applied, core.team.grips)
        history.append(np.concatenate([pose, twist, wrench], axis=1))
        touched += np.count_nonzero(core.world.contact_impulse)
        energy = moving.free_energy(pose, twist, wrench)
        more = moving.energy(core.world.twist) - energy - ROUNDING * energy
        k = int(more.argmax())
        if found is None or more[k] > found.worst:
            age = round(core.transition.next_state.time[k] / substep)  # substeps of this episode
            found = Excess(
                environment_id=environment_id,
                seed=seed,
                keywords=keywords,
                worst=float(more[k]),
                energy=float(energy[k]),
                step=step,
                world=k,
                action=core.transition.action[k].tolist(),
                body=core.bodies[k],
                scene=core.scenes[k],
                dt=substep,
                history=[rows[k].tolist() for rows in list(history)[-age:]],
            )
        ended = terminated | truncated
        if ended.any():
            core.reset(mask=ended)
            if config.randomise is not None:
                moving = _Motion(core.world)
    assert found is not None
    return replace(found, searched=steps * num_worlds, touched=touched)


def placed(body: Body, scene: Scene, *, pose: Any, twist: Any, dt: float) -> World:
    """One world of one substep a step, whose body moves already; it remembers no contact."""
    world = World([body], [scene], dt=dt, substeps=1)
    world.place(np.array([0]), np.array([pose], dtype=float))
    world.twist = np.array([twist], dtype=float)
    return world


def given(world: World, wrench: FloatArray) -> FloatArray:
    """Step a world of one substep a step; the energy ``(world,)`` that contacts gave [J]."""
    moving = _Motion(world)
    energy = moving.free_energy(world.pose, world.twist, wrench)
    world.step(wrench)
    return moving.energy(world.twist) - energy


def _next_action(generator: np.random.Generator, action: FloatArray) -> FloatArray:
    """The actions of all worlds, some of them new; see `search`."""
    num_worlds = len(action)
    drawn = generator.uniform(-1, 1, action.shape)
    at_limits = generator.uniform(size=num_worlds) < _AT_LIMITS
    drawn[at_limits] = np.sign(drawn[at_limits])
    new = generator.uniform(size=num_worlds) < np.resize(_NEW_ACTION, num_worlds)
    return np.where(new[:, None, None], drawn, action)


class _Motion:
    """Kinetic energy of bodies as they move, and as they would if they touched nothing."""

    def __init__(self, world: World):
        bodies, self._step = world.bodies, world.substep
        self._mass, self._inertia, linear_drag, angular_drag = (
            np.array([getattr(body, name) for body in bodies], dtype=float)
            for name in ("mass", "inertia", "linear_drag", "angular_drag")
        )
        self._table = coefficients(
            self._mass,
            self._inertia,
            linear_drag,
            angular_drag,
            self._step,
            np.array([body.nonholonomic for body in bodies]),
            gravity=np.array([scene.gravity for scene in world.scenes]),
            ground=np.array([held(*pair) for pair in zip(bodies, world.scenes, strict=True)]),
        )

    def energy(self, twist: FloatArray) -> FloatArray:
        """At ``twist`` ``(world, 3)``: ``(world,)`` [J]."""
        vx, vy, spin = twist.T
        return (self._mass * (vx * vx + vy * vy) + self._inertia * spin * spin) / 2

    def free_energy(self, pose: FloatArray, twist: FloatArray, wrench: FloatArray) -> FloatArray:
        """One substep later if nothing is touched: ``(world,)`` [J]; all else ``(world, 3)``."""
        rows, expected = np.arange(len(pose)), np.zeros((len(pose), NUM_EXPECTED))
        command = np.empty((len(pose), 6))
        around = np.zeros((len(pose), NUM_GIVEN))
        motion.drive(
            rows, self._table, pose, twist, wrench, self._step, command, expected, around, True
        )
        return self.energy(expected[:, :3])
