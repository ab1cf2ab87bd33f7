"""Keywords of a model as plain JSON values and back: numbers, text, classes of a fixed list."""

from collections.abc import Mapping
from enum import Enum
from math import isfinite
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.sb2_compat.rmsprop_tf_like import RMSpropTFLike
from stable_baselines3.common.torch_layers import FlattenExtractor

from ..trained.spaces import NotPlain
from .scaling import FallingRate, Scaled

_OPTIMIZERS = ("Adadelta", "Adagrad", "Adam", "AdamW", "Adamax", "NAdam", "RAdam", "RMSprop", "SGD")
CLASSES: Mapping[str, type] = {  # all that a file may name; nothing is imported for a name
    **{
        f"torch.nn.{name}": getattr(torch.nn, name)
        for name in torch.nn.modules.activation.__all__
        if name != "MultiheadAttention"
    },
    **{f"torch.optim.{name}": getattr(torch.optim, name) for name in _OPTIMIZERS},
    "stable_baselines3.RMSpropTFLike": RMSpropTFLike,
    "stable_baselines3.FlattenExtractor": FlattenExtractor,
    "coopenv.agents.sb3.Scaled": Scaled,
}


def shown(value: Any) -> Any:
    """``value`` as JSON has it; raises `NotPlain` for what is not made of plain values.

    Parameters
    ----------
    value
        None, truth values, numbers, text, lists, tuples and dictionaries of these, classes of
        `CLASSES`, or a `FallingRate`.
    """
    if isinstance(value, Enum):
        value = value.value
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or type(value) in (bool, int, str):
        return value
    if isinstance(value, float) and isfinite(value):
        return float(value)
    if isinstance(value, list):
        return [shown(item) for item in value]
    if isinstance(value, tuple):
        return {"tuple": [shown(item) for item in value]}
    if isinstance(value, dict) and all(isinstance(name, str) for name in value):
        return {"dict": {name: shown(item) for name, item in value.items()}}
    if type(value) is FallingRate:
        return {"falling": shown(value.start)}
    name = next((name for name, known in CLASSES.items() if known is value), None)
    if name is None:
        raise NotPlain(f"{value!r:.80}")
    return {"class": name}


def revived(value: Any) -> Any:
    """What `shown` wrote; raises `ValueError` for anything else."""
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float) and isfinite(value):
        return value
    if isinstance(value, list):
        return [revived(item) for item in value]
    if isinstance(value, dict) and len(value) == 1:
        ((kind, inside),) = value.items()
        if kind == "tuple" and isinstance(inside, list):
            return tuple(map(revived, inside))
        if kind == "dict" and isinstance(inside, dict):
            return {name: revived(item) for name, item in inside.items()}
        if kind == "class" and isinstance(inside, str) and inside in CLASSES:
            return CLASSES[inside]
        if kind == "falling" and isinstance(inside, float | int):
            return FallingRate(float(inside))
    raise ValueError(f"{value!r:.80} is no value that a policy's file may hold")
