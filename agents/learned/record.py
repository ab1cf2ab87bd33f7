"""Record of the environment that a model was trained in, for the file of its policy."""

import warnings
from typing import Any, Protocol, runtime_checkable

from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.errors import InvalidInput


@runtime_checkable
class Recorded(Protocol):
    """An environment that can say what it is, as `coopenv.agents.sb3.TransportVecEnv`."""

    def to_notes(self) -> dict[str, Any]:
        """As JSON can hold it."""
        ...


def recorded(model: BaseAlgorithm) -> dict[str, Any]:
    """What the model's environment, behind its wrappers, says of itself; else nothing.

    An environment that cannot be written costs no trained policy: a warning says why it is missing.
    """
    venv = model.get_env()
    inside = None if venv is None else venv.unwrapped
    if not isinstance(inside, Recorded):
        return {}
    try:
        return inside.to_notes()
    except InvalidInput as error:
        warnings.warn(
            f"the policy's file does not say which environment it was trained in: {error}; "
            "without it coopenv evaluate needs --env",
            stacklevel=3,
        )
        return {}
