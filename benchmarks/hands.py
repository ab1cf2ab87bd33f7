"""Benchmark of hands that give way, for docs/accuracy.md: their substeps, and the wrench of a step.

Two hands are moved at random velocities, changed every half second, against the same run at many
substeps; and let go with their springs stretched, to see whether energy grows. Beside the rule that
`coopenv.physics.compliance` has stands the simplest other one: the wrench at the beginning of a
substep, held through it.
"""

from dataclasses import dataclass, replace

import numpy as np

from coopenv import Body, Hands, Scene
from coopenv.arrays import FloatArray
from coopenv.physics.compliance import Hold, feel
from coopenv.physics.world import World
from coopenv.wrench.grasp import sum_at_centre

NUM_WORLDS, NUM_STEPS, HOLD, DT = 64, 40, 10, 0.05
LIMITS = 10.0, 5.0  # [N, N·m]
REFERENCE, CHOICES = 200, (1, 2, 5, 10, 20)
BODIES = {"7.7 kg": Body(), "1 kg": Body(mass=1.0)}


@dataclass
class Held:
    """Worlds in which hands hold a body.

    Parameters
    ----------
    body
        In every world.
    substeps
        Physics steps in a control step.
    explicit
        Whether the wrench is that at the beginning of each substep.
    """

    body: Body
    substeps: int
    explicit: bool = False

    def __post_init__(self) -> None:
        scenes = [Scene(size=(100.0, 100.0))] * NUM_WORLDS
        fine = (DT / self.substeps, 1) if self.explicit else (DT, self.substeps)
        self.world = World([self.body] * NUM_WORLDS, scenes, dt=fine[0], substeps=fine[1])
        self.world.place(np.arange(NUM_WORLDS), np.zeros((NUM_WORLDS, 3)))
        shape = NUM_WORLDS, self.body.num_agents
        springs = Hands().table(self.body.num_agents)[:, :4]
        self.hold = Hold(
            velocity=np.zeros((*shape, 3)),
            spring=springs[None].repeat(NUM_WORLDS, axis=0),
            limit=np.full((*shape, 2), LIMITS),
            grips=np.array(self.body.grips)[None].repeat(NUM_WORLDS, axis=0),
            held=np.zeros((*shape, 3)),
            reference=np.zeros((*shape, 3)),
            stretch=np.zeros((*shape, 3)),
            applied=np.zeros((*shape, 3)),
            felt=np.zeros((*shape, 3)),
            energy=np.zeros(shape),
        )
        self.hold.reference[..., :2] = self.hold.grips

    def step(self) -> None:
        """One control step."""
        if not self.explicit:
            self.hold.applied[:] = 0.0
            self.world.hold(self.hold)
            return
        for _ in range(self.substeps):
            feel(self.world.pose, self.world.twist, tuple(self.hold))
            self.world.step(sum_at_centre(self.hold.felt, self.hold.grips))
            self.hold.reference[:] += DT / self.substeps * self.hold.velocity
        feel(self.world.pose, self.world.twist, tuple(self.hold))

    def energy(self) -> FloatArray:
        """``(world,)`` [J] of motion and of springs."""
        moving = (self.body.mass, self.body.mass, self.body.inertia or 0.0)
        return (self.world.twist**2 @ np.array(moving)) / 2 + self.hold.energy.sum(axis=1)

    def moved(self) -> FloatArray:
        """Poses ``(step, world, 3)`` under random velocities."""
        generator, poses = np.random.default_rng(0), []
        for step in range(NUM_STEPS):
            if step % HOLD == 0:
                self.hold.velocity[:] = generator.uniform(-1, 1, self.hold.velocity.shape)
            self.step()
            poses.append(self.world.pose)
        return np.array(poses)

    def released(self) -> FloatArray:
        """Energies ``(step, world)`` [J] from stretched springs on, under references at rest."""
        generator = np.random.default_rng(1)
        self.hold.reference[:] += generator.normal(0, 1, self.hold.reference.shape) * 0.03
        feel(self.world.pose, self.world.twist, tuple(self.hold))
        energies = [self.energy()]
        for _ in range(NUM_STEPS):
            self.step()
            energies.append(self.energy())
        return np.array(energies)


def substeps_table() -> str:
    """Error and energy of both rules against the number of substeps."""
    lines = []
    for name, body in BODIES.items():
        exact = Held(body, REFERENCE).moved()
        gliding = replace(body, linear_drag=0.0, angular_drag=0.0)
        for substeps in CHOICES:
            cells = []
            for explicit in (False, True):
                poses = Held(body, substeps, explicit).moved()
                away = np.linalg.norm((poses - exact)[..., :2], axis=-1).max(axis=0).mean()
                energy = Held(gliding, substeps, explicit).released()
                growth = (np.diff(energy, axis=0) / energy[0]).max()
                cells += [_length(float(away)), f"{100 * max(growth, 0.0):.2g} %"]
            lines.append(f"| {name} | {substeps} | " + " | ".join(cells) + " |")
    head = (
        "| beam | substeps | middle: error | energy gained in a step | beginning: error | "
        "energy gained in a step |"
    )
    return "\n".join([head, "|---|---|---|---|---|---|", *lines])


def _length(metres: float) -> str:
    return f"{1000 * metres:.2g} mm" if metres < 10 else "off"


def wrench_table() -> str:
    """How far the twist after a step is from what a held wrench makes of it, mean or sample."""
    lines = []
    for substeps in (2, 10):
        held = Held(Body(), substeps)
        plain = Held(Body(), 1).world
        generator, errors, apart = np.random.default_rng(2), {"mean": [], "end": []}, []
        for step in range(NUM_STEPS):
            if step % HOLD == 0:
                held.hold.velocity[:] = generator.uniform(-1, 1, held.hold.velocity.shape)
            pose, twist = held.world.pose, held.world.twist
            held.step()
            for name, wrench in (("mean", held.hold.applied), ("end", held.hold.felt)):
                plain.place(np.arange(NUM_WORLDS), pose)
                plain.twist = twist.copy()
                plain.step(sum_at_centre(wrench, held.hold.grips))
                errors[name].append(np.linalg.norm((plain.twist - held.world.twist)[:, :2], axis=1))
            apart.append(np.linalg.norm((held.hold.applied - held.hold.felt)[..., :2], axis=-1))
        mean, end = (float(np.mean(errors[name])) for name in ("mean", "end"))
        lines.append(f"| {substeps} | {np.mean(apart):.2g} N | {mean:.1e} m/s | {end:.1e} m/s |")
    head = (
        "| substeps | mean and sample at the end apart | velocity that the mean explains, off by | "
        "that the sample explains, off by |"
    )
    return "\n".join([head, "|---|---|---|---|", *lines])
