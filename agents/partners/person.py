"""Scripted partners: what describes a kind of them, and the player that all kinds share."""

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.chance import Chance, draw_keys
from coopenv.compiled import compiled
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import rotated, wrapped
from coopenv.partner import Generators
from coopenv.physics.hands import SPEED
from coopenv.transition import Transition

from ..controllers.hand_motions import HandMotions
from . import traits
from .hands import Mind, act
from .parts import Parts
from .way import Way

_AWAY = slice(traits.AWAY_X, traits.AWAY_TURN + 1)


class Kind(ABC):
    """A partner that `Person` plays; subclass it only for other traits of the same model."""

    __slots__ = ()

    def player(self, config: TransportConfig, num_worlds: int, agents: tuple[int, ...]) -> "Person":
        """Somebody of this kind; see `coopenv.partner.Partner`."""
        return Person(self, config, num_worlds, agents)

    @property
    def longest_delay(self) -> int:
        """The most control steps by which it lags."""
        return 0

    @property
    def needs_hands(self) -> bool:
        """Whether it acts by what its hand feels, or by how far that goes ahead."""
        return False

    @abstractmethod
    def traits(self, chance: Chance) -> FloatArray:
        """What it is like in each episode that ``chance`` draws, ``(episode, 2, NUM_TRAITS)``."""


class Person:
    """Plays a `Kind` in a batch of worlds: draws what it is like, and remembers what it must.

    Where actions are motions, it moves the hands of those it drives so that they give what it
    wants to give, as far as they are quick enough (`coopenv.agents.controllers.hand_motions`).

    Parameters
    ----------
    what
        The kind.
    config
        Of the environment.
    num_worlds
        Worlds stepped together.
    agents
        Numbers of the agents it drives.

    Raises
    ------
    InvalidInput
        If the kind needs hands and none are there.
    """

    def __init__(
        self, what: Kind, config: TransportConfig, num_worlds: int, agents: tuple[int, ...]
    ):
        self.what, self._config, self._dt = what, config, config.dt
        self._driven = np.array(agents)
        self._mind = Mind(
            traits=np.zeros((num_worlds, 2, traits.NUM_TRAITS)),
            keys=np.zeros(num_worlds, dtype=np.uint64),
            now=np.zeros(num_worlds, dtype=np.int64),
            steps=np.zeros(num_worlds, dtype=np.int64),
            wanted_twist=np.zeros((num_worlds, 3)),
            given=np.zeros((num_worlds, what.longest_delay + 1, len(agents), 3)),
        )
        self._kind = np.zeros(num_worlds, dtype=np.int64)
        self._motions: HandMotions | None = None
        self.gives, self._nothing = "wrenches", (np.zeros((num_worlds, 0, 3)),) * 3
        if config.hands is not None:
            self._motions, self.gives = HandMotions(config, agents), "actions"
        elif what.needs_hands:
            raise InvalidInput(
                f"action must be 'motion' or 'impedance' for a partner that acts by what its hand "
                f"feels, got {config.action!r} for {what!r:.80}; choose one of them, or another "
                "partner"
            )
        self._parts = Parts(config, num_worlds, self._motions)
        self._reach = np.zeros(num_worlds)
        self._way: Way | None = None  # made when first somebody knows one

    @property
    def kind(self) -> IntArray:
        """``(world,)``: which of a population's members it is."""
        return self._kind

    def reset(self, worlds: IntArray, generators: Generators, start: Transition) -> None:
        """Begin an episode in ``worlds``; see `coopenv.partner.Player`."""
        keys = draw_keys(generators, worlds)
        rows = self.what.traits(Chance(keys))
        for now in range(2):
            rows[:, now, _AWAY] = _inside(rows[:, now, _AWAY], start)
        mind = self._mind
        mind.traits[worlds], mind.keys[worlds] = rows, keys
        mind.now[worlds], mind.steps[worlds], mind.wanted_twist[worlds] = 0, 0, 0
        mind.given[worlds] = 0
        self._kind = mind.traits[:, 0, traits.KIND].astype(np.int64)  # others may keep the old one
        self._reach[worlds] = np.hypot(*np.moveaxis(start.conditions.load.outline, -1, 0)).max(1)
        self._parts.hold(worlds, start.team)
        self._find_way(rows)

    def act(self, transition: Transition) -> FloatArray:
        """Wrenches or actions of hands for the next step; see `coopenv.partner.Player`."""
        state, team = transition.next_state, transition.team
        load, room, motions = transition.conditions.load, transition.conditions.room, self._motions
        stretch, springs, fastest = self._nothing
        if motions is not None:
            stretch = transition.stretch
            springs, fastest = motions.springs(team.hands), team.hands[..., SPEED:].copy()
        wrench = act(
            tuple(self._mind),
            (
                state.pose, state.twist, transition.state.twist, state.goal,
                self._ahead(transition), transition.applied, stretch,
            ),
            (
                load.mass, load.inertia, load.linear_drag, load.angular_drag, load.outline,
                self._reach, room.size, room.gravity,
            ),
            (
                team.grips, team.frame, team.limits, self._parts.straight, self._parts.on_way,
                self._driven, springs, fastest,
            ),
            self._dt,
        )  # fmt: skip
        return wrench if motions is None else motions(wrench, state.twist, transition)

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What it is like and remembers; see `coopenv.partner.StatefulPlayer`."""
        mind = {name: value[worlds] for name, value in self._mind._asdict().items()}
        return {"mind": mind, "parts": self._parts.get_state(worlds), "reach": self._reach[worlds]}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """See `coopenv.partner.StatefulPlayer`."""
        for name, value in self._mind._asdict().items():
            value[worlds] = state["mind"][name]
        self._reach[worlds] = state["reach"]
        self._parts.set_state(state["parts"], worlds)
        self._kind = self._mind.traits[:, 0, traits.KIND].astype(np.int64)
        self._find_way(state["mind"]["traits"])

    def _find_way(self, rows: FloatArray) -> None:
        """Find the way when for the first time one of ``rows`` knows one."""
        if self._way is None and np.isin(rows[..., traits.ROLE], traits.ON_WAY).any():
            self._way = Way(self._config)
            self._parts.walk(self._way)

    def plan(self, transition: Transition) -> FloatArray:
        """Poses ``(world, 3)`` it wants the object to reach; NaN where it follows."""
        return _plans(self._mind.traits, self._mind.now, transition.next_state.goal)

    def _ahead(self, transition: Transition) -> FloatArray:
        """Next points ``(world, 3)`` of the ways of those who know one; of others anything."""
        goal = transition.next_state.goal
        if self._way is None:
            return goal
        plan = self.plan(transition)
        return self._way.ahead(transition, np.where(np.isnan(plan), goal, plan))


@compiled
def _plans(rows, now, goal):
    plan = np.empty_like(goal)
    for k in range(len(goal)):
        row = rows[k, now[k]]
        role = row[traits.ROLE]
        planned = role == traits.PLANS or role == traits.WALKS or role == traits.GUIDES
        for j in range(3):
            moved = goal[k, j] + row[traits.AWAY_X + j]
            plan[k, j] = moved if planned else np.nan
        if row[traits.AWAY_TURN] != 0:  # an unturned goal is kept to the bit
            plan[k, 2] = wrapped(plan[k, 2])
    return plan


def _inside(away: FloatArray, start: Transition) -> FloatArray:
    """Offsets ``(world, 3)`` mirrored, or where that does not help cut, to stay in the room."""
    goal, half = start.next_state.goal, start.conditions.room.size / 2
    angle = (goal[:, 2] + away[:, 2])[:, None]
    x, y = np.moveaxis(start.conditions.load.outline, -1, 0)
    turned = np.stack(rotated(np.cos(angle), np.sin(angle), x, y))
    low = -half - turned.min(axis=2).T - goal[:, :2]
    high = half - turned.max(axis=2).T - goal[:, :2]
    shift = away[:, :2]
    out, back = (shift < low) | (shift > high), (-shift >= low) & (-shift <= high)
    cut = np.clip(shift, np.minimum(low, high), np.maximum(low, high))
    placed = np.where(out & away.any(axis=1, keepdims=True), np.where(back, -shift, cut), shift)
    return np.concatenate([placed, away[:, 2:]], axis=1)
