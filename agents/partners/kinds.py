"""The kinds of partners: frozen descriptions that draw their traits for every episode."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from coopenv.arrays import FloatArray, finite_array, positive, whole
from coopenv.chance import Chance
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput

from ..controllers.guidance import NUM_GAINS, gains_row
from ..controllers.impedance import Gains
from . import traits
from .traits import Span, checked_span, drawn, highest, same_twice

if TYPE_CHECKING:
    from .person import Person


class Kind(ABC):
    """A partner that `Person` plays; subclass it only for other traits of the same model."""

    __slots__ = ()

    def player(self, config: TransportConfig, num_worlds: int, agents: tuple[int, ...]) -> "Person":
        """Somebody of this kind; see `coopenv.partner.Partner`."""
        from .person import Person

        return Person(self, config, num_worlds, agents)

    @property
    def longest_delay(self) -> int:
        """The most control steps by which it lags."""
        return 0

    @abstractmethod
    def traits(self, chance: Chance) -> FloatArray:
        """What it is like in each episode that ``chance`` draws, ``(episode, 2, NUM_TRAITS)``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Impedance(Kind):
    """Leads the object to its own plan as the scripted controller would, and gives its own part.

    The plan is the task's goal, moved by ``offset`` in a direction drawn for the episode and
    turned by ``turn`` to a side drawn for it: its disagreement is known exactly. A plan that would
    lie in a wall of the room is mirrored to the other side of the goal.

    It knows the room, not what stands in it and not wheels: it heads straight for its plan, so in
    `BeamDoorway` it leads against the wall beside the gap, and a walker it does not steer.

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

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        away = drawn(self.offset, chance, "offset")
        direction = 2 * np.pi * chance.uniform("bearing")
        side = np.where(chance.uniform("side") < 0.5, -1.0, 1.0)
        rows = same_twice(
            len(chance),
            role=traits.PLANS,
            away_x=away * np.cos(direction),
            away_y=away * np.sin(direction),
            away_turn=side * drawn(self.turn, chance, "turn"),
            strength=self.strength,
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Lagging(Kind):
    """Somebody else, but late: what it does was right ``delay`` control steps ago."""

    partner: Kind = field(default_factory=Impedance)
    delay: int | tuple[int, int] = 2  # [control steps], or drawn between two in every episode

    def __post_init__(self) -> None:
        _kind(self.partner, "partner.partner")
        checked_span(self.delay, "partner.delay")
        for end in self.delay if isinstance(self.delay, Sequence) else (self.delay,):
            whole(end, "partner.delay", at_least=0)

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return self.partner.longest_delay + int(highest(self.delay))

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        low, high = self.delay if isinstance(self.delay, Sequence) else (self.delay, self.delay)
        rows = self.partner.traits(chance.branch("lagging"))
        rows[..., traits.DELAY] += np.floor(drawn((low, high + 1), chance, "delay"))[:, None]
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Noisy(Kind):
    """Somebody else with an unsteady hand: white noise on every control step's wrench."""

    partner: Kind = field(default_factory=Impedance)
    force: Span = 2.0  # [N] standard deviation of each component
    torque: Span = 1.0  # [N·m]

    def __post_init__(self) -> None:
        _kind(self.partner, "partner.partner")
        for name in ("force", "torque"):
            span = checked_span(getattr(self, name), f"partner.{name}")
            object.__setattr__(self, name, span)

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return self.partner.longest_delay

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        rows = self.partner.traits(chance.branch("noisy"))
        for column, span in (
            (traits.FORCE_NOISE, self.force),
            (traits.TORQUE_NOISE, self.torque),
        ):
            more = drawn(span, chance, f"noise{column}")[:, None]
            rows[..., column] = np.hypot(rows[..., column], more)  # of independent noises
        return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Switching(Kind):
    """Two in one: begins as either, and becomes the other at random times.

    The times between are independent and memoryless, ``mean_time`` on average.
    """

    first: Kind = field(default_factory=Leader)
    second: Kind = field(default_factory=Follower)
    mean_time: float = 1.5  # [s]

    def __post_init__(self) -> None:
        for name in ("first", "second"):
            kind = _kind(getattr(self, name), f"partner.{name}")
            if _switches(kind):
                raise InvalidInput(
                    f"partner.{name} must not switch itself, got {kind!r}; name the two roles"
                )
        object.__setattr__(self, "mean_time", positive(self.mean_time, "partner.mean_time"))

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return max(self.first.longest_delay, self.second.longest_delay)

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        rows = self.first.traits(chance.branch("first"))
        rows[:, 1] = self.second.traits(chance.branch("second"))[:, 0]
        rows[..., traits.STAY] = self.mean_time
        return np.where(chance.uniform("begin")[:, None, None] < 0.5, rows, rows[:, ::-1])


@dataclass(frozen=True, slots=True, kw_only=True)
class Population(Kind):
    """One of several, drawn anew for every episode of every world."""

    members: tuple[Kind, ...] = field(default_factory=lambda: _everybody())
    weights: tuple[float, ...] | None = None  # how often each, relative; None: all alike

    def __post_init__(self) -> None:
        _set = object.__setattr__
        if not isinstance(self.members, Sequence) or not self.members:
            raise InvalidInput(
                f"partner.members must be a sequence of partners, got {self.members!r}; "
                "pass for example (Leader(), Follower())"
            )
        _set(self, "members", tuple(_kind(kind, "partner.members") for kind in self.members))
        if self.weights is None:
            return
        weights = finite_array(self.weights, "partner.weights")
        if weights.shape != (len(self.members),) or (weights < 0).any() or weights.sum() == 0:
            raise InvalidInput(
                f"partner.weights must be zero or positive, one for each of {len(self.members)} "
                f"members and not all zero, got {self.weights!r}; change them"
            )
        _set(self, "weights", tuple(weights.tolist()))

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return max(kind.longest_delay for kind in self.members)

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        weights = np.ones(len(self.members)) if self.weights is None else np.array(self.weights)
        bounds = np.cumsum(weights)[:-1] / weights.sum()
        member = np.searchsorted(bounds, chance.uniform("member"), side="right")
        rows = np.empty((len(chance), 2, traits.NUM_TRAITS))
        for number, kind in enumerate(self.members):
            mine = member == number
            if mine.any():
                rows[mine] = kind.traits(Chance(chance.branch("of it").keys[mine]))
        rows[..., traits.KIND] = member[:, None]
        return rows


def _everybody() -> tuple[Kind, ...]:
    """One of each kind, those with a number to it over a range of it."""
    return (
        Impedance(offset=(0.0, 0.5), turn=(0.0, 0.5)),
        Leader(),
        Follower(),
        Lagging(delay=(1, 4)),
        Noisy(),
        Stubborn(),
        LoadSharing(share=(0.2, 0.6)),
        Switching(),
    )


def _kind(value: object, name: str) -> Kind:
    if not isinstance(value, Kind):
        raise InvalidInput(
            f"{name} must be a partner of coopenv.agents.partners, got {value!r}; "
            "pass for example Follower()"
        )
    return value


def _switches(kind: Kind) -> bool:
    if isinstance(kind, Lagging | Noisy):
        return _switches(kind.partner)
    if isinstance(kind, Population):
        return any(_switches(member) for member in kind.members)
    return isinstance(kind, Switching)
