"""PettingZoo view: one world, every agent with its own action, observation and reward."""

from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Space
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils import wrappers
from pettingzoo.utils.conversions import parallel_to_aec

from coopenv.arrays import plain_array
from coopenv.config import TransportConfig
from coopenv.envs.common import (
    RENDER_MODES,
    Pictures,
    agent_action_space,
    agent_observation_space,
    check_action,
    metadata_of,
    refused,
    start_options,
    team_observation_space,
)
from coopenv.errors import InvalidInput, ResetNeeded
from coopenv.info import Info, of_agents
from coopenv.pushes import push_numbers
from coopenv.snapshot import Snapshot
from coopenv.transport import Transport

Observation: TypeAlias = npt.NDArray[np.float32]
Action: TypeAlias = npt.NDArray[np.float32] | np.int64  # a push's number
ByAgent = dict[str, Any]

_TURNS = "turns"  # part of a snapshot
# What a wrapper has from the beginning; the rest is its memory
_FIXED = {"env", "_parallel", "metadata", "render_mode", "possible_agents", "state_space"}


class TransportParallelEnv(ParallelEnv[str, Observation, Action | None]):
    """A team carries an object, each agent on its own.

    Every agent has its own observation and reward; they end together. Agents that a ``partner``
    drives are not among them. Info, per agent: as `coopenv.info.step_info`, wrenches, shares and
    reward terms and cost its own; of a partner, as `coopenv.stepping.driven.DrivenAgents.info`.

    Parameters
    ----------
    name
        For ``metadata``.
    render_mode
        ``None``, ``"human"`` or ``"rgb_array"``.
    defaults
        Fields of the configuration that an id changes.
    **keywords
        Fields of `coopenv.TransportConfig`.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared as gymnasium does
        "render_modes": [*RENDER_MODES],
        "is_parallelizable": True,
        "render_fps": 20,
    }

    def __init__(
        self,
        *,
        name: str,
        render_mode: str | None = None,
        defaults: Mapping[str, Any] | None = None,
        **keywords: Any,
    ):
        self.transport = Transport(config=TransportConfig.parse(keywords, defaults))
        self._pictures = Pictures(self.transport, render_mode)
        self.render_mode = render_mode
        self.metadata = {**metadata_of(self, self.transport), "name": name}
        self.possible_agents = [f"agent_{i}" for i in self.transport.learners]
        self.agents: list[str] = []
        self._names = {agent: f"actions[{agent!r}]" for agent in self.possible_agents}
        self.observation_spaces = {
            agent: agent_observation_space(self.transport) for agent in self.possible_agents
        }
        self.action_spaces = {
            agent: agent_action_space(self.transport) for agent in self.possible_agents
        }
        self.state_space = team_observation_space(self.transport)
        self.observation_blocks = self.transport.observation.blocks
        self._obs = np.zeros(self.state_space.shape, dtype=np.float32)

    def observation_space(self, agent: str) -> Space[Observation]:
        """What ``agent`` sees; always the same object."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Space[Action | None]:
        """What ``agent`` does; always the same object."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], ByAgent]:
        """Start an episode; ``options`` may give ``pose`` and ``goal`` (x, y, θ)."""
        obs, info = self.transport.reset(seed=seed, **start_options(options))
        self.agents = self.possible_agents[:]
        if self.render_mode == "human":
            self.render()
        return self._split(obs), self._infos(info)

    def step(
        self, actions: Mapping[str, Action | None]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], ByAgent]:
        """Advance by one control step."""
        joint = self._joint(actions)
        try:
            obs, reward, terminated, truncated, info = self.transport.advance(joint)
        except InvalidInput:
            names = [self._names[agent] for agent in self.agents]
            told = refused(joint, names, self.transport.table)
            if told is None:
                raise
            raise told from None
        seen, told = self._split(obs), self._infos(info)
        rewards = dict(zip(self.agents, reward[0].tolist(), strict=True))
        ends = dict.fromkeys(self.agents, bool(terminated[0]))
        stops = dict.fromkeys(self.agents, bool(truncated[0]))
        if terminated[0] or truncated[0]:
            self.agents = []
        if self.render_mode == "human":
            self.render()
        return seen, rewards, ends, stops, told

    def get_state(self) -> Snapshot:
        """All that decides how the episode goes on; see `coopenv.Transport.get_state`."""
        return self.transport.get_state()

    def set_state(self, state: Snapshot) -> tuple[dict[str, Observation], ByAgent]:
        """Go on from a state of one world, of whichever view it is; returned as by `reset`.

        Nobody is left in ``agents`` if its episode has ended.
        """
        obs, info = self.transport.set_state(state)
        transition = self.transport.transition
        assert transition is not None
        ended = bool(transition.terminated[0] or transition.truncated[0])
        self.agents = [] if ended else self.possible_agents[:]
        if self.render_mode == "human":
            self.render()
        return self._split(obs), self._infos(info)

    def state(self) -> Observation:
        """What all agents see, one after the other, for central critics."""
        return self._obs.reshape(-1).copy()

    def render(self) -> Any:
        """The picture ``(height, width, 3)`` uint8, or ``None`` with a window open."""
        return self._pictures.draw()

    def close(self) -> None:
        """Close the window."""
        self._pictures.close()

    def _joint(self, actions: Mapping[str, Action | None]) -> npt.NDArray[np.float64]:
        if not self.agents:
            raise ResetNeeded("reset must be called before a step, got an ended episode; reset()")
        if not isinstance(actions, Mapping) or actions.keys() != set(self.agents):
            given = list(actions) if isinstance(actions, Mapping) else actions
            raise InvalidInput(
                f"actions must have one entry for each of {self.agents}, got {given}; "
                "add or drop entries"
            )
        given = [self.read(agent, actions[agent]) for agent in self.agents]
        if self.transport.table is not None:
            return np.array([given])
        joint = np.empty((1, len(given), self.transport.action_size))
        for i, row in enumerate(given):
            joint[0, i] = row
        return joint

    def read(self, agent: str, action: Any) -> npt.NDArray[Any]:
        """One agent's action ``(action_size,)``, or the number ``()`` of a push.

        Raises `InvalidInput` where it has not that form; its numbers are looked at later.
        """
        name, table = self._names[agent], self.transport.table
        if table is not None:
            return push_numbers(action, name, (), len(table))
        row, size = plain_array(action, name), self.transport.action_size
        if row.shape != (size,):
            raise InvalidInput(
                f"{name} must have shape ({size},), got {row.shape}; see action_space({agent!r})"
            )
        return row

    def _split(self, obs: Observation) -> dict[str, Observation]:
        self._obs = obs[0]
        return {agent: obs[0, i].copy() for i, agent in enumerate(self.possible_agents)}

    def _infos(self, info: Info) -> ByAgent:
        told = of_agents(info, self.transport.learners)
        return dict(zip(self.possible_agents, told, strict=True))


def aec(parallel: TransportParallelEnv) -> AECEnv:
    """The AEC view: agents act in turn, the world moves once all have."""
    return _Turns(parallel)


class _Turns(wrappers.OrderEnforcingWrapper):
    """Refuses an action in its agent's turn: once all have acted, nobody could mend it."""

    def __init__(self, parallel: TransportParallelEnv):
        super().__init__(parallel_to_aec(parallel))
        self._parallel = parallel

    def step(self, action: Any) -> None:
        agent = self.agent_selection
        if not (self.terminations[agent] or self.truncations[agent]):
            given, table = self._parallel.read(agent, action), self._parallel.transport.table
            check_action(given, f"actions[{agent!r}]", table)
        super().step(action)

    def get_state(self) -> Snapshot:
        """As the parallel view's, with whose turn it is and what was given in this round."""
        state = self._parallel.get_state()
        turns = [
            {name: value for name, value in memory.items() if name not in _FIXED}
            for memory in self._memories()
        ]
        return state.with_part(_TURNS, [deepcopy(turns)])

    def set_state(self, state: Snapshot) -> None:
        """Go on from a state that this view returned, here or in another environment.

        Raises
        ------
        InvalidInput
            If it is of another view, which does not know whose turn it is.
        """
        if _TURNS not in getattr(state, "parts", {_TURNS: None}):
            raise InvalidInput(
                "state must know whose turn it is, got one of another view; take it by get_state "
                "of an AEC environment, or go on in the parallel one"
            )
        self._parallel.set_state(state)
        for memory, turns in zip(self._memories(), deepcopy(state.parts[_TURNS][0]), strict=True):
            for name in memory.keys() - _FIXED:
                del memory[name]
            memory.update(turns)

    def _memories(self) -> Iterator[dict[str, Any]]:
        """Attributes of this wrapper and of PettingZoo's own inside it."""
        layer: Any = self
        while layer is not self._parallel:
            yield vars(layer)
            layer = layer.env
