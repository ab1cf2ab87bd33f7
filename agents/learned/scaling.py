"""Scaling of features before a network, and a learning rate that falls: parts of our own models."""

from collections.abc import Sequence
from dataclasses import dataclass

import gymnasium
import torch
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor


class Scaled(BaseFeaturesExtractor):
    """Multiplies each feature by a fixed factor, so that all are of order one for the network.

    The environment's observations stay in SI units; the factors are saved with the policy.
    """

    __module__ = "coopenv.agents.sb3"  # where users import it from, and where pickles look for it

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

    __module__ = "coopenv.agents.sb3"

    start: float

    def __call__(self, remaining: float) -> float:
        """Rate when the fraction ``remaining`` of the training is left.

        The last rollout may end beyond the training, where the fraction is negative.
        """
        return self.start * max(remaining, 0.0)
