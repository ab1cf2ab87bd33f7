"""Sampled actions of SB3's policies with keyed noise instead of torch's global generator.

SB3's distributions over boxes are Gaussians, some of them squashed; torch draws their noise by
``normal_``, or ``torch.normal`` in older versions. Those over numbers of pushes are drawn by
``multinomial``, one agent's after the other's. Here all are given numbers of the episode and step,
so that a row's action does not depend on the rows beside it, nor on what was drawn before.
"""

from collections.abc import Callable
from math import prod
from typing import Any

import numpy.typing as npt
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from torch.overrides import TorchFunctionMode

from coopenv.chance import Keys
from coopenv.transition import Transition

from ..noise import EpisodeKeys, normals, uniforms

Predict = Callable[[], tuple[npt.NDArray, Any]]


def can_be_sampled(model: BaseAlgorithm) -> bool:
    """Whether the model acts by a distribution; TD3, DDPG and ARS give one action."""
    actor = getattr(model.policy, "actor", model.policy)
    return hasattr(actor, "action_dist")


def sampled(
    model: BaseAlgorithm, predict: Predict, keys: EpisodeKeys, transition: Transition, rows: int
) -> tuple[npt.NDArray, Any]:
    """What ``predict`` returns for ``rows`` rows when it samples with keyed noise.

    With state-dependent exploration (gSDE) a row's exploration matrix holds for an episode.
    """
    began = keys.follow(transition)
    if getattr(model, "use_sde", False):
        if len(began):
            with _Keyed(keys.of_episode(), rows):
                model.policy.reset_noise(rows)  # type: ignore[operator]
        return predict()
    with _Keyed(keys.of_step(transition), rows):
        return predict()


class _Keyed(TorchFunctionMode):
    """Within it torch's random numbers for ``rows`` rows are those of their worlds.

    What is not drawn row by row (gSDE's matrix for a single row) is that of the first row.
    """

    def __init__(self, keys: Keys, rows: int):
        super().__init__()
        self._keys, self._rows, self._choices = keys, rows, 0

    def __torch_function__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        if func is torch.normal:
            mean, spread = args
            return mean + spread * self._noise(mean)
        if func is torch.Tensor.normal_:
            return args[0].copy_(self._noise(args[0]))  # standard normal: distributions scale it
        if func is torch.multinomial:
            return self._chosen(args[0])
        return func(*args, **(kwargs or {}))

    def _chosen(self, weights: torch.Tensor) -> torch.Tensor:
        """One choice a row by the ``weights`` ``(row, choice)``, another one at every call."""
        each, call = len(weights) // len(self._keys), self._choices
        self._choices += 1
        drawn = uniforms(self._keys, (call + 1) * each)[:, call * each :].reshape(-1, 1)
        reached = weights.double().cumsum(dim=1)
        chosen = (reached <= torch.as_tensor(drawn) * reached[:, -1:]).sum(dim=1, keepdim=True)
        return chosen.clamp(max=weights.shape[1] - 1)

    def _noise(self, like: torch.Tensor) -> torch.Tensor:
        shape, worlds = like.shape, len(self._keys)
        if shape[0] == self._rows:
            drawn = normals(self._keys, prod(shape) // worlds)
        else:
            drawn = normals(self._keys[:1], prod(shape))
        return torch.as_tensor(drawn.reshape(shape), dtype=like.dtype, device=like.device)
