"""Configuration of the simulated human study: how many people, what they carry, where."""

from dataclasses import dataclass, field

from coopenv.arrays import positive, whole
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.physics.body import Body
from coopenv.physics.scene import Scene
from coopenv.tasks import DoorwayTask

from .people import People

WINDOW = 0.6  # [s] from the start of a trial, over which T_I is averaged


@dataclass(frozen=True, slots=True, kw_only=True)
class DyadsConfig:
    """The simulated study."""

    pairs: int = 12
    """Pairs of people."""
    trials: int = 10
    """Trials of each pair with each guide."""
    people: People = field(default_factory=People)
    """How people differ."""
    seconds: float = 20.0
    """After which a trial is broken off [s], unless the beam rests on the final platform before."""
    dt: float = 0.02
    """Control step, and the time between samples [s]."""
    mass: float = 7.7
    """Of the beam [kg]."""
    seed: int = 0
    """Of people and rooms."""

    def __post_init__(self) -> None:
        for name in ("pairs", "trials"):
            whole(getattr(self, name), name, at_least=1)
        for name in ("seconds", "dt", "mass"):
            positive(getattr(self, name), name)
        steps = WINDOW / self.dt
        if abs(steps - round(steps)) > 1e-6 or self.seconds < 2 * WINDOW:
            raise InvalidInput(
                f"dt must divide {WINDOW} s, and seconds be at least {2 * WINDOW}, got {self.dt} "
                f"and {self.seconds}; take 0.02 s"
            )

    @property
    def environment(self) -> TransportConfig:
        """The doorway; people see it themselves, whatever the task's guide says."""
        return TransportConfig(
            body=Body.beam(mass=self.mass, inertia=self.mass * 2.0**2 / 12),
            scene=Scene(size=(7.0, 4.0)),
            task=DoorwayTask(position_tolerance=1e-9, speed_tolerance=1e-9),  # no early end
            observe=("goal",),
            force_limit=100.0,
            torque_limit=30.0,
            dt=self.dt,
            horizon=round(self.seconds / self.dt),
        )
