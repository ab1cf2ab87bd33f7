"""Simulated people who carry a beam in pairs: what each is like, and what their hands do.

Each has an own plan, and hands with an impedance and a reaction delay of their own: they are
`coopenv.agents.partners.Person` with every trait given, who walks through the doorway to its own
goal as the partner `Walking` does.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from coopenv.arrays import BoolArray, FloatArray, Range
from coopenv.chance import Chance
from coopenv.config import TransportConfig
from coopenv.transition import Transition
from coopenv.wrench.grasp import moment

from ...controllers.guidance import APPROACH, DAMPING, NUM_GAINS, SPEED, SPIN, gains_row
from ...partners import traits
from ...partners.person import Kind, Person
from ...partners.way import PACE


@dataclass(frozen=True, slots=True, kw_only=True)
class People:
    """How people differ: each number is drawn once a person and kept over all its trials.

    Two numbers are the ends of a uniform distribution, one is the standard deviation of a normal
    one about 0. None was fitted to the human study, which does not report them.
    """

    approach: Range = (1.4, 2.6)  # [1/s] wanted velocity per way left to the next point of the way
    damping: Range = (2.5, 5.0)  # [1/s] impedance: acceleration per velocity that is missing
    speed: Range = (0.5, 0.9)  # [m/s] at most
    spin: Range = (0.7, 1.3)  # [rad/s] at most
    delay: Range = (0.1, 0.2)  # [s] from what is seen to the hand, in whole control steps
    strength: Range = (0.6, 1.4)  # preferred load: times half of the wrench that the plan needs
    yielding: Range = (0.1, 0.5)  # [rad/s per N·m] of who is not told, to unexpected torque
    force_tremor: Range = (0.2, 0.6)  # [N] of the hand, white, each component and control step
    torque_tremor: Range = (0.02, 0.06)  # [N·m] likewise
    place: float = 0.05  # [m] preferred place beside the goal, along x and y
    reading: float = 0.05  # [rad] how the angle that is told is misread
    habit: float = 0.4  # [rad] preferred turn from the start of who is not told

    def __post_init__(self) -> None:
        for entry in fields(self):
            traits.checked_span(getattr(self, entry.name), f"people.{entry.name}")

    def draw(self, seed: int, num_pairs: int) -> "Traits":
        """Two people a pair, each pair from a generator of its own."""
        pairs = [self._pair(np.random.default_rng([seed, 5, k])) for k in range(num_pairs)]
        return Traits(**{name: np.stack([pair[name] for pair in pairs]) for name in pairs[0]})

    def _pair(self, generator: np.random.Generator) -> dict[str, FloatArray]:
        drawn = {}
        for entry in fields(self):
            span = getattr(self, entry.name)
            if isinstance(span, tuple):
                drawn[entry.name] = generator.uniform(span[0], span[1], 2)
            else:
                shape = (2, 2) if entry.name == "place" else 2
                drawn[entry.name] = span * generator.standard_normal(shape)
        return drawn


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Traits:
    """People as drawn, ``(row, 2)`` each, ``place`` ``(row, 2, 2)``; units as in `People`."""

    approach: FloatArray
    damping: FloatArray
    speed: FloatArray
    spin: FloatArray
    delay: FloatArray
    strength: FloatArray
    yielding: FloatArray
    force_tremor: FloatArray
    torque_tremor: FloatArray
    place: FloatArray
    reading: FloatArray
    habit: FloatArray

    def __getitem__(self, rows) -> "Traits":
        return Traits(**{entry.name: getattr(self, entry.name)[rows] for entry in fields(self)})

    def hands(self, agent: int, dt: float) -> "Hands":
        """One person of each row as a kind of partner."""
        rows = traits.same_twice(
            len(self.delay),
            role=traits.WALKS,
            strength=self.strength[:, agent],
            delay=np.rint(self.delay[:, agent] / dt),
            force_noise=self.force_tremor[:, agent],
            torque_noise=self.torque_tremor[:, agent],
        )
        rows[..., traits.GAINS : traits.GAINS + NUM_GAINS] = gains_row(PACE)
        own = {APPROACH: self.approach, DAMPING: self.damping, SPEED: self.speed, SPIN: self.spin}
        for gain, value in own.items():
            rows[..., traits.GAINS + gain] = value[:, agent, None]
        return Hands(rows=rows)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Hands(Kind):
    """Traits given for every world, instead of drawn for every episode."""

    rows: FloatArray  # (world, 2, NUM_TRAITS)

    @property
    def longest_delay(self) -> int:
        """As `Kind.longest_delay`."""
        return int(self.rows[..., traits.DELAY].max())

    def traits(self, chance: Chance) -> FloatArray:
        """As `Kind.traits`; only for all worlds at once."""
        return self.rows.copy()


class Pairs:
    """Two people a world carry the beam.

    A person who is told the goal's angle plans with that angle. A person who is not told plans
    with the angle of the start plus a habitual turn, and yields to unexpected torque. The expected
    torque of the partner, at the centre of mass, equals the person's own. The planned angle moves
    at ``yielding`` times half the difference of the two.

    Parameters
    ----------
    config
        Of the environment, with a `coopenv.DoorwayTask`.
    people
        One row a world.
    told
        ``(world, 2)``: who is told the goal's angle.
    """

    def __init__(self, config: TransportConfig, people: Traits, told: BoolArray):
        self._people, self._told, self._dt = people, told, config.dt
        self._players = [
            Person(people.hands(agent, config.dt), config, len(told), (agent,))
            for agent in range(2)
        ]
        self.goals = np.zeros((len(told), 2, 3))  # of each person, world frame [m, rad]

    def reset(self, start: Transition, generators) -> None:
        """Begin a trial in every world."""
        state, people = start.next_state, self._people
        for player in self._players:
            player.reset(np.arange(len(self._told)), generators, start)
        self.goals[..., :2] = state.goal[:, None, :2] + people.place
        guess = state.pose[:, None, 2] + people.habit
        self.goals[..., 2] = np.where(self._told, state.goal[:, None, 2] + people.reading, guess)

    def act(self, transition: Transition) -> FloatArray:
        """Wrenches ``(world, 2, 3)`` for the next step, object frame [N, N·m]."""
        self._give_in(transition)
        wrenches = [
            player.act(_towards(transition, self.goals[:, agent]))
            for agent, player in enumerate(self._players)
        ]
        return np.concatenate(wrenches, axis=1)

    def _give_in(self, transition: Transition) -> None:
        applied = transition.applied
        torque = moment(transition.team.grips, applied)[..., 0]
        torque = torque + applied[..., 2]  # (world, agent) at the centre of mass [N·m]
        surprise = (torque[:, ::-1] - torque) / 2
        turn = self._dt * self._people.yielding * surprise
        self.goals[..., 2] += np.where(self._told, 0.0, turn)


def _towards(transition: Transition, goal: FloatArray) -> Transition:
    """The same, as if the goal were this one."""
    own = np.ascontiguousarray(goal)  # as everybody's goal is, for which kernels are compiled
    return replace(transition, next_state=replace(transition.next_state, goal=own))
