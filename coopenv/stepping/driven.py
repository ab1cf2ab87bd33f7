"""The joint action: what learners give, and the part of agents that a partner drives."""

from typing import Any, cast

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, finite_array, number_array, plain_array
from coopenv.compiled import compiled
from coopenv.compiled.checks import is_finite
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import action_of
from coopenv.partner import Generators, Partner, StatefulPlayer, gives_actions
from coopenv.snapshot import check_rows
from coopenv.transition import Transition


class DrivenAgents:
    """Driven agents of an environment without a partner: none, so every agent learns.

    `DrivenByPartner` overrides all methods; `driven_agents` chooses between the two.
    """

    def have_hands(self, num_agents: int) -> BoolArray:
        """Which agents ``(agent,)`` move hands where actions are motions: all who give actions."""
        return np.ones(num_agents, dtype=np.bool_)

    def begin(self, worlds: IntArray, generators: Generators, start: Transition) -> None:
        """Start an episode in ``worlds``."""

    def joint(
        self, action: FloatArray, before: Transition, restart: BoolArray | None = None
    ) -> FloatArray:
        """All agents' actions ``(world, agent, a)``, given finite ones of the learners.

        In the worlds that ``restart`` marks, those of driven agents are zero whatever they are.

        Raises
        ------
        InvalidInput
            If what a partner gives is not finite, or has the wrong shape.
        """
        return action

    def of_learners(self, value: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The learners' rows of an array ``(world, agent, ...)``; a view where it will do."""
        return value

    def terms_of_learners(self, terms: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """The learners' rows of every reward term."""
        return terms

    def info(self, transition: Transition) -> dict[str, npt.NDArray[Any]]:
        """Facts about the partner after ``transition`` that no observation shows.

        ``partner_plan`` ``(world, 3)`` is the pose it wants the object to reach (where it wants
        none: the object's own), ``partner_has_plan`` whether it wants one, ``disagreement`` the
        task's distance from that plan to the goal [m] (0 without a plan), ``partner_kind`` which
        member of a population it is. Empty without a partner.
        """
        return {}

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What the partner remembers of ``worlds``, one row each.

        Raises
        ------
        InvalidInput
            If its player does not tell.
        """
        return {}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned."""


class DrivenByPartner(DrivenAgents):
    """The agents of every world that one player of a partner drives.

    Parameters
    ----------
    partner
        Who drives them.
    config
        Of the environment.
    num_worlds
        Worlds stepped together.
    """

    def __init__(self, partner: Partner, config: TransportConfig, num_worlds: int):
        self._task = config.task
        self._driven, self._learners = np.array(config.driven), np.array(config.learners)
        self._rows = _evenly(self._learners)
        self.player = partner.player(config, num_worlds, config.driven)
        self._gives_actions = gives_actions(self.player)
        self._name, width = "wrenches of the partner", 3
        if self._gives_actions:
            self._name, width = "actions of the partner", ACTIONS[config.action]
        self._shape = (num_worlds, len(self._driven), width)

    def have_hands(self, num_agents: int) -> BoolArray:
        """See `DrivenAgents.have_hands`."""
        held = [] if self._gives_actions else self._driven
        return ~np.isin(np.arange(num_agents), held)

    def begin(self, worlds: IntArray, generators: Generators, start: Transition) -> None:
        """Start an episode in ``worlds``."""
        self.player.reset(worlds, generators, start)

    def joint(
        self, action: FloatArray, before: Transition, restart: BoolArray | None = None
    ) -> FloatArray:
        """See `DrivenAgents.joint`."""
        given = number_array(self.player.act(before), self._name)
        if given.shape != self._shape:
            columns = "action_size" if self._gives_actions else "3"
            raise InvalidInput(
                f"{self._name} must have shape (world, driven agent, {columns}) = "
                f"{self._shape}, got {given.shape}; give one row for each agent it drives"
            )
        if restart is not None:
            given = np.where(restart[:, None, None], 0.0, given)
        if self._gives_actions:
            return self._beside(action, finite_array(given, self._name))
        team = before.team
        joint, finite = _joint(action, given, self._learners, self._driven, team.frame, team.limits)
        if not finite:
            finite_array(given, self._name)  # raises, naming the place
        return joint

    def _beside(self, action: FloatArray, given: FloatArray) -> FloatArray:
        """Actions of all agents: the learners' and those that are ``given``."""
        joint = np.empty((len(action), action.shape[1] + given.shape[1], action.shape[2]))
        joint[:, self._learners], joint[:, self._driven] = action, given
        return joint

    def of_learners(self, value: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """See `DrivenAgents.of_learners`."""
        return value[:, self._rows]

    def terms_of_learners(self, terms: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """See `DrivenAgents.terms_of_learners`."""
        return {name: self.of_learners(term) for name, term in terms.items()}

    def info(self, transition: Transition) -> dict[str, npt.NDArray[Any]]:
        """See `DrivenAgents.info`."""
        state = transition.next_state
        plan, target, decided, apart = _where_to(
            self.player.plan(transition), state.pose, state.goal
        )
        disagreement = np.where(apart, self._task.distance(target, state.goal), 0.0)
        return {
            "partner_plan": plan,
            "partner_has_plan": decided,
            "disagreement": disagreement,
            "partner_kind": self.player.kind,
        }

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """See `DrivenAgents.get_state`."""
        state = self._stateful().get_state(worlds)
        check_rows(state, len(worlds), "state of the partner")
        return state

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """See `DrivenAgents.set_state`."""
        self._stateful().set_state(state, worlds)

    def _stateful(self) -> StatefulPlayer:
        if not isinstance(self.player, StatefulPlayer):
            raise InvalidInput(
                "the player of a partner must have get_state and set_state for the state of an "
                f"environment to be kept, copied or pickled, got a {type(self.player).__name__}; "
                "write them, as coopenv.partner.StatefulPlayer says"
            )
        return self.player


def read_action(
    action: npt.ArrayLike, shape: tuple[int, ...], restart: BoolArray | None
) -> FloatArray:
    """The learners' actions ``(world, learner, action_size)``, 0 in worlds that ``restart`` marks.

    Raises
    ------
    InvalidInput
        If they have another shape or are no real numbers, or another world's are not finite.
    """
    given = plain_array(action, "action").astype(np.float64, copy=False)
    if given.shape != shape:
        raise InvalidInput(
            f"action must have shape (world, agent, {shape[2]}) = {shape}, "
            f"got {given.shape}; stack one row an agent that learns"
        )
    if restart is not None:
        given = np.where(restart[:, None, None], 0.0, given)
    if not is_finite(given):
        finite_array(given, "action")  # raises, naming the place
    return given


def driven_agents(config: TransportConfig, num_worlds: int) -> DrivenAgents:
    """Agents in ``num_worlds`` worlds that the configuration's partner drives, if it has one."""
    partner = cast(Partner | None, config.partner)  # a name was read with the configuration
    return DrivenAgents() if partner is None else DrivenByPartner(partner, config, num_worlds)


def _evenly(numbers: IntArray) -> slice | IntArray:
    """A slice that picks rising numbers, if they are evenly spaced; else the numbers."""
    steps = np.diff(numbers)
    if (steps != steps[:1]).any():
        return numbers
    return slice(int(numbers[0]), int(numbers[-1]) + 1, int(steps[0]) if len(steps) else 1)


@compiled
def _joint(action, wrench, learners, driven, frame, limits):
    """Actions of all agents ``(world, agent, a)``: the learners' own, the others' from wrenches.

    Also whether the latter are finite.
    """
    num_worlds, _, width = action.shape
    joint, finite = np.empty((num_worlds, len(learners) + len(driven), width)), True
    for k in range(num_worlds):
        for number, i in enumerate(learners):
            for j in range(width):
                joint[k, i, j] = action[k, number, j]
        for number, i in enumerate(driven):
            x, y, torque = wrench[k, number, 0], wrench[k, number, 1], wrench[k, number, 2]
            along, across, turning = action_of(
                frame[k, i, 0], frame[k, i, 1], limits[k, i, 0], limits[k, i, 1], x, y, torque
            )
            joint[k, i, 0], joint[k, i, 1] = along, across
            if width >= 3:
                joint[k, i, 2] = turning
            for j in range(3, width):
                joint[k, i, j] = 0.0
            finite = finite and np.isfinite(x + y + torque)
    return joint, finite


@compiled
def _where_to(plan, pose, goal):
    """Fill in for missing plans (NaN), and say which worlds have a plan and which one off the goal.

    Returns four arrays: the plans with the object's pose where there is none; the plans with the
    goal where there is none; whether there is a plan; whether it differs from the goal. The last
    is found by comparison, since even the distance from a pose to itself is rounded.
    """
    shown, target = np.empty_like(plan), np.empty_like(plan)
    decided, apart = np.empty(len(plan), dtype=np.bool_), np.empty(len(plan), dtype=np.bool_)
    for k in range(len(plan)):
        decided[k] = not (np.isnan(plan[k, 0]) or np.isnan(plan[k, 1]) or np.isnan(plan[k, 2]))
        apart[k] = False
        for j in range(3):
            shown[k, j] = plan[k, j] if decided[k] else pose[k, j]
            target[k, j] = plan[k, j] if decided[k] else goal[k, j]
            apart[k] = apart[k] or target[k, j] != goal[k, j]
    return shown, target, decided, apart
