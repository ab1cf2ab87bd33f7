"""Somebody else's hands: the protocol of partners, and their part of the joint action."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray, finite_array
from coopenv.compiled import compiled
from coopenv.errors import InvalidInput
from coopenv.geometry.frames import rotated_back
from coopenv.info import Info
from coopenv.transition import Transition

if TYPE_CHECKING:
    from coopenv.config import TransportConfig

Generators = Sequence[np.random.Generator | None]


@runtime_checkable
class Partner(Protocol):
    """Who drives some of the agents: a description without memory, part of the configuration.

    It is compared, copied and shared between environments like the rest of `TransportConfig`;
    what it remembers of an episode lives in the `Player` it sends. A frozen dataclass does well.
    """

    def player(
        self, config: "TransportConfig", num_worlds: int, agents: tuple[int, ...]
    ) -> "Player":
        """The one who acts, in ``num_worlds`` worlds at once, for ``agents`` of each."""
        ...


class Player(Protocol):
    """A partner at work: transitions in, wrenches out, all worlds at once.

    It may read all of a transition, be it what a person could not see; what the implementations
    of `coopenv.agents.partners` make use of is said there.
    """

    @property
    def kind(self) -> IntArray:
        """``(world,)``: which of a population's members it is in each world; else 0."""
        ...

    def reset(self, worlds: IntArray, generators: Generators, start: Transition) -> None:
        """Begin an episode in ``worlds``.

        Parameters
        ----------
        worlds
            Their numbers.
        generators
            One for every world of the batch. What an episode of world k draws has to come from
            ``generators[k]``, after the task drew start and goal.
        start
            The starts, one row for each of ``worlds``.
        """
        ...

    def act(self, transition: Transition) -> FloatArray:
        """Wrenches ``(world, driven agent, 3)`` [N, N·m] for the next step, object frame.

        Called once a step, with the last one. They are clipped as everybody's actions are: each
        component to the agent's limit, in the agent's frame; and where agents give forces only
        (``action="force"``), the torque is left out. In worlds that begin anew in this step, they
        are ignored.
        """
        ...

    def plan(self, transition: Transition) -> FloatArray:
        """Pose ``(world, 3)`` it wants the object to reach, world frame; NaN where it has none."""
        ...


class Company:
    """The partner of a batch of worlds beside those who learn.

    Parameters
    ----------
    config
        With a partner.
    num_worlds
        Worlds stepped together.
    """

    def __init__(self, config: "TransportConfig", num_worlds: int):
        assert isinstance(config.partner, Partner)
        self._task, self._num_agents = config.task, config.num_agents
        self._driven, self._learners = np.array(config.driven), np.array(config.learners)
        self._rows = _evenly(self._learners)
        self._shape = (num_worlds, len(self._driven), 3)
        self.player = config.partner.player(config, num_worlds, config.driven)

    def begin(self, worlds: IntArray, generators: Generators, start: Transition) -> None:
        """Start an episode in ``worlds``."""
        self.player.reset(worlds, generators, start)

    def joint(
        self, action: npt.NDArray[Any], before: Transition, restart: BoolArray | None = None
    ) -> FloatArray:
        """All agents' actions ``(world, agent, a)``, given those of the learners.

        In the worlds that ``restart`` marks, the partner's are zero whatever it gave.

        Raises
        ------
        InvalidInput
            If the learners' actions or the partner's wrenches are not finite, or the latter have
            the wrong shape. If it is the former, the partner was not asked.
        """
        given = action if np.isfinite(action).all() else finite_array(action, "action")
        wrench = np.asarray(self.player.act(before), dtype=np.float64)
        if wrench.shape != self._shape:
            raise InvalidInput(
                f"wrenches of the partner must have shape (world, driven agent, 3) = "
                f"{self._shape}, got {wrench.shape}; give one row for each agent it drives"
            )
        if restart is not None:
            wrench = np.where(restart[:, None, None], 0.0, wrench)
        team = before.team
        joint, finite = _joint(given, wrench, self._learners, self._driven, team.frame, team.limits)
        if not finite:
            finite_array(wrench, "wrenches of the partner")  # raises, naming the place
        return joint

    def of_learners(self, value: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The learners' rows of an array ``(world, agent, ...)``; a view where it will do."""
        return value[:, self._rows]

    def terms_of_learners(self, terms: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """The learners' rows of every reward term."""
        return {name: self.of_learners(term) for name, term in terms.items()}

    def info(self, transition: Transition) -> Info:
        """What is true of the partner after ``transition``, and no observation tells.

        ``partner_plan`` ``(world, 3)`` is the pose it wants the object to reach (where it wants
        none: the object's own), ``partner_has_plan`` whether it wants one, ``disagreement`` the
        task's distance from that plan to the goal [m] (0 without a plan), ``partner_kind`` which
        member of a population it is.
        """
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
            along, across = rotated_back(frame[k, i, 0], frame[k, i, 1], x, y)
            joint[k, i, 0], joint[k, i, 1] = along / limits[k, i, 0], across / limits[k, i, 0]
            if width == 3:
                joint[k, i, 2] = torque / limits[k, i, 1]
            finite = finite and np.isfinite(x + y + torque)
    return joint, finite


@compiled
def _where_to(plan, pose, goal):
    """Plans, with the pose and with the goal where there is none; whether there is one, elsewhere.

    "Elsewhere" is not at the goal: distances from a pose to itself are rounded.
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
