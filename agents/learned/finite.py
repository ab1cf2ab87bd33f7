"""Divergence of a learned model: parameters and actions that are no finite numbers any more."""

import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from coopenv.errors import InvalidInput

DIVERGED = (
    "actions of a policy must be finite, got nan or inf: its training diverged; train anew with a "
    "lower learning_rate"
)
_OF_A_DISTRIBUTION = "to satisfy the constraint"  # torch's words for a mean or spread that is none


def require_finite(model: BaseAlgorithm, whose: str) -> None:
    """Raise `InvalidInput` unless all parameters are finite; ``whose`` is for the error."""
    for name, value in model.policy.state_dict().items():
        if not torch.isfinite(value).all():
            raise InvalidInput(
                f"weights {whose} must be finite, got nan or inf in {name}: its training diverged; "
                "train anew with a lower learning_rate"
            )


def has_diverged(model: BaseAlgorithm, error: ValueError) -> bool:
    """Whether ``error`` is what torch or an environment says of a model that has diverged."""
    if _OF_A_DISTRIBUTION in str(error):
        return True
    values = model.policy.state_dict().values()
    return not all(bool(torch.isfinite(value).all()) for value in values)
