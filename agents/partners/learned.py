"""Partners that are policies: from the file of a trained one, or anything that is called as one."""

import os
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, field, replace
from hashlib import sha256
from inspect import signature
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray, IntArray, finite_array, plain_array, whole
from coopenv.chance import draw_keys
from coopenv.config import ACTIONS, TransportConfig
from coopenv.errors import InvalidInput
from coopenv.geometry import frames
from coopenv.observation import Observation
from coopenv.partner import Generators
from coopenv.pushes import check_numbers, push_numbers
from coopenv.transition import Transition

from ..policy import Freezable, Resettable, Seat, Seatable, Seedable, Stateful, forget
from ..pretrained.catalogue import FILES, read
from ..pretrained.naming import file_of, is_name
from ..trained.archive import existing

_ACTIONS = "actions of the partner's policy"


@dataclass(frozen=True, slots=True, kw_only=True)
class LearnedPartner:
    """The policy of a file, as it was trained; ``partner="path/policy.zip"`` stands for it.

    It sees the blocks that its file records, through sensors as in its training, with this
    environment's limits, decomposition and what it tells (``informed``). A policy of the whole team
    sees all agents and drives its own; one that every agent runs drives each of them.

    Parameters
    ----------
    path
        That `coopenv.agents.sb3.SB3Policy.save`, ``coopenv train`` or ``coopenv export`` wrote; or
        ``pretrained:BeamDoorway/joint``, a policy of the package.
    deterministic
        Take the mean action instead of a sample.
    seed
        Of sampled actions, which are keyed by it, by the episode and by the step.
    digest
        SHA-256 of the file, so that a configuration is of one policy and not of a name; found where
        it is not given.
    trust
        Whether the file may run what it holds (`coopenv.agents.sb3.SB3Policy.load`). It is never
        written: a text from elsewhere cannot ask for it, and whoever reads one with ``trust=True``
        says it anew.

    Raises
    ------
    InvalidInput
        If there is no such file, or another than the digest is of; where an environment is made,
        if it cannot be read or cannot act there.
    MissingExtra
        If the file is a ``.zip`` and the extra ``train`` is not installed.
    """

    path: str
    deterministic: bool = True
    seed: int = 0
    digest: str | None = None
    trust: bool = field(default=False, compare=False)

    def __post_init__(self) -> None:
        _set = object.__setattr__
        if not isinstance(self.path, str | os.PathLike):
            raise InvalidInput(
                f"partner.path must be the name of a policy's file, got {self.path!r}; write for "
                "example 'runs/policy.zip'"
            )
        _set(self, "path", os.fspath(self.path))
        _set(self, "seed", whole(self.seed, "partner.seed", at_least=0))
        for name in ("deterministic", "trust"):
            if not isinstance(getattr(self, name), bool):
                raise InvalidInput(
                    f"partner.{name} must be True or False, got {getattr(self, name)!r}; give one"
                )
        _set(self, "digest", self._checked_digest())

    def player(
        self, config: TransportConfig, num_worlds: int, agents: tuple[int, ...]
    ) -> "PolicyPlayer":
        """See `coopenv.partner.Partner`."""
        self._checked_digest()
        policy = read(self.path, deterministic=self.deterministic, seed=self.seed, trust=self.trust)
        try:
            seat = policy.as_partner(config, agents, trust=self.trust)
        except InvalidInput as error:
            raise InvalidInput(f"{error} (policy {self.path!r})") from error
        return PolicyPlayer(seat, config, num_worlds, agents)

    def _checked_digest(self) -> str:
        """The file's digest; raises unless it is the one that is known."""
        try:
            found = sha256(existing(file_of(self.path)).read_bytes()).hexdigest()
        except InvalidInput as error:
            raise InvalidInput(f"partner must be a policy's file: {error}") from error
        if self.digest not in (None, found):
            raise InvalidInput(
                f"partner.digest must be that of the file, got {self.digest!r}, but {self.path!r} "
                f"has {found!r} now: another policy was written there; restore it, or name the "
                "partner by its path alone"
            )
        return found


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyPartner:
    """Anything that is called as a `coopenv.agents.policy.Policy`; ``partner=policy`` is short.

    It is given what the driven agents see ``(world, driven agent, feature)``, by the environment's
    own blocks, and the transition, and returns their actions ``(world, driven agent, action_size)``
    in [−1, 1], agent frame; or those of all agents, as scripted controllers do, of which it takes
    these. A `coopenv.agents.sb3.SB3Policy` sees what it was trained on.

    Every environment takes a copy as it is made, with a memory of its own; what the policy learns
    later changes no partner.

    Through JSON go functions at the top of a module and frozen dataclasses, as reward terms of your
    own do.

    Raises
    ------
    InvalidInput
        If it cannot be called so.
    """

    policy: Callable[..., Any]

    def __post_init__(self) -> None:
        if (
            not callable(self.policy)
            or isinstance(self.policy, type)
            or not _takes_two(self.policy)
        ):
            raise InvalidInput(
                f"partner.policy must be callable as policy(obs, transition), got {self.policy!r}; "
                "write for example lambda obs, transition: ..."
            )

    def player(
        self, config: TransportConfig, num_worlds: int, agents: tuple[int, ...]
    ) -> "PolicyPlayer":
        """See `coopenv.partner.Partner`."""
        policy: Any = self.policy
        own = policy.frozen() if isinstance(policy, Freezable) else deepcopy(policy)
        seat = (
            own.as_partner(config, agents)
            if isinstance(own, Seatable)
            else Seat(own, tuple(config.observe), agents, config.table, config.bounds())
        )
        return PolicyPlayer(seat, config, num_worlds, agents)


class PolicyPlayer:
    """Plays a policy in a batch of worlds; it has no plan that it could tell.

    Where actions are motions it moves the hands of those it drives, as learners do theirs.

    Parameters
    ----------
    seat
        The policy and what it is given.
    config
        Of the environment.
    num_worlds
        Worlds stepped together.
    agents
        Numbers of the agents it drives, all of them in the seat.
    """

    def __init__(
        self, seat: Seat, config: TransportConfig, num_worlds: int, agents: tuple[int, ...]
    ):
        self.gives = "wrenches" if config.hands is None else "actions"
        self._policy, self._seen = seat.policy, list(seat.agents)
        self._driven, self._table = list(agents), seat.table
        self._width = ACTIONS[config.action]
        self._rows = [self._seen.index(agent) for agent in agents]
        self._observation = Observation(seat.observe, config.num_agents, num_worlds, seat.bounds)
        self._keys = np.zeros(num_worlds, dtype=np.uint64)
        self.kind: IntArray = np.zeros(num_worlds, dtype=np.int64)

    def reset(self, worlds: IntArray, generators: Generators, start: Transition) -> None:
        """Begin an episode in ``worlds``; see `coopenv.partner.Player`."""
        self._keys[worlds] = draw_keys(generators, worlds)
        mask = np.zeros(len(self._keys), dtype=np.bool_)
        mask[worlds] = True
        forget(self._policy, mask)
        if isinstance(self._policy, Seedable):
            self._policy.seed_episodes(self._keys.view(np.int64), worlds)

    def act(self, transition: Transition) -> FloatArray:
        """Wrenches or actions for the next step; see `coopenv.partner.Player`."""
        action = self.actions(transition)
        if self.gives == "actions":
            return action
        team = transition.team
        frame, limits = team.frame[:, self._driven], team.limits[:, self._driven]
        return frames.wrenches_from_actions(action, frame, limits)[1]

    def actions(self, transition: Transition) -> FloatArray:
        """Actions ``(world, driven agent, a)`` for the next step, in [−1, 1], agent frame."""
        obs = self._observation(transition, keys=self._keys)[:, self._seen]
        return self._own(self._policy(obs, transition), transition)

    def get_state(self, worlds: IntArray) -> dict[str, Any]:
        """What it and its policy remember; see `coopenv.partner.StatefulPlayer`.

        Raises
        ------
        InvalidInput
            If the policy remembers something and does not tell what.
        """
        policy: dict[str, Any] = {}
        if isinstance(self._policy, Stateful):
            policy = self._policy.get_state(worlds, len(self._keys))
        elif isinstance(self._policy, Resettable | Seedable):
            raise InvalidInput(
                "the policy of a partner must have get_state and set_state for the state of an "
                f"environment to be kept, copied or pickled, got a {type(self._policy).__name__}, "
                "which remembers episodes; write them, as coopenv.agents.policy.Stateful says"
            )
        seen = self._observation.get_state(worlds)
        return {"keys": self._keys[worlds], "seen": seen, "policy": policy}

    def set_state(self, state: dict[str, Any], worlds: IntArray) -> None:
        """See `coopenv.partner.StatefulPlayer`."""
        self._keys[worlds] = state["keys"]
        self._observation.set_state(state["seen"], worlds)
        if isinstance(self._policy, Stateful):
            self._policy.set_state(state["policy"], worlds, len(self._keys))

    def plan(self, transition: Transition) -> FloatArray:
        """No pose: NaN ``(world, 3)``."""
        return np.full_like(transition.next_state.goal, np.nan)

    def _own(self, given: Any, transition: Transition) -> FloatArray:
        """The driven agents' rows of what the policy gives, for its seat or for all agents."""
        num_worlds, num_agents, width = transition.action.shape
        action = finite_array(self._pushed(given), _ACTIONS)
        if action.shape == (num_worlds, num_agents, width):
            return action[:, self._driven]
        wanted = num_worlds, len(self._seen), width
        if action.shape != wanted:
            raise InvalidInput(
                f"{_ACTIONS} must have shape (world, driven agent, "
                f"action_size) = {wanted}, got {action.shape}; give one row for each of them"
            )
        return action[:, self._rows]

    def _pushed(self, given: Any) -> npt.NDArray:
        """The pushes that numbers stand for; anything else as it is."""
        action = plain_array(given, _ACTIONS)
        if self._table is None or action.ndim != 2:
            return action
        count = len(self._table)
        numbers = push_numbers(given, _ACTIONS, action.shape, count)
        check_numbers(numbers, _ACTIONS, count)
        return self._table[numbers][..., : self._width]


def is_file_name(value: object) -> bool:
    """Whether something stands for a policy's file: a path, or text with a folder or its suffix.

    Or ``pretrained:BeamDoorway/joint``, for one of the package.
    """
    if isinstance(value, str):
        return value.endswith(FILES) or "/" in value or os.sep in value or is_name(value)
    return isinstance(value, os.PathLike)


def trusting(config: TransportConfig) -> TransportConfig:
    """The configuration, the file of its partner trusted if it is of a `LearnedPartner`."""
    if not isinstance(config.partner, LearnedPartner):
        return config
    return replace(config, partner=replace(config.partner, trust=True))


def _takes_two(policy: Callable[..., Any]) -> bool:
    try:
        signature(policy).bind(None, None)
    except TypeError:
        return False
    except ValueError:  # of a builtin, which does not tell
        return True
    return True
