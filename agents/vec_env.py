"""All worlds of a `coopenv.Transport` as a Stable-Baselines3 ``VecEnv``."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, IntArray, whole
from coopenv.config import TransportConfig
from coopenv.envs.common import (
    Pictures,
    agent_action_space,
    agent_observation_space,
    check_render_mode,
    metadata_of,
    start_options,
    team_action_space,
    team_actions,
    team_observation_space,
)
from coopenv.errors import InvalidInput, MissingExtra, UnknownName
from coopenv.info import COST
from coopenv.rewards.sums import check_learnable
from coopenv.snapshot import Snapshot, chosen_worlds
from coopenv.transport import Transport

from . import partners
from .episodes import Episodes, EpisodeSums
from .provenance import Provenance

try:
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingExtra("coopenv.agents.sb3", "train") from error

_SUMS = "episode_sums"  # part of a snapshot
CONTROLS = ("joint", "shared", "partner")


class TransportVecEnv(VecEnv):
    """All worlds of a `coopenv.Transport` as rows of a ``VecEnv``, with autoreset.

    ============  ==============  =================  ===============  ====================
    control       rows            observation        action           reward
    ============  ==============  =================  ===============  ====================
    ``joint``     world           all agents' sight  all agents'      mean over the team
    ``shared``    world · n + i   agent i's sight    agent i's        agent i's own
    ``partner``   world           the learner's      the learner's    the learner's
    ============  ==============  =================  ===============  ====================

    With ``action="discrete"`` the action is the number of a push, ``Discrete``, or one an agent,
    ``MultiDiscrete``.

    Agents, and their number n, are those whom no partner drives.

    Infos are empty but in the step that ends an episode; there they hold ``is_success``,
    ``terminal_observation``, ``TimeLimit.truncated`` and ``episode``: ``r`` return, ``l`` length
    [steps], ``t`` seconds since the start, then means over the episode's steps (`Episodes`) and,
    as ``reward/<term>``, the sum of each reward term; if there is a cost, ``cost`` and
    ``cost/<term>`` likewise. Then the infos of every step hold ``cost``, over whom the reward is.

    The rows share one object, so attributes are set and methods called once for all of them.

    Attributes
    ----------
    transport
        The core.
    """

    __module__ = "coopenv.agents.sb3"  # where users import it from, and where pickles look for it

    def __init__(
        self,
        config: TransportConfig,
        num_worlds: int,
        *,
        control: str = "joint",
        render_mode: str | None = None,
    ):
        if control not in CONTROLS:
            raise UnknownName("control", control, CONTROLS)
        check_render_mode(render_mode, ["rgb_array"])  # no window holds many worlds
        if control == "partner":
            config = _with_partner(config)
        self.transport = Transport(num_worlds=num_worlds, config=config)
        self.control, self.render_mode = control, render_mode
        self._rows = len(self.transport.learners) if control == "shared" else 1
        self._pictures = Pictures(self.transport, render_mode)
        self._sums = EpisodeSums(self.transport.num_worlds, self.transport.num_agents)
        self._start_time = time.perf_counter()
        self._action: npt.NDArray = np.empty(0)
        observation = agent_observation_space if control == "shared" else team_observation_space
        action = team_action_space if control == "joint" else agent_action_space
        super().__init__(
            self.transport.num_worlds * self._rows,
            observation(self.transport),
            action(self.transport),
        )
        self.metadata = metadata_of(self, self.transport, render_modes=["rgb_array"])

    def reset(self) -> npt.NDArray[np.float32]:
        """Start every world anew; seeds and options that were set are used once."""
        options = start_options(self._options[0])
        seeds = self._seeds[:: self._rows]
        seeded = any(seed is not None for seed in seeds)
        obs, _ = self.transport.reset(seed=seeds if seeded else None, **options)
        self._reset_seeds()
        self._reset_options()
        self._sums = EpisodeSums(self.transport.num_worlds, self.transport.num_agents)
        return self._by_row(obs)

    def step_async(self, actions: npt.NDArray) -> None:
        """Keep the actions for `step_wait`."""
        shape = (self.num_envs, *(self.action_space.shape or ()))
        self._action = team_actions(self.transport, actions, shape)

    def step_wait(
        self,
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], BoolArray, list[dict]]:
        """Step every world, and reset those whose episode ended.

        Raises
        ------
        InvalidInput
            If a reward term returns something that is not finite or beyond 1e12, from which no
            learner learns.
        """
        obs, reward, terminated, truncated, info = self.transport.step(self._action)
        check_learnable(reward, info)
        self._sums.add(reward, info)
        done = terminated | truncated
        infos: list[dict] = [{} for _ in range(self.num_envs)]
        if self.transport.cost is not None:
            infos = [{COST: cost} for cost in self._of_rows(info[COST]).tolist()]
        if done.any():
            worlds = np.flatnonzero(done)
            self._report(infos, worlds, self._sums.take(worlds), obs, truncated)
            obs, _ = self.transport.reset(mask=done)
        rewards = self._of_rows(reward).astype(np.float32)
        return self._by_row(obs), rewards, np.repeat(done, self._rows), infos

    def get_state(self, worlds: Sequence[int] | IntArray | None = None) -> Snapshot:
        """As `coopenv.Transport.get_state`, with the statistics of the episodes under way.

        ``worlds`` are numbers of worlds, not of rows.
        """
        state = self.transport.get_state(worlds)
        chosen = chosen_worlds(worlds, self.transport.num_worlds)
        return state.with_part(_SUMS, self._sums.get_state(chosen))

    def set_state(
        self, state: Snapshot, worlds: Sequence[int] | IntArray | None = None
    ) -> npt.NDArray[np.float32]:
        """Go on from a state, as `coopenv.Transport.set_state`; returns all rows' observations.

        The episodes' statistics go on too, or begin here in a state of another view, which has
        none. Worlds whose episode had ended in it begin a new one at once.
        """
        obs, _ = self.transport.set_state(state, worlds)
        chosen = chosen_worlds(worlds, self.transport.num_worlds)
        self._sums.set_state(state.part_for(_SUMS, len(chosen)), chosen)
        transition = self.transport.transition
        assert transition is not None
        ended = transition.terminated | transition.truncated
        if ended.any():
            self._sums.set_state(None, np.flatnonzero(ended))
            obs, _ = self.transport.reset(mask=ended)
        return self._by_row(obs)

    def __getstate__(self) -> dict[str, Any]:
        elapsed = time.perf_counter() - self._start_time  # clocks of processes differ
        return {**vars(self), "_start_time": elapsed}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _start_time=time.perf_counter() - state["_start_time"])

    def to_notes(self) -> dict[str, Any]:
        """What the file of a policy that learns in it is to say (`coopenv.agents.provenance`).

        Raises
        ------
        InvalidInput
            If something in the environment cannot be written; the message says what to do.
        """
        return Provenance.of_environment(self.transport.config, self.control).to_notes()

    def close(self) -> None:
        """Close what draws."""
        self._pictures.close()

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed world k with ``seed + k`` at the next reset; all rows of a world have its seed."""
        if seed is None:
            seed = int(np.random.default_rng().integers(2**31))
        seed = whole(seed, "seed", at_least=0)
        self._seeds = [seed + row // self._rows for row in range(self.num_envs)]
        return self._seeds

    def set_options(self, options: list[dict] | dict | None = None) -> None:
        """Start poses or goals of the next reset, ``pose`` and ``goal``, for all worlds in one."""
        if isinstance(options, list):
            raise InvalidInput(
                "options must be one dict for all worlds, got a list; "
                "pass pose= or goal= of shape (num_worlds, 3)"
            )
        self._options = [start_options(options)] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of this object or of the core, once for each index."""
        owner = self if hasattr(self, attr_name) else self.transport
        return [getattr(owner, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of this object, or of the core if it has one of that name."""
        setattr(self.transport if hasattr(self.transport, attr_name) else self, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the core once; the answer is repeated for each index.

        ``get_state`` and ``set_state`` are this object's own.
        """
        owner = self if method_name in ("get_state", "set_state") else self.transport
        answer = getattr(owner, method_name)(*method_args, **method_kwargs)
        return [answer for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """True for ``Monitor``: episode statistics are reported as that wrapper would."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[npt.NDArray | None]:
        """One picture a world."""
        return [self._pictures.draw(world) for world in range(self.transport.num_worlds)]

    def _of_rows(self, value: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """What is ``(world, learner)`` as ``(row,)``, of a team its mean."""
        return value.reshape(-1) if self.control == "shared" else value.mean(axis=1)

    def _by_row(self, obs: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        return obs.reshape(self.num_envs, -1)

    def _report(
        self,
        infos: list[dict],
        worlds: IntArray,
        ended: Episodes,
        obs: npt.NDArray[np.float32],
        truncated: BoolArray,
    ) -> None:
        """Fill the infos of the worlds whose episode ended."""
        last = self._by_row(obs)
        elapsed = round(time.perf_counter() - self._start_time, 6)
        for number, world in enumerate(worlds.tolist()):
            for agent in range(self._rows):
                row = world * self._rows + agent
                mine = slice(agent, agent + 1) if self.control == "shared" else slice(None)
                infos[row].update(
                    {
                        "terminal_observation": last[row].copy(),
                        "TimeLimit.truncated": bool(truncated[world]),
                        "is_success": bool(ended.success[number]),
                        "episode": {**_statistics(ended, number, mine), "t": elapsed},
                    }
                )


def _with_partner(config: TransportConfig) -> TransportConfig:
    """The configuration, with the default partner where it has none; one agent is left to learn."""
    if config.partner is None:
        config = replace(config, partner=partners.default_partner(config))
    if len(config.learners) > 1:
        raise InvalidInput(
            f"partner_agents must leave one agent to learn for control='partner', got "
            f"{config.driven} of {config.num_agents}; name more of them, or use 'joint' or 'shared'"
        )
    return config


def _statistics(ended: Episodes, number: int, agents: slice) -> dict[str, float]:
    """Numbers of one episode, rewards averaged over the given agents."""
    return {
        "r": float(ended.reward[number, agents].mean()),
        "l": int(ended.length[number]),
        "relative_cost": float(ended.relative_cost[number]),
        "wasted_cost": float(ended.wasted_cost[number]),
        "internal_force_level": float(ended.internal_force_level[number]),
        "internal_torque_level": float(ended.internal_torque_level[number]),
        "load_imbalance": float(ended.load_imbalance[number]),
        "contact_impulse": float(ended.contact_impulse[number]),
        **{
            f"reward/{name}": float(total[number, agents].mean())
            for name, total in ended.reward_terms.items()
        },
        **{name: float(total[number, agents].mean()) for name, total in ended.costs.items()},
    }
