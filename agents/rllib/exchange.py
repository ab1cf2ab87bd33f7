"""RLlib's modules in plain numbers: what acts of them, for one agent or for the whole team."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import torch

from coopenv.errors import InvalidInput

from ..trained import PlainPolicy
from ..trained.form import Form

ALGORITHM = "ray.rllib.algorithms.ppo:PPO"
_ACTIVATIONS = {torch.nn.Tanh: "tanh", torch.nn.ReLU: "relu", torch.nn.SiLU: "silu"}
_SCALE, _SPREAD = "scale", "log_std"

Arrays = dict[str, npt.NDArray[np.float32]]


def plain_policy(
    modules: Sequence[Any],
    scale: npt.ArrayLike,
    spaces: tuple[gymnasium.Space, gymnasium.Space],
    notes: Mapping[str, Any],
) -> PlainPolicy:
    """The policy that acts as RLlib's modules do, to the rounding of single precision.

    Several modules, one an agent, become one network of the team in which each sees its own
    features alone.

    Parameters
    ----------
    modules
        PPO's default ones of dense layers; of numbers, with a spread that depends on nothing
        (``free_log_std``).
    scale
        (feature,) of one agent, by which observations were multiplied.
    spaces
        Of one agent's observations, unscaled, and its actions.
    notes
        Of the policy's file.

    Raises
    ------
    InvalidInput
        If they act by something else than dense layers.
    """
    parts = [_layers(module) for module in modules]
    arrays: Arrays = {_SCALE: np.tile(np.asarray(scale, dtype=np.float32), len(parts))}
    layers = []
    for number, group in enumerate(zip(*parts, strict=True)):
        names = f"layer_{number}.weight", f"layer_{number}.bias"
        arrays[names[0]] = _diagonal([weight for weight, _, _ in group])
        arrays[names[1]] = np.concatenate([bias for _, bias, _ in group])
        layers.append([*names, group[0][2]])
    chooses = isinstance(spaces[1], gymnasium.spaces.Discrete)
    if not chooses:
        arrays[_SPREAD] = np.concatenate([_numbers(module.pi.log_std) for module in modules])
    said = {
        "scale": _SCALE,
        "layers": layers,
        "output": "scores" if chooses else "clip",
        "spread": None if chooses else _SPREAD,
    }
    row = tuple(_of_team(space, len(parts)) for space in spaces)
    form = Form.of(
        said,
        (row[0], row[1]),
        arrays,
        algorithm=ALGORITHM,
        normalization=None,
        blueprint={},
        notes=notes,
    )
    return PlainPolicy(form)


def _layers(module: Any) -> list[tuple[npt.NDArray, npt.NDArray, str]]:
    """Weight, bias and activation of each layer from what is seen to the action."""
    found: list[tuple[npt.NDArray, npt.NDArray, str]] = []
    for each in (*module.encoder.actor_encoder.net.mlp, *module.pi.net.mlp):
        name = _ACTIVATIONS.get(type(each))
        if type(each) is torch.nn.Linear:
            found.append((_numbers(each.weight), _numbers(each.bias), "identity"))
        elif name and found and found[-1][2] == "identity":
            found[-1] = (*found[-1][:2], name)
        else:
            raise InvalidInput(
                f"policy must act by dense layers with {', '.join(_ACTIVATIONS.values())}, got "
                f"{each!s:.60}; keep RLlib's own checkpoint"
            )
    return found


def _numbers(tensor: Any) -> npt.NDArray[np.float32]:
    return tensor.detach().cpu().numpy().astype(np.float32)


def _diagonal(blocks: Sequence[npt.NDArray]) -> npt.NDArray[np.float32]:
    """Matrices one after the other along the diagonal, and zeros."""
    rows, columns = (sum(block.shape[axis] for block in blocks) for axis in (0, 1))
    whole = np.zeros((rows, columns), dtype=np.float32)
    row = column = 0
    for block in blocks:
        whole[row : row + block.shape[0], column : column + block.shape[1]] = block
        row, column = row + block.shape[0], column + block.shape[1]
    return whole


def _of_team(space: Any, agents: int) -> gymnasium.Space:
    """The space of so many agents in a row."""
    if agents == 1:
        return space
    if isinstance(space, gymnasium.spaces.Discrete):
        return gymnasium.spaces.MultiDiscrete([int(space.n)] * agents)
    low, high = np.tile(space.low, agents), np.tile(space.high, agents)
    return gymnasium.spaces.Box(low, high, dtype=np.float32)
