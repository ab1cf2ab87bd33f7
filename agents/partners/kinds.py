"""Kinds of partners with one behaviour: frozen descriptions that draw traits for every episode."""

from dataclasses import dataclass, field

import numpy as np

from coopenv.arrays import FloatArray, positive
from coopenv.chance import Chance
from coopenv.errors import InvalidInput

from ..controllers.guidance import NUM_GAINS, Gains, gains_row
from . import traits
from .person import Kind
from .traits import Span, checked_span, drawn, own_plan, same_twice


@dataclass(frozen=True, slots=True, kw_only=True)
class Impedance(Kind):
    """Leads the object to its own plan as the scripted controller would, and gives its own part.

    The plan is the task's goal, moved by ``offset`` in a direction drawn for the episode and
    turned by ``turn`` to a side drawn for it: its disagreement is known exactly. A plan that would
    lie in a wall of the room is mirrored to the other side of the goal.

    It knows the room's walls, but neither obstacles nor wheels, and heads straight for its plan. In
    `BeamDoorway` it therefore leads against the wall beside the gap, and it cannot steer a walker;
    `Walking` knows the way.

    With no offset it does what one hand of `coopenv.agents.controllers.ImpedanceController` does.
    Whatever it feels changes nothing.
    """

    offset: Span = 0.0  # [m] from the task's goal to its own
    turn: Span = 0.0  # [rad] likewise
    strength: float = 1.0  # times its part of the wrench that the object needs
    gains: Gains = field(default_factory=Gains)

    def __post_init__(self) -> None:
        _set = object.__setattr__
        _set(self, "offset", checked_span(self.offset, "partner.offset"))
        _set(self, "turn", checked_span(self.turn, "partner.turn", high=np.pi))
        _set(self, "strength", positive(self.strength, "partner.strength"))
        if not isinstance(self.gains, Gains):
            raise InvalidInput(f"partner.gains must be Gains, got {self.gains!r}; pass Gains(...)")

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        rows = same_twice(
            len(chance),
            role=traits.PLANS,
            strength=self.strength,
            **own_plan(self.offset, self.turn, chance),
        )
        rows[..., traits.GAINS : traits.GAINS + NUM_GAINS] = gains_row(self.gains)
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Leader(Impedance):
    """Knows where to go and pulls twice its part, so that the other needs only to come along."""

    strength: float = 2.0  # times its part of the wrench that the object needs


@dataclass(frozen=True, slots=True, kw_only=True)
class Stubborn(Impedance):
    """Holds a plan of its own with all its strength, whatever it feels."""

    offset: Span = 0.5  # [m] from the task's goal to its own
    turn: Span = 0.5  # [rad] likewise
    strength: float = 4.0  # times its part of the wrench that the object needs


@dataclass(frozen=True, slots=True, kw_only=True)
class Follower(Kind):
    """Has no plan and yields to what it feels: an admittance.

    It feels, through the motion of its hand, what moves the object beside itself,
    h_felt = M v̇ + D v − h_own (so a wall as well as a person), lets a lighter object of
    ``heaviness`` times the mass and drag answer it, and does its part to move the real one so.
    Who leads it feels that fraction of the load.
    """

    heaviness: Span = 0.5  # of mass, inertia and drag; 1 leaves all of it to the other
    eagerness: float = 10.0  # [1/s] acceleration per unit of velocity that is missing

    def __post_init__(self) -> None:
        _set = object.__setattr__
        heaviness = checked_span(self.heaviness, "partner.heaviness", low=0.05, high=1.0)
        _set(self, "heaviness", heaviness)
        _set(self, "eagerness", positive(self.eagerness, "partner.eagerness"))

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        return same_twice(
            len(chance),
            role=traits.FOLLOWS,
            heaviness=drawn(self.heaviness, chance, "heavy"),
            eagerness=self.eagerness,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadSharing(Kind):
    """Has no plan and carries a wanted share of the load, whoever decides where it goes.

    It answers what it feels (as `Follower`) with share / (1 − share) of it, force and torque at
    the centre of mass alike, which makes its load share (eq. 25) what was wanted, as far as its
    limits go and one control step late.
    """

    share: Span = 0.5  # of force and torque

    def __post_init__(self) -> None:
        share = checked_span(self.share, "partner.share", high=0.9)
        object.__setattr__(self, "share", share)

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        return same_twice(len(chance), role=traits.SHARES, share=drawn(self.share, chance, "share"))
