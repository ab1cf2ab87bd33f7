"""Bodies that hands hold, without an environment around them: what several tests share."""

from dataclasses import dataclass

import numpy as np

from coopenv import Body, Scene
from coopenv.arrays import FloatArray
from coopenv.geometry.frames import rotated
from coopenv.physics.compliance import Hold
from coopenv.physics.hands import Hands
from coopenv.physics.world import World

ROOM = Scene(size=(60.0, 60.0))  # [m]; nothing to touch within a test
STRONG = (1e4, 1e4)  # [N, N·m], more than any spring of a test gives


@dataclass
class Held:
    """Worlds of bodies at ``pose`` with hands on the grips, stepped by `World.hold`."""

    bodies: list[Body]
    springs: FloatArray  # (world, agent, 4)
    limits: tuple[float, float] | FloatArray = STRONG
    pose: FloatArray | tuple[float, float, float] = (0.3, -0.2, 0.7)
    dt: float = 0.05  # [s]
    substeps: int = 2
    scene: Scene = ROOM

    @classmethod
    def of(cls, body: Body, hands: Hands, num_worlds: int = 1, **values) -> "Held":
        """The same body and hands in every world."""
        springs = hands.table(body.num_agents)[None, :, :4].repeat(num_worlds, axis=0)
        return cls([body] * num_worlds, springs, **values)

    def __post_init__(self):
        self.world = World(
            self.bodies, [self.scene] * len(self.bodies), dt=self.dt, substeps=self.substeps
        )
        shape = len(self.bodies), self.bodies[0].num_agents
        self.grips = np.array([body.grips for body in self.bodies])
        pose = np.broadcast_to(np.array(self.pose, dtype=float), (shape[0], 3)).copy()
        self.world.place(np.arange(shape[0]), pose)
        self.springs = np.ascontiguousarray(self.springs)  # else kernels are compiled anew
        self.limit = np.broadcast_to(np.array(self.limits, dtype=float), (*shape, 2)).copy()
        self.velocity, self.held = np.zeros((*shape, 3)), np.zeros((*shape, 3))
        self.reference = np.concatenate(
            [self.grips_in_world(), np.broadcast_to(pose[:, None, 2:], (*shape, 1))], axis=-1
        )
        self.stretch, self.felt = np.zeros((*shape, 3)), np.zeros((*shape, 3))
        self.applied, self.energy = np.zeros((*shape, 3)), np.zeros(shape)

    def grips_in_world(self) -> FloatArray:
        """``(world, agent, 2)``."""
        c, s = np.cos(self.world.pose[:, 2:]), np.sin(self.world.pose[:, 2:])
        turned = np.stack(rotated(c, s, *np.moveaxis(self.grips, -1, 0)), axis=-1)
        return turned + self.world.pose[:, None, :2]

    def step(self) -> None:
        """One control step."""
        self.applied = np.zeros_like(self.applied)
        self.world.hold(
            Hold(
                velocity=self.velocity,
                spring=self.springs,
                limit=self.limit,
                grips=self.grips,
                held=self.held,
                reference=self.reference,
                stretch=self.stretch,
                applied=self.applied,
                felt=self.felt,
                energy=self.energy,
            )
        )

    def stored(self) -> FloatArray:
        """``(world,)`` [J]: what springs hold where body and references are now."""
        apart = self.reference[..., :2] - self.grips_in_world()
        turned = self.reference[..., 2] - self.world.pose[:, None, 2]
        linear = self.springs[..., 0] * np.square(apart).sum(axis=-1)
        return (linear + self.springs[..., 1] * turned**2).sum(axis=-1) / 2

    def kinetic(self) -> FloatArray:
        """``(world,)`` [J]."""
        mass, inertia = np.array([(body.mass, body.inertia) for body in self.bodies]).T
        twist = self.world.twist
        return (mass * np.square(twist[:, :2]).sum(axis=1) + inertia * twist[:, 2] ** 2) / 2
