"""Weights and optimiser states in a model's file: read as numbers alone, and checked."""

import io
import pickle
import zipfile
from typing import Any, NamedTuple

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.save_util import recursive_getattr

from coopenv.errors import InvalidInput

_SUFFIX, _VARIABLES = ".pth", "pytorch_variables"
_MOST = 1e15  # of an optimiser's steps, and of its rate
_COUNTS = ("step", "mu_product")  # of an optimiser's memory: one number for a parameter


class Weights(NamedTuple):
    """Numbers of a model, as its ``save`` parts them."""

    parts: dict[str, Any]  # state dict of each network and optimiser, by name
    variables: dict[str, Any]  # tensors that are in none of them, by name

    def numbers(self) -> int:
        """How many numbers the policy's networks have."""
        tensors = (each for each in self.parts["policy"].values() if torch.is_tensor(each))
        return sum(tensor.numel() for tensor in tensors)


def read_weights(archive: zipfile.ZipFile, source: str) -> Weights:
    """All weights in an archive; ``source`` names it in errors.

    torch reads no more than tensors, numbers and text here (``weights_only``), so that nothing in
    the file is run.

    Raises
    ------
    InvalidInput
        If a member is damaged or holds anything else.
    """
    found = {}
    for member in archive.namelist():
        if not member.endswith(_SUFFIX):
            continue
        data = io.BytesIO(archive.read(member))
        try:
            found[member.removesuffix(_SUFFIX)] = torch.load(
                data, map_location="cpu", weights_only=True
            )
        except pickle.UnpicklingError as error:
            raise InvalidInput(
                f"policy must hold numbers alone as its weights, got {member} in {source!r}, which "
                "is damaged or holds something else; copy it again, or do not use it"
            ) from error
    variables = found.pop(_VARIABLES, None) or {}
    if not all(isinstance(part, dict) for part in (variables, *found.values())):
        raise ValueError("its weights have no names")
    return Weights(found, variables)


def put_weights(model: BaseAlgorithm, weights: Weights) -> None:
    """Set networks, optimisers and variables of a model of the same build.

    Raises
    ------
    ValueError, RuntimeError
        If names, shapes or kinds are others than the model's.
    """
    wanted = model.get_parameters()
    if set(wanted) != set(weights.parts):
        raise ValueError(f"it has {', '.join(weights.parts)}, not {', '.join(wanted)}")
    parts = {}
    for name, part in weights.parts.items():
        inside = recursive_getattr(model, name)
        if isinstance(inside, torch.optim.Optimizer):
            parts[name] = _memory(name, part, wanted[name], inside)
        else:
            _check_network(name, part, wanted[name])
            parts[name] = part
    model.set_parameters(parts, exact_match=True, device="cpu")
    for name, value in weights.variables.items():
        if value is None:
            continue
        target = vars(model).get(name)
        if not torch.is_tensor(target) or not _is_like(value, target):
            raise ValueError(f"{name} is no variable of this model")
        target.data.copy_(value.data)


def put_policy(model: BaseAlgorithm, state: dict[str, torch.Tensor]) -> None:
    """Set the networks that act and rate of a model of the same build; its optimisers stay new.

    Raises
    ------
    ValueError
        If names, shapes or kinds are others than the model's.
    """
    wanted = model.policy.state_dict()
    if set(wanted) != set(state):
        raise ValueError(f"it has {len(state)} arrays, not the {len(wanted)} of its model")
    _check_network("policy", state, wanted)
    model.policy.load_state_dict(state)


def _check_network(name: str, given: Any, wanted: dict[str, Any]) -> None:
    for key, value in wanted.items():
        if not torch.is_tensor(value):
            continue
        if key not in given or not _is_like(given[key], value):
            raise ValueError(f"{key} of {name} has another shape")


def _is_like(given: Any, wanted: torch.Tensor) -> bool:
    """Whether it is a plain tensor of that shape and kind of numbers."""
    return (
        torch.is_tensor(given)
        and given.layout == torch.strided
        and given.shape == wanted.shape
        and given.is_floating_point() == wanted.is_floating_point()
        and not given.is_complex()
        and not given.is_quantized
        and given.device == wanted.device
    )


def _memory(
    name: str, given: Any, wanted: dict[str, Any], optimizer: torch.optim.Optimizer
) -> dict[str, Any]:
    """An optimiser's state with the model's own options; of the file's the rate alone may differ.

    torch takes any state, and fails in the first step. Versions of it differ in their options, so
    that those which the file does not have are no damage.
    """
    groups, state = given["param_groups"], given["state"]
    if len(groups) != len(wanted["param_groups"]):
        raise ValueError(f"{name} has {len(groups)} groups")
    taken = []
    for group, known in zip(groups, wanted["param_groups"], strict=True):
        rate = group["lr"]
        for option, value in group.items():
            if option in known and option != "lr" and value != known[option]:
                raise ValueError(f"{option} of {name} is {value!r:.40}")
        if not _is_count(rate):
            raise ValueError(f"lr of {name} is {rate!r:.40}")
        taken.append({**known, "lr": rate})
    if len({frozenset(moments) for moments in state.values()}) > 1:
        raise ValueError(f"{name} lacks moments of some parameters")
    parameters = [each for group in optimizer.param_groups for each in group["params"]]
    for number, moments in state.items():
        shape = parameters[number].shape
        for entry, value in moments.items():
            if not (_is_count(value) if entry in _COUNTS else _is_moment(value, shape)):
                raise ValueError(f"{entry} of {name} is no moment of its parameter")
    return {"state": state, "param_groups": taken}


def _is_count(value: Any) -> bool:
    """Whether it is one number that is not negative, as it is or in a tensor."""
    if torch.is_tensor(value):
        return _is_moment(value, torch.Size()) and value.item() >= 0
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < _MOST


def _is_moment(value: Any, shape: torch.Size) -> bool:
    """Whether it is what an optimiser remembers of a parameter of that shape."""
    return (
        torch.is_tensor(value)
        and value.layout == torch.strided
        and value.is_floating_point()
        and value.shape == shape
        and bool(torch.isfinite(value).all())
    )
