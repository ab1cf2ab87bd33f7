"""Kinds of partners made of others: late, unsteady, changing, or one of several."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from coopenv.arrays import FloatArray, positive, stated_array
from coopenv.chance import Chance
from coopenv.errors import InvalidInput

from . import traits
from .kinds import Follower, Impedance, Leader, LoadSharing, Stubborn
from .person import Kind
from .traits import Span, Steps, checked_span, checked_steps, drawn, drawn_steps, highest


@dataclass(frozen=True, slots=True, kw_only=True)
class Lagging(Kind):
    """Somebody else, but late: what it does was right ``delay`` control steps ago."""

    partner: Kind = field(default_factory=Impedance)
    delay: Steps = 2  # [control steps], or drawn between two in every episode

    def __post_init__(self) -> None:
        _kind(self.partner, "partner.partner")
        object.__setattr__(self, "delay", checked_steps(self.delay, "partner.delay"))

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return self.partner.longest_delay + int(highest(self.delay))

    @property
    def needs_hands(self) -> bool:
        """As `Kind.needs_hands`."""
        return self.partner.needs_hands

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`."""
        rows = self.partner.traits(chance.branch("lagging"))
        rows[..., traits.DELAY] += drawn_steps(self.delay, chance, "delay")[:, None]
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

    @property
    def needs_hands(self) -> bool:
        """As `Kind.needs_hands`."""
        return self.partner.needs_hands

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

    @property
    def needs_hands(self) -> bool:
        """As `Kind.needs_hands`."""
        return self.first.needs_hands or self.second.needs_hands

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
        weights = stated_array(self.weights, "partner.weights")
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

    @property
    def needs_hands(self) -> bool:
        """As `Kind.needs_hands`."""
        return any(kind.needs_hands for kind in self.members)

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
    """One member of each kind; numbers given as a range are drawn in every episode."""
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
