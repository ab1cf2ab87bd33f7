"""Gymnasium view: one world, one joint action, one joint observation, team-mean reward."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from coopenv.arrays import whole
from coopenv.config import TransportConfig
from coopenv.envs.common import (
    RENDER_MODES,
    Pictures,
    metadata_of,
    refused,
    start_options,
    team_action_space,
    team_actions,
    team_observation_space,
)
from coopenv.envs.spec import Specified, asked_horizon
from coopenv.errors import InvalidInput
from coopenv.info import mean, of_team
from coopenv.snapshot import Snapshot
from coopenv.transport import Transport


class TransportEnv(Specified, gymnasium.Env[npt.NDArray[np.float32], npt.NDArray[np.float32]]):  # pyright: ignore[reportIncompatibleVariableOverride]
    """A team carries an object, driven by one joint action.

    Observation: the blocks of agent 0, then of agent 1, …; `observation_blocks` maps each name to
    its slice in one agent's part. Action: ``action_size`` numbers an agent, in [−1, 1], clipped;
    with ``action="discrete"`` the number of a push an agent.
    Reward: mean over the team. Info: `coopenv.info.step_info` of this world, reward terms and cost
    averaged over the team. Agents that a ``partner`` drives have no part in observation, action,
    reward and cost; what is true of it is in the info, as
    `coopenv.stepping.driven.DrivenAgents.info` has it.

    ``horizon`` truncates, and is ``spec.max_episode_steps``; ``gymnasium.make(...,
    max_episode_steps=)`` is another word for it, shorter or longer.

    Parameters
    ----------
    render_mode
        ``None``, ``"human"`` or ``"rgb_array"``.
    defaults
        Fields of the configuration that an id changes.
    **keywords
        Fields of `coopenv.TransportConfig`.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared as gymnasium does
        "render_modes": [*RENDER_MODES],
        "render_fps": 20,
    }

    def __init__(
        self,
        *,
        render_mode: str | None = None,
        defaults: Mapping[str, Any] | None = None,
        **keywords: Any,
    ):
        keywords = {**keywords, **asked_horizon()}
        self.transport = Transport(config=TransportConfig.parse(keywords, defaults))
        self._pictures = Pictures(self.transport, render_mode)
        self.render_mode = render_mode
        self.metadata = metadata_of(self, self.transport)
        self.observation_space = team_observation_space(self.transport)
        self.action_space = team_action_space(self.transport)
        self.observation_blocks = self.transport.observation.blocks

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Start an episode; ``options`` may give ``pose`` and ``goal`` (x, y, θ)."""
        given = start_options(options)
        kept = self._np_random, self._np_random_seed
        super().reset(seed=None if seed is None else whole(seed, "seed", at_least=0))
        self.transport.generators[0] = self.np_random
        try:
            obs, info = self.transport.reset(**given)
        except InvalidInput:  # the episode under way goes on as if nothing had been asked
            self._np_random, self._np_random_seed = kept
            self.transport.generators[0] = kept[0]
            raise
        if self.render_mode == "human":
            self.render()
        return obs.reshape(-1), of_team(info)

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Advance by one control step."""
        joint = team_actions(self.transport, action, self.action_space.shape)
        try:
            obs, reward, terminated, truncated, info = self.transport.advance(joint)
        except InvalidInput:
            names = [f"action of agent {i}" for i in self.transport.learners]
            told = refused(joint, names, self.transport.table)
            if told is None:
                raise
            raise told from None
        if self.render_mode == "human":
            self.render()
        ends = bool(terminated[0]), bool(truncated[0])
        return obs.flatten(), mean(reward), *ends, of_team(info)

    def get_state(self) -> Snapshot:
        """All that decides how the episode goes on; see `coopenv.Transport.get_state`."""
        return self.transport.get_state()

    def set_state(self, state: Snapshot) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Go on from a state of one world, of whichever view it is; returned as by `reset`."""
        obs, info = self.transport.set_state(state)
        generator = self.transport.generators[0]
        assert generator is not None
        self.np_random = generator
        if self.render_mode == "human":
            self.render()
        return obs.reshape(-1), of_team(info)

    def render(self) -> Any:
        """The picture ``(height, width, 3)`` uint8, or ``None`` with a window open."""
        return self._pictures.draw()

    def close(self) -> None:
        """Close the window."""
        self._pictures.close()
