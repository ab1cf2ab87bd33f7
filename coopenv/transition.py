"""State and transition: a control step of every world, as rewards and observations see it."""

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, with_rows
from coopenv.conditions import Conditions, Team
from coopenv.errors import InvalidInput
from coopenv.geometry import frames
from coopenv.measured import SHARES, measured, split_and_measured
from coopenv.physics.surroundings import acting
from coopenv.power import Power, power_over
from coopenv.wrench import Decomposition, LoadShare, Settings
from coopenv.wrench.shares import ShareOrEven, share_of_load, share_or_even
from coopenv.wrench.surroundings import with_surroundings


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class State:
    """Where every world is; world frame, origin at the room's centre."""

    pose: FloatArray  # (world, 3): x, y [m], θ wrapped to (−π, π] [rad]
    twist: FloatArray  # (world, 3): its rate [m/s, rad/s]
    goal: FloatArray  # (world, 3): as pose
    distance: FloatArray  # (world,): the task's distance to its goal [m]
    time: FloatArray  # (world,): since the episode began [s]


@dataclass(frozen=True, kw_only=True, eq=False)
class Transition:
    """One control step of every world, from ``state`` to ``next_state``.

    Wrenches are in the object frame, which is also the frame they were held in. What hands gave
    changes within the step: ``applied`` is its mean over the substeps. ``stretch``, ``felt_wrench``
    and ``stored_energy`` are of hands and as they are at the end; ``None`` without hands. Behind
    actuators, ``applied`` comes of what acts and not of ``action``. After a reset, ``state`` is
    ``next_state`` and nothing was applied.

    Under settings with surroundings a decomposition has one effector more than there are agents,
    its last: `of_agents` takes the others' rows.
    """

    state: State
    next_state: State
    conditions: Conditions  # what holds for the whole episode
    action: FloatArray  # (world, agent, a), as commanded, clipped to [−1, 1], agent frame
    previous_action: FloatArray  # as action; zero at the first step of an episode
    applied: FloatArray  # (world, agent, 3) [N, N·m]
    contact_impulse: FloatArray  # (world,) [N·s] from walls and obstacles
    contact_shift: FloatArray  # (world,) [m] that parting of overlaps moved the body
    surroundings_wrench: FloatArray  # (world, 3) of contacts and wheels at the centre of mass, mean
    wheel_force: FloatArray  # (world,) [N] what of it wheels give, along the object's y
    success: BoolArray  # (world,)
    terminated: BoolArray  # (world,)
    truncated: BoolArray  # (world,)
    dt: float  # [s]
    horizon: int  # control steps in an episode
    stretch: FloatArray | None = None  # (world, agent, 3) grip to reference, object frame [m, rad]
    felt_wrench: FloatArray | None = None  # (world, agent, 3) at the end, object frame [N, N·m]
    stored_energy: FloatArray | None = None  # (world, agent) in springs [J]
    _decompositions: dict[Settings, Decomposition] = field(
        init=False, default_factory=dict, repr=False
    )
    _own: list[Decomposition] = field(init=False, default_factory=list, repr=False)
    _measured: list[tuple[FloatArray, BoolArray]] = field(
        init=False, default_factory=list, repr=False
    )
    _shares: list[ShareOrEven] = field(init=False, default_factory=list, repr=False)
    _power: list[Power] = field(init=False, default_factory=list, repr=False)

    @classmethod
    def start(
        cls, state: State, conditions: Conditions, *, action_size: int, dt: float, horizon: int
    ) -> "Transition":
        """The transition at the start of an episode, which led to nothing yet."""
        hands = conditions.team.hands.shape[-1] > 0
        count, num_agents = conditions.team.grips.shape[:2]
        action = np.zeros((count, num_agents, action_size))
        no = np.zeros(count, dtype=np.bool_)
        return cls(
            state=state,
            next_state=state,
            conditions=conditions,
            action=action,
            previous_action=action,
            applied=np.zeros((count, num_agents, 3)),
            contact_impulse=np.zeros(count),
            contact_shift=np.zeros(count),
            surroundings_wrench=np.zeros((count, 3)),
            wheel_force=np.zeros(count),
            success=no,
            terminated=no,
            truncated=no,
            dt=dt,
            horizon=horizon,
            stretch=np.zeros((count, num_agents, 3)) if hands else None,
            felt_wrench=np.zeros((count, num_agents, 3)) if hands else None,
            stored_energy=np.zeros((count, num_agents)) if hands else None,
        )

    @classmethod
    def of_step(cls, **entries: Any) -> "Transition":
        """As the constructor, of which every field without a default must be given.

        The core makes one in every step, and the constructor of a frozen class sets its fields
        slowly.
        """
        made = object.__new__(cls)
        entries.update(_decompositions={}, _own=[], _measured=[], _shares=[], _power=[])
        object.__setattr__(made, "__dict__", entries)
        return made

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, **_nothing_computed()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(_nothing_computed(), **state)

    @property
    def team(self) -> Team:
        """The effectors."""
        return self.conditions.team

    @property
    def decomposition(self) -> Decomposition:
        """Decomposition of ``applied`` under the environment's settings."""
        if not self._own:
            team = self.team
            _require_fit(self.applied, team.grips)
            if team.settings.surroundings:
                made, found = self._decomposed(None, team.settings), None
            else:
                made, found = split_and_measured(team.decomposer(), self.applied, team.grips)
            self._own.append(made)
            self._measure(made, found)
        return self._own[0]

    @property
    def measures(self) -> FloatArray:
        """Levels of `decomposition`, then `share_or_even`, ``(world, 6 + 2 agents)``.

        The columns are those of `coopenv.measured.measured`.
        """
        decomposition = self.decomposition
        if not self._measured:
            self._measure(decomposition)
        return self._measured[0][0]

    def _measure(
        self, decomposition: Decomposition, found: tuple[FloatArray, BoolArray] | None = None
    ) -> None:
        """Compute levels and shares together: who asks for one will want the other."""
        if found is None:
            team = self.team
            grips = decomposition.grips if team.settings.surroundings else team.grips
            found = measured(decomposition, grips, self.applied.shape[1])
        decomposition.take_levels(found[0][:, :SHARES])
        self._measured.append(found)

    def decompose(self, settings: Settings) -> Decomposition:
        """Decomposition of ``applied`` under other settings; computed once a step for each."""
        if settings == self.team.settings:
            return self.decomposition
        found = self._decompositions.get(settings)
        if found is None:
            found = self._decomposed(settings, settings)
            self._decompositions[settings] = found
        return found

    def _decomposed(self, asked: Settings | None, settings: Settings) -> Decomposition:
        agents = self.team.decomposer(asked)
        if not settings.surroundings:
            return agents(self.applied)
        return with_surroundings(agents, settings, self.applied, *self._surroundings())

    def _surroundings(self) -> tuple[FloatArray, FloatArray]:
        """What surroundings give as an effector ``(world, 3)``, and where ``(world, 2)`` [m]."""
        given, wheels = self.surroundings_wrench, self.wheel_force
        arrays = (np.ascontiguousarray(array) for array in (given, wheels))
        return acting(*arrays, self.conditions.load.outline)

    def of_agents(self, rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The agents' rows ``(world, agent, …)`` of what a decomposition has of each effector."""
        num_agents = self.applied.shape[1]
        return rows if rows.shape[1] == num_agents else rows[:, :num_agents].copy()

    @property
    def load_share(self) -> LoadShare:
        """Each agent's share of what the agents apply together, whatever surroundings give."""
        return share_of_load(self.applied, self.team.decomposer().grips)

    @property
    def share_or_even(self) -> ShareOrEven:
        """`load_share` with 1/n in place of NaN, and whether shares are defined."""
        if not self._shares:
            if self._measured:
                rows, defined = self._measured[0]
                half = SHARES + self.applied.shape[1]
                force, torque = rows[:, SHARES:half].copy(), rows[:, half:].copy()
                found = ShareOrEven(force, defined[:, 0].copy(), torque, defined[:, 1].copy())
            else:
                found = share_or_even(self.applied, self.team.decomposer().grips)
            self._shares.append(found)
        return self._shares[0]

    @property
    def power(self) -> Power:
        """What part of the power each agent supplies, and what passes between them (eqs. 26-27).

        Of ``applied`` at ``power.twist``, the step's mean twist in the object frame. Times ``dt``
        it is the work of what was held in the step. `coopenv.wrench.energy_share` of these two
        gives the linear and the angular shares too.
        """
        if not self._power:
            before, after = self.state, self.next_state
            found = power_over(
                self.applied,
                self.team.grips,
                (before.pose, before.twist),
                (after.pose, after.twist),
                self.dt,
            )
            self._power.append(found)
        return self._power[0]

    def per_agent(self, value: npt.NDArray[Any], scale: float = 1.0) -> FloatArray:
        """``scale`` × one value a world ``(world,)``, for each agent: ``(world, agent)``."""
        return frames.repeated(value, self.team.num_agents, scale)

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What `restored` needs of ``worlds``, one row each; conditions are kept apart."""
        return _rows(self, worlds)

    @classmethod
    def restored(
        cls,
        state: dict[str, Any],
        conditions: Conditions,
        *,
        beside: "Transition | None",
        worlds: IntArray,
        dt: float,
        horizon: int,
    ) -> "Transition":
        """The transition of which `get_state` returned ``state``, in ``worlds``, in order.

        Other worlds have that of ``beside``; ``conditions`` are of all.
        """
        before, after = State(**state["state"]), State(**state["next_state"])
        rows = {**state, "state": before, "next_state": after}
        given = cls(**rows, conditions=conditions, dt=dt, horizon=horizon)
        if beside is None or len(worlds) == len(conditions.bodies):
            return given
        return beside.with_worlds(worlds, given, conditions)

    def with_worlds(
        self, worlds: IntArray, other: "Transition", conditions: Conditions
    ) -> "Transition":
        """A copy with ``worlds`` replaced by those of ``other``, in order, under ``conditions``."""
        return replace(_merged(self, worlds, other), conditions=conditions)


def _require_fit(applied: FloatArray, grips: FloatArray) -> None:
    """Raise unless there is one wrench an agent and world, as kernels that measure rely on."""
    expected = (*grips.shape[:2], 3)
    if applied.shape != expected:
        raise InvalidInput(
            f"applied must be of shape {expected}, got {applied.shape}; give one planar wrench for "
            "each agent of each world"
        )


def _nothing_computed() -> dict[str, Any]:
    """What is computed when asked for, before it is; a copy computes it again."""
    return {"_decompositions": {}, "_own": [], "_measured": [], "_shares": [], "_power": []}


def _rows(value: Any, worlds: IntArray) -> dict[str, Any]:
    """Copies of the rows ``worlds`` of a dataclass of per-world arrays, by their names."""
    rows = {}
    for entry in fields(value):
        mine = getattr(value, entry.name)
        if isinstance(mine, np.ndarray):
            rows[entry.name] = mine[worlds]
        elif isinstance(mine, State):
            rows[entry.name] = _rows(mine, worlds)
    return rows


def _merged(value: Any, worlds: IntArray, other: Any) -> Any:
    """Copy of a dataclass of per-world arrays with the rows ``worlds`` taken from ``other``."""
    changed = {}
    for entry in fields(value):
        mine = getattr(value, entry.name)
        if isinstance(mine, np.ndarray):
            changed[entry.name] = with_rows(mine, worlds, getattr(other, entry.name))
        elif isinstance(mine, State):
            changed[entry.name] = _merged(mine, worlds, getattr(other, entry.name))
    return replace(value, **changed)
