"""Stable-Baselines3: worlds as a ``VecEnv``, trained models as policies, what a training needs."""

import json
import os
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import gymnasium
import numpy as np
import numpy.typing as npt

from coopenv.arrays import FloatArray
from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written
from coopenv.observation.view import VIEW, WRENCH_UNIT
from coopenv.transition import Transition

from .provenance import NOTES, Provenance
from .settings import find_config
from .vec_env import TransportVecEnv

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
except ImportError as error:
    raise MissingExtra("coopenv.agents.sb3", "train") from error

__all__ = [
    "FallingRate",
    "SB3Policy",
    "Scaled",
    "TransportVecEnv",
    "feature_scale",
    "make_vec_env",
    "save_model",
]


def make_vec_env(
    env: str | TransportConfig = "coopenv/BeamTransport-v0",
    num_worlds: int = 64,
    *,
    control: str = "joint",
    seed: int | None = None,
    render_mode: str | None = None,
    **keywords: Any,
) -> TransportVecEnv:
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
        `coopenv.agents.partners.default_partner`); a row is a world. Agents that a partner drives
        have no part in any of the three.
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


class SB3Policy:
    """A trained Stable-Baselines3 model as a `coopenv.agents.policy.Policy`.

    Whether it moves the whole team or one agent shows in the size of its observation.

    Parameters
    ----------
    model
        Any algorithm of Stable-Baselines3.
    deterministic
        Take the mean action instead of a sample.
    notes
        What else its file is to say, its `coopenv.agents.provenance` for one; as JSON can hold it.
    """

    def __init__(
        self,
        model: BaseAlgorithm,
        *,
        deterministic: bool = True,
        notes: Mapping[str, Any] | None = None,
    ):
        self.model, self.deterministic = model, deterministic
        self.notes = dict(notes or {})

    @classmethod
    def load(cls, path: str | os.PathLike, algorithm: type[BaseAlgorithm] = PPO) -> Self:
        """Read a model from the file that `save` or SB3 itself wrote. Only open files you trust."""
        provenance = Provenance.read(path) if os.path.isfile(path) else None
        notes = provenance.to_notes() if provenance is not None else None
        return cls(algorithm.load(os.fspath(path), device="cpu"), notes=notes)

    def save(self, path: str | os.PathLike) -> None:
        """Write the model to one file, whole or not at all; ``PPO.load`` reads it as well."""
        save_model(self.model, path, notes=self.notes)

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


def save_model(
    model: BaseAlgorithm, path: str | os.PathLike, *, notes: Mapping[str, Any] | None = None
) -> None:
    """``model.save``, but under a temporary name that is then renamed, with ``notes`` in it."""
    with written(path) as part:
        with part.open("wb") as file:
            model.save(file)
        if notes:
            with zipfile.ZipFile(part, "a") as archive:
                archive.writestr(NOTES, json.dumps(notes, indent=2) + "\n")


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
        """Rate when the fraction ``remaining`` of the training is left.

        The last rollout may end beyond the training, where the fraction is negative.
        """
        return self.start * max(remaining, 0.0)


def feature_scale(venv: TransportVecEnv) -> list[float]:
    """One factor a feature, which brings it to order one.

    What is bounded is divided by its bound (ranges by their reach), wrenches by the limits,
    parameters of the body by what they usually are; other lengths and speeds stay in SI units.
    """
    core = venv.transport
    force, torque = core.config.limits().max(axis=0)
    wrench = [1 / force, 1 / force, 1 / torque]
    known: dict[str, Iterable[float]] = {
        block.name: block.spread(wrench, core.num_agents, "scale")
        for block in VIEW
        if block.unit == WRENCH_UNIT
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
