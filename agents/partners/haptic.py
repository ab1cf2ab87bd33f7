"""Kinds of partners that act by what their hands feel: who gives way, and who shows the way."""

from dataclasses import dataclass, fields

import numpy as np

from coopenv.arrays import LARGEST, FloatArray
from coopenv.chance import Chance

from ..controllers.guidance import APPROACH, NUM_GAINS, SPEED, SPIN, gains_row
from . import traits
from .person import Kind
from .traits import Span, checked_span, drawn, own_plan, same_twice
from .way import PACE


@dataclass(frozen=True, slots=True, kw_only=True)
class Compliant(Kind):
    """Knows no goal: its hand goes with its grip, and gives way to what it feels.

        u = v − c (f − w),    Ω = ω − c_t (t − w_t)

    with v, ω what its grip will move with in the middle of the step, if it goes on speeding up as
    in the last, f, t what it gives at the step's end, going so, and w its part of the weight. So
    the stretch of its hand, beyond what bears w, fades in a step to

        (1 + c B) / (1 + c B + c K dt)

    of itself, never past zero, and who leads it finds it light. Until it has faded, its reference
    goes with the grip: it pulls the object on, or holds it back, with what is left of its wrench.
    Whatever pushes it back, it takes for the other's wish.

    It needs hands (``action="motion"`` or ``"impedance"``).
    """

    yielding: Span = 0.02  # c [m/s/N]
    turn_yielding: Span = 0.15  # c_t [rad/s/(N·m)]

    def __post_init__(self) -> None:
        for name in ("yielding", "turn_yielding"):
            span = checked_span(getattr(self, name), f"partner.{name}", high=LARGEST)
            object.__setattr__(self, name, span)

    @property
    def needs_hands(self) -> bool:
        """As `Kind.needs_hands`."""
        return True

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        return same_twice(
            len(chance),
            role=traits.YIELDS,
            yielding=drawn(self.yielding, chance, "yielding"),
            turn_yielding=drawn(self.turn_yielding, chance, "turn yielding"),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Guiding(Kind):
    """Knows the way, and shows it by pulling: firmer, the less it is followed.

    Its hand goes on along the way as if the object came along (as `Walking`: through the gap of a
    doorway, round a walker's obstacles), whether it does or not. So its lead, which is what the
    other feels, grows by what the object lags behind, up to a bound, and fades by itself:

        s ← P(s + dt (v_d − v − λ s))

    with v_d the motion of the plan at its grip, v that of the grip, and P the nearest within
    ``lead`` and ``turn_lead``. It bears its part of the weight besides, and leaves the load to be
    shared as the other likes.

    It needs hands (``action="motion"`` or ``"impedance"``).
    """

    offset: Span = 0.0  # [m] from the task's goal to its own, as `Impedance`
    turn: Span = 0.0  # [rad] likewise
    approach: Span = 2.0  # [1/s] wanted velocity per way left to the next point of the way
    speed: Span = 0.7  # [m/s] at most
    spin: Span = 1.0  # [rad/s] at most
    lead: Span = 0.2  # [m] of the hand before its grip at most; times stiffness: how firm
    turn_lead: Span = 0.4  # [rad] likewise
    easing: Span = 1.0  # λ [1/s] with which the lead fades

    def __post_init__(self) -> None:
        for entry in fields(self):
            name = entry.name
            low = 0.0 if name in ("offset", "turn", "turn_lead", "easing") else 0.01
            high = np.pi if name in ("turn", "turn_lead") else np.inf
            span = checked_span(getattr(self, name), f"partner.{name}", low=low, high=high)
            object.__setattr__(self, name, span)

    @property
    def needs_hands(self) -> bool:
        """As `Kind.needs_hands`."""
        return True

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        rows = same_twice(
            len(chance),
            role=traits.GUIDES,
            lead=drawn(self.lead, chance, "lead"),
            turn_lead=drawn(self.turn_lead, chance, "turn lead"),
            easing=drawn(self.easing, chance, "easing"),
            **own_plan(self.offset, self.turn, chance),
        )
        rows[..., traits.GAINS : traits.GAINS + NUM_GAINS] = gains_row(PACE)
        for gain, name in ((APPROACH, "approach"), (SPEED, "speed"), (SPIN, "spin")):
            rows[..., traits.GAINS + gain] = drawn(getattr(self, name), chance, name)[:, None]
        return rows
