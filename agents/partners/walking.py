"""Partners that know the way: a person who walks along it, and a robot that does so exactly."""

from dataclasses import dataclass, fields

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.chance import Chance

from ..controllers.guidance import APPROACH, DAMPING, NUM_GAINS, SPEED, SPIN, gains_row
from . import traits
from .person import Kind
from .traits import Span, Steps, checked_span, checked_steps, drawn, drawn_steps, own_plan
from .way import PACE


@dataclass(frozen=True, slots=True, kw_only=True)
class Walking(Kind):
    """A person who plans along the task's way, with an impedance, a delay and a tremor.

    The way is what the task's scripted controller aims for, at a walking pace: through the gap of a
    doorway, round the obstacles of a walker, along a reference. A body on wheels is pushed by agent
    0 and turned by the last agent; anything else is carried by everybody's part of the
    pseudoinverse (eq. 7). Turning a walker against its drag asks for more exact a hand than most
    people have: who is to be its drive had better be a `Robot`.

    Everybody differs: numbers given as two are drawn between them in every episode. The defaults
    are those of the simulated people of `coopenv.agents.studies.dyads.people`, at control steps of
    0.05 s; none was fitted to recorded people.
    """

    offset: Span = 0.0  # [m] from the task's goal to its own, as `Impedance`
    turn: Span = 0.0  # [rad] likewise
    approach: Span = (1.4, 2.6)  # [1/s] wanted velocity per way left to the next point of the way
    damping: Span = (2.5, 5.0)  # [1/s] impedance: acceleration per velocity that is missing
    speed: Span = (0.5, 0.9)  # [m/s] at most
    spin: Span = (0.7, 1.3)  # [rad/s] at most
    delay: Steps = (2, 4)  # [control steps] from what is seen to the hand
    strength: Span = (0.6, 1.4)  # times its part of the wrench that the object needs
    force_tremor: Span = (0.2, 0.6)  # [N] of the hand, white, each component and control step
    torque_tremor: Span = (0.02, 0.06)  # [N·m] likewise

    def __post_init__(self) -> None:
        positive = ("approach", "damping", "speed", "spin", "strength")
        for entry in fields(self):
            name, value = f"partner.{entry.name}", getattr(self, entry.name)
            if entry.name == "delay":
                read = checked_steps(value, name)
            else:
                low = 0.01 if entry.name in positive else 0.0
                high = np.pi if entry.name == "turn" else np.inf
                read = checked_span(value, name, low=low, high=high)
            object.__setattr__(self, entry.name, read)

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return int(traits.highest(self.delay))

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        rows = traits.same_twice(
            len(chance),
            role=traits.WALKS,
            strength=drawn(self.strength, chance, "strength"),
            force_noise=drawn(self.force_tremor, chance, "force tremor"),
            torque_noise=drawn(self.torque_tremor, chance, "torque tremor"),
            delay=drawn_steps(self.delay, chance, "delay"),
            **own_plan(self.offset, self.turn, chance),
        )
        rows[..., traits.GAINS : traits.GAINS + NUM_GAINS] = gains_row(PACE)
        for gain, name in (
            (APPROACH, "approach"),
            (DAMPING, "damping"),
            (SPEED, "speed"),
            (SPIN, "spin"),
        ):
            own = drawn(getattr(self, name), chance, name)
            rows[..., traits.GAINS + gain] = own[:, None]
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot(Walking):
    """A machine that goes the same way: always alike, prompt, steady, and as stiff as it should be.

    As the last agent of a walker (``partner_agents=(1,)``) it is the drive.
    """

    approach: Span = 2.0  # [1/s] wanted velocity per way left to the next point of the way
    damping: Span = 10.0  # [1/s] impedance: acceleration per velocity that is missing
    speed: Span = 0.7  # [m/s] at most
    spin: Span = 1.0  # [rad/s] at most
    delay: Steps = 0  # [control steps] from what is seen to the hand
    strength: Span = 1.0  # times its part of the wrench that the object needs
    force_tremor: Span = 0.0  # [N]
    torque_tremor: Span = 0.0  # [N·m]
