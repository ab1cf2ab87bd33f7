"""Stable-Baselines3: a native ``VecEnv`` over the batched core, and trained models as policies."""

import os
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import gymnasium
import numpy as np
import numpy.typing as npt

from coopenv.arrays import BoolArray, FloatArray, IntArray
from coopenv.config import TransportConfig
from coopenv.envs.common import (
    Pictures,
    agent_action_space,
    agent_observation_space,
    check_render_mode,
    start_options,
    team_action_space,
    team_actions,
    team_observation_space,
)
from coopenv.errors import InvalidInput, MissingExtra, UnknownName
from coopenv.files import written
from coopenv.transition import Transition
from coopenv.transport import Transport

from . import partners
from .episodes import Episodes, EpisodeSums
from .settings import find_config

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from stable_baselines3.common.vec_env import VecEnv
except ImportError as error:
    raise MissingExtra("coopenv.agents.sb3", "train") from error

CONTROLS = ("joint", "shared", "partner")


def make_vec_env(
    env: str | TransportConfig = "coopenv/BeamTransport-v0",
    num_worlds: int = 64,
    *,
    control: str = "joint",
    seed: int | None = None,
    render_mode: str | None = None,
    **keywords: Any,
) -> "TransportVecEnv":
    """A Stable-Baselines3 ``VecEnv`` in which all worlds are stepped together.

    Parameters
    ----------
    env
        A Gymnasium id of this package, or a whole configuration.
    num_worlds
        Worlds stepped together.
    control
        ``"joint"``: one policy moves the whole team; a row is a world. ``"shared"``: every agent
        runs the same policy on what it sees itself; a row is an agent. ``"partner"``: somebody
        else drives all agents but one (``partner=``, by default
        `coopenv.agents.partners.DEFAULT`); a row is a world. Agents that a partner drives have no
        part in any of the three.
    seed
        World k is seeded with ``seed + k`` at the first reset.
    render_mode
        ``"rgb_array"`` or ``None``.
    **keywords
        Fields of `coopenv.TransportConfig`, over those of the id; not beside a configuration.
    """
    config = find_config(env, keywords)
    venv = TransportVecEnv(config, num_worlds, control=control, render_mode=render_mode)
    if seed is not None:
        venv.seed(seed)
    return venv


class TransportVecEnv(VecEnv):
    """All worlds of a `coopenv.Transport` as rows of a ``VecEnv``, with autoreset.

    ============  ==============  =================  ===============  ====================
    control       rows            observation        action           reward
    ============  ==============  =================  ===============  ====================
    ``joint``     world           all agents' sight  all agents'      mean over the team
    ``shared``    world · n + i   agent i's sight    agent i's        agent i's own
    ``partner``   world           the learner's      the learner's    the learner's
    ============  ==============  =================  ===============  ====================

    Agents, and their number n, are those whom no partner drives.

    Infos are empty but in the step that ends an episode; there they hold ``is_success``,
    ``terminal_observation``, ``TimeLimit.truncated`` and ``episode``: ``r`` return, ``l`` length
    [steps], ``t`` seconds since the start, then means over the episode's steps (`Episodes`) and,
    as ``reward/<term>``, the sum of each reward term.

    The rows share one object, so attributes are set and methods called once for all of them.

    Attributes
    ----------
    transport
        The core.
    """

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
        joint = control != "shared"
        observation = team_observation_space if joint else agent_observation_space
        action = team_action_space if joint else agent_action_space
        super().__init__(
            self.transport.num_worlds * self._rows,
            observation(self.transport),
            action(self.transport),
        )

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
        """Step every world, and reset those whose episode ended."""
        obs, reward, terminated, truncated, info = self.transport.step(self._action)
        self._sums.add(reward, info)
        done = terminated | truncated
        infos: list[dict] = [{} for _ in range(self.num_envs)]
        if done.any():
            worlds = np.flatnonzero(done)
            self._report(infos, worlds, self._sums.take(worlds), obs, truncated)
            obs, _ = self.transport.reset(mask=done)
        rewards = reward.reshape(-1) if self.control == "shared" else reward.mean(axis=1)
        return self._by_row(obs), rewards.astype(np.float32), np.repeat(done, self._rows), infos

    def close(self) -> None:
        """Close what draws."""
        self._pictures.close()

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed world k with ``seed + k`` at the next reset; all rows of a world have its seed."""
        if seed is None:
            seed = int(np.random.default_rng().integers(2**31))
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
        """Call a method of the core once; the answer is repeated for each index."""
        answer = getattr(self.transport, method_name)(*method_args, **method_kwargs)
        return [answer for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """True for ``Monitor``: episode statistics are reported as that wrapper would."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[npt.NDArray | None]:
        """One picture a world."""
        return [self._pictures.draw(world) for world in range(self.transport.num_worlds)]

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
        config = replace(config, partner=partners.DEFAULT)
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
        "internal_force_level": float(ended.internal_force_level[number]),
        "internal_torque_level": float(ended.internal_torque_level[number]),
        "load_imbalance": float(ended.load_imbalance[number]),
        "contact_impulse": float(ended.contact_impulse[number]),
        **{
            f"reward/{name}": float(total[number, agents].mean())
            for name, total in ended.reward_terms.items()
        },
    }


class SB3Policy:
    """A trained Stable-Baselines3 model as a `coopenv.agents.policy.Policy`.

    Whether it moves the whole team or one agent shows in the size of its observation.

    Parameters
    ----------
    model
        Any algorithm of Stable-Baselines3.
    deterministic
        Take the mean action instead of a sample.
    """

    def __init__(self, model: BaseAlgorithm, *, deterministic: bool = True):
        self.model, self.deterministic = model, deterministic

    @classmethod
    def load(cls, path: str | os.PathLike, algorithm: type[BaseAlgorithm] = PPO) -> Self:
        """Read a model from the file that `save` or SB3 itself wrote. Only open files you trust."""
        return cls(algorithm.load(os.fspath(path), device="cpu"))

    def save(self, path: str | os.PathLike) -> None:
        """Write the model to one file, whole or not at all; ``PPO.load`` reads it as well."""
        save_model(self.model, path)

    def __call__(self, obs: npt.NDArray, transition: Transition) -> FloatArray:
        """Actions ``(world, learner, action_size)``."""
        num_worlds, num_agents, size = obs.shape
        seen = self.model.observation_space.shape
        if seen == (num_agents * size,):
            rows = obs.reshape(num_worlds, -1)
        elif seen == (size,):
            rows = obs.reshape(num_worlds * num_agents, -1)
        else:
            raise InvalidInput(
                f"obs must have the {seen} features the policy was trained on, for the team or "
                f"each agent, got {num_agents} agents of {size}; evaluate it with the same observe="
            )
        action, _ = self.model.predict(rows, deterministic=self.deterministic)
        return action.reshape(num_worlds, num_agents, -1).astype(np.float64)


def save_model(model: BaseAlgorithm, path: str | os.PathLike) -> None:
    """``model.save``, but under a temporary name that is then renamed."""
    with written(path) as part, part.open("wb") as file:
        model.save(file)


class Scaled(BaseFeaturesExtractor):
    """Multiplies each feature by a fixed factor, so that all are of order one for the network.

    The environment's observations stay in SI units; the factors are saved with the policy.
    """

    def __init__(self, observation_space: gymnasium.spaces.Box, scale: Sequence[float]):
        super().__init__(observation_space, features_dim=len(scale))
        self.scale: torch.Tensor
        self.register_buffer("scale", torch.tensor(scale, dtype=torch.float32))

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Scaled features."""
        return observations * self.scale


@dataclass(frozen=True)
class FallingRate:
    """A learning rate that falls linearly to zero; unlike a lambda it survives saving."""

    start: float

    def __call__(self, remaining: float) -> float:
        """Rate when the fraction ``remaining`` of the training is left."""
        return self.start * remaining


def feature_scale(venv: TransportVecEnv) -> list[float]:
    """One factor a feature, which brings it to order one.

    What is bounded is divided by its bound (ranges by their reach), wrenches by the limits,
    parameters of the body by what they usually are; other lengths and speeds stay in SI units.
    """
    core = venv.transport
    force, torque = core.config.limits().max(axis=0)
    wrench = [1 / force, 1 / force, 1 / torque]
    others = wrench * (core.num_agents - 1)
    known: dict[str, Iterable[float]] = {
        "own_wrench": wrench,
        "partner_wrench": others,
        "own_internal": wrench,
        "partner_internal": others,
    }
    usual = core.conditions.parameters()
    body = [1 / (np.abs(value).max() or 1.0) for value in usual.values() if value.ndim == 1]
    limits = [1 / force, 1 / torque]
    known["body"] = [*body, 1.0, *limits, *[1.0, 1.0, *limits] * (core.num_agents - 1)]
    bound = np.maximum(np.abs(core.observation.low), np.abs(core.observation.high))
    scale = np.where(np.isfinite(bound) & (bound > 0), 1 / np.maximum(bound, 1e-9), 1.0)
    for name, where in core.observation.blocks.items():
        if name in known:
            scale[where] = list(known[name])
    rows = 1 if venv.control == "shared" else len(core.learners)
    return np.tile(scale, rows).tolist()
