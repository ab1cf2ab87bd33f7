"""Protocols of partners: who drives some of the agents, so that the others learn with somebody."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from coopenv.arrays import FloatArray, IntArray
from coopenv.errors import InvalidInput
from coopenv.transition import Transition

if TYPE_CHECKING:
    from coopenv.config import TransportConfig

Generators = Sequence[np.random.Generator | None]
_GIVEN = ("wrenches", "actions")


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

    With an attribute ``gives = "actions"`` it gives actions instead, of the kind that learners give
    (see `gives_actions`): so it moves hands where the actions are motions.
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

        Where it gives actions: those, ``(world, driven agent, action_size)`` in [−1, 1], in each
        agent's frame; pushes as rows (fx, fy, tz) where learners choose among numbers.

        Called once a step, with the last one. They are clipped as everybody's actions are: each
        component to the agent's limit, in the agent's frame; and where agents give forces only
        (``action="force"``), the torque is left out. In worlds that begin anew in this step, they
        are ignored.
        """
        ...

    def plan(self, transition: Transition) -> FloatArray:
        """Pose ``(world, 3)`` it wants the object to reach, world frame; NaN where it has none."""
        ...


@runtime_checkable
class StatefulPlayer(Player, Protocol):
    """A player whose memory can be kept and put back.

    `coopenv.Transport.get_state`, copies and pickles of episodes under way need one, where there is
    a partner.
    """

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What it remembers of ``worlds``: arrays and lists with one entry each, by name.

        Copies, which a later step does not change; empty if it remembers nothing. A dict may hold
        dicts of the same kind.
        """
        ...

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """Go on in ``worlds`` from what `get_state` returned, perhaps of another player."""
        ...


def gives_actions(player: Player) -> bool:
    """Whether a player gives actions; wrenches where its attribute ``gives`` says so or is not.

    Raises
    ------
    InvalidInput
        If it says anything else.
    """
    given = getattr(player, "gives", _GIVEN[0])
    if given not in _GIVEN:
        raise InvalidInput(
            f"gives of a player must be 'wrenches' or 'actions', got {given!r}; say what its act "
            "returns"
        )
    return given == "actions"


Finder: TypeAlias = Callable[[Any], Partner]
"""The partner of a name, a policy's file or a policy; raises `UnknownName` where there is none."""

_finders: list[Finder] = []


def name_partners(finder: Finder) -> None:
    """Register the function that finds a partner by what stands for it, in place of the last one.

    On import, `coopenv` registers one that finds those of `coopenv.agents.partners`. The core
    cannot import them, as they are themselves built on it.
    """
    _finders[:] = [finder]


def named_partner(name: Any) -> Partner:
    """The partner of that name, the policy of that file, or the policy itself.

    Raises
    ------
    UnknownName, InvalidInput
        If there is none.
    """
    (finder,) = _finders
    return finder(name)
