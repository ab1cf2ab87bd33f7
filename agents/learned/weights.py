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


class Weights(NamedTuple):
    """Numbers of a model, as its ``save`` parts them."""

    parts: dict[str, Any]  # state dict of each network and optimiser, by name
    variables: dict[str, Any]  # tensors that are in none of them, by name

    def count(self) -> int:
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
    for name, part in weights.parts.items():
        if isinstance(recursive_getattr(model, name), torch.optim.Optimizer):
            _check_optimizer(name, part, wanted[name], recursive_getattr(model, name))
        else:
            _check_network(name, part, wanted[name])
    model.set_parameters(weights.parts, exact_match=True, device="cpu")
    for name, value in weights.variables.items():
        if value is None:
            continue
        target = vars(model).get(name)
        if not torch.is_tensor(target) or not _is_like(value, target):
            raise ValueError(f"{name} is no variable of this model")
        target.data.copy_(value.data)


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


def _check_optimizer(
    name: str, given: Any, wanted: dict[str, Any], optimizer: torch.optim.Optimizer
) -> None:
    """Raise unless groups, options and moments are such as this optimiser has.

    torch takes any, and fails in the first step.
    """
    groups, state = given["param_groups"], given["state"]
    if len(groups) != len(wanted["param_groups"]):
        raise ValueError(f"{name} has {len(groups)} groups")
    for group, known in zip(groups, wanted["param_groups"], strict=True):
        if group["params"] != known["params"] or set(known) - set(group):
            raise ValueError(f"{name} is of other parameters")
        for option, value in known.items():
            if not _is_of_kind(group[option], value):
                raise ValueError(f"{option} of {name} is {group[option]!r:.40}")
    parameters = [each for group in optimizer.param_groups for each in group["params"]]
    for number, moments in state.items():
        shapes = ((), (1,), parameters[number].shape)
        for entry, value in moments.items():
            is_right = isinstance(value, int | float) or (
                torch.is_tensor(value) and tuple(value.shape) in shapes
            )
            if not is_right or not torch.isfinite(torch.as_tensor(value)).all():
                raise ValueError(f"{entry} of {name} is no moment of its parameter")


def _is_of_kind(given: Any, known: Any) -> bool:
    """Whether an option is of the kind of the optimiser's own; numbers are finite."""
    if isinstance(known, tuple):
        return isinstance(given, tuple | list) and len(given) == len(known)
    if isinstance(known, bool) or known is None:
        return given is None or isinstance(given, bool)
    if isinstance(known, int | float):
        is_number = isinstance(given, int | float) and not isinstance(given, bool)
        return is_number and abs(given) < float("inf")
    return type(given) is type(known)
