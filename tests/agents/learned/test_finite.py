"""A model has diverged as soon as one of its numbers is none."""

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")

import torch

from coopenv.agents.learned.finite import has_diverged, require_finite
from coopenv.errors import InvalidInput

OTHER = ValueError("of another kind")


@pytest.fixture
def model() -> Any:
    return SimpleNamespace(policy=torch.nn.Linear(3, 2))


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
def test_one_number_that_is_not_finite_is_enough(number, model):
    require_finite(model, "of a test")
    assert not has_diverged(model, OTHER)
    with torch.no_grad():
        model.policy.weight[1, 2] = number
    assert has_diverged(model, OTHER)
    with pytest.raises(InvalidInput, match=r"weights of a test must be finite, .* in weight: its"):
        require_finite(model, "of a test")


def test_what_a_distribution_refuses_is_divergence_though_weights_are_finite(model):
    with pytest.raises(ValueError, match="constraint") as refused:
        torch.distributions.Normal(torch.full((2,), torch.nan), torch.ones(2), validate_args=True)
    assert has_diverged(model, refused.value)
