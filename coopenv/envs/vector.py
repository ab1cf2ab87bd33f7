"""Gymnasium vector view: all worlds of a transport as one ``VectorEnv`` with autoreset."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from coopenv.arrays import BoolArray, IntArray
from coopenv.config import TransportConfig
from coopenv.envs.common import (
    Pictures,
    check_render_mode,
    metadata_of,
    options_dict,
    start_options,
    team_action_space,
    team_actions,
    team_observation_space,
)
from coopenv.envs.spec import Specified
from coopenv.errors import UnknownName
from coopenv.info import Info, means, of_vector
from coopenv.snapshot import Snapshot
from coopenv.transport import Seed, Transport


class TransportVectorEnv(Specified, gymnasium.vector.VectorEnv):  # pyright: ignore[reportIncompatibleVariableOverride]
    """``num_envs`` worlds stepped together; spaces and rewards as in `TransportEnv`.

    Parameters
    ----------
    num_envs
        Number of worlds; world k of ``reset(seed=s)`` starts as the single one with ``s + k``.
    render_mode
        ``None``, ``"rgb_array"`` (one picture a world) or ``"rgb_array_list"`` (all of them, drawn
        in every step).
    autoreset_mode
        ``"NextStep"``: the step after the end resets and ignores the action. ``"SameStep"``: the
        ending step returns the new episode's observation; the last of the old one is
        ``info["final_obs"]``, its info ``info["final_info"]``. ``"Disabled"``: the caller resets
        with ``options={"reset_mask": ...}``. Gymnasium's enumeration is taken as well.
    defaults
        Fields of the configuration that an id changes.
    **keywords
        Fields of `coopenv.TransportConfig`.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared as gymnasium does
        "render_modes": ["rgb_array", "rgb_array_list"],
        "render_fps": 20,
    }

    def __init__(
        self,
        num_envs: int = 1,
        *,
        render_mode: str | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        defaults: Mapping[str, Any] | None = None,
        **keywords: Any,
    ):
        config = TransportConfig.parse(keywords, defaults)
        self.transport = Transport(num_worlds=num_envs, config=config)
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        check_render_mode(render_mode, self.metadata["render_modes"])
        self._pictures = Pictures(self.transport, render_mode and "rgb_array")
        self.num_envs, self.render_mode = self.transport.num_worlds, render_mode
        self.metadata = {
            **metadata_of(self, self.transport),
            "autoreset_mode": self.autoreset_mode,
        }
        self.single_observation_space = team_observation_space(self.transport)
        self.single_action_space = team_action_space(self.transport)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_blocks = self.transport.observation.blocks
        self._done = np.zeros(self.num_envs, dtype=np.bool_)
        self._frames: list[list[Any]] = [[] for _ in range(self.num_envs)]

    def reset(
        self, *, seed: Seed = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], Info]:
        """Start every world anew, or those that ``options["reset_mask"]`` marks.

        ``options`` may also give ``pose`` and ``goal``, ``(3,)`` or ``(num_envs, 3)``.
        """
        given = options_dict(options)
        mask = given.pop("reset_mask", None)
        obs, info = self.transport.reset(seed=seed, mask=mask, **start_options(given))
        started = np.ones(self.num_envs, dtype=np.bool_) if mask is None else np.array(mask)
        self._done = self._done & ~started
        self._collect(np.flatnonzero(started), started)
        return self._joint(obs), self._vector_info(info, present=started)

    def step(
        self, actions: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float64], BoolArray, BoolArray, Info]:
        """Advance every world by one control step."""
        joint = team_actions(self.transport, actions, self.action_space.shape)
        restart = self._done if self.autoreset_mode is AutoresetMode.NEXT_STEP else None
        obs, reward, terminated, truncated, info = self.transport.step(joint, restart=restart)
        done = self._done = terminated | truncated
        if self.autoreset_mode is AutoresetMode.SAME_STEP and done.any():
            final = self._final(obs, info, done)
            obs, info = self.transport.reset(mask=done)
            restart = done
            info = Info({**self._vector_info(info), **final})
        else:
            info = self._vector_info(info)
        self._collect(range(self.num_envs), restart)
        return self._joint(obs), means(reward), terminated, truncated, info

    def get_state(self, worlds: Sequence[int] | IntArray | None = None) -> Snapshot:
        """All that decides how worlds go on; see `coopenv.Transport.get_state`."""
        return self.transport.get_state(worlds)

    def set_state(
        self, state: Snapshot, worlds: Sequence[int] | IntArray | None = None
    ) -> tuple[npt.NDArray[np.float32], Info]:
        """Go on from a state, of whichever view it is; see `coopenv.Transport.set_state`.

        Worlds whose episode has ended in it are reset as the autoreset mode says: in the next step,
        at once with `SAME_STEP`, by you with `DISABLED`. Observations and infos of all worlds are
        returned as by `reset`. With ``"rgb_array_list"`` the lists of
        pictures of ``worlds`` begin anew.
        """
        obs, info = self.transport.set_state(state, worlds)
        transition = self.transport.transition
        assert transition is not None
        ended = transition.terminated | transition.truncated
        if self.autoreset_mode is AutoresetMode.SAME_STEP and ended.any():
            obs, info = self.transport.reset(mask=ended)
        self._done = ended
        chosen = range(self.num_envs) if worlds is None else [int(k) for k in worlds]
        self._collect(chosen, np.ones(self.num_envs, dtype=np.bool_))
        return self._joint(obs), self._vector_info(info)

    def render(self) -> tuple[Any, ...] | None:
        """One picture a world, or a list of them, or ``None`` without a render mode.

        With ``"rgb_array_list"`` the pictures are those since the start of the world's episode or
        the last call, as of Gymnasium's single environments.
        """
        if self.render_mode is None:
            return None
        if self.render_mode == "rgb_array":
            return tuple(self._pictures.draw(world) for world in range(self.num_envs))
        frames, self._frames = self._frames, [[] for _ in range(self.num_envs)]
        return tuple(frames)

    def close_extras(self, **kwargs: Any) -> None:
        """Close the windows."""
        self._pictures.close()

    def _collect(self, worlds: Iterable[int], started: BoolArray | None) -> None:
        """Draw worlds for their lists of pictures, which begin anew where an episode did."""
        if self.render_mode != "rgb_array_list":
            return
        for world in worlds:
            if started is not None and started[world]:
                self._frames[world].clear()
            self._frames[world].append(self._pictures.draw(world))

    def _joint(self, obs: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        return obs.reshape(self.num_envs, -1)

    def _vector_info(self, info: Info, *, present: BoolArray | None = None) -> Info:
        """See `of_vector`; ``present`` marks the worlds that the info is of, ``None``: all."""
        if present is None:
            present = np.ones(self.num_envs, dtype=np.bool_)
        return of_vector(info, present)

    def _final(self, obs: npt.NDArray[np.float32], info: Info, done: BoolArray) -> dict[str, Any]:
        last = np.full(self.num_envs, None, dtype=object)
        for k in np.flatnonzero(done):
            last[k] = obs[k].reshape(-1)
        return {
            "final_obs": last,
            "_final_obs": done.copy(),
            "final_info": self._vector_info(info, present=done),
            "_final_info": done.copy(),
        }


def _autoreset_mode(mode: str | AutoresetMode) -> AutoresetMode:
    if isinstance(mode, AutoresetMode):
        return mode
    known = {member.value: member for member in AutoresetMode}
    if mode not in known:
        raise UnknownName("autoreset_mode", mode, known)
    return known[mode]
