"""Exploration that narrows as a training goes on."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

import torch

from coopenv import TransportConfig
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.exploration import largest_std, narrow
from coopenv.errors import InvalidInput
from tests.agents.training.cases import SHORT, tiny


def with_spread(*spread: float) -> Any:
    parameter = torch.nn.Parameter(torch.log(torch.tensor(spread)))
    return SimpleNamespace(policy=SimpleNamespace(log_std=parameter))


def spread_of(model: Any) -> np.ndarray:
    return np.exp(model.policy.log_std.detach().numpy())


def test_the_largest_spread_falls_by_the_same_factor_in_every_step_and_stays_at_the_end():
    config = TrainConfig(initial_std=0.8, final_std=0.2)
    found = [largest_std(config, done) for done in (0.0, 0.5, 1.0, 1.1)]
    assert found == pytest.approx([0.8, 0.4, 0.2, 0.2])


def test_by_default_no_spread_is_the_largest():
    assert largest_std(TrainConfig(), 0.5) is None
    model = with_spread(3.0)
    narrow(model, None)
    np.testing.assert_allclose(spread_of(model), [3.0])


def test_what_is_wider_is_narrowed_and_what_is_narrower_stays():
    model = with_spread(0.5, 0.1)
    narrow(model, 0.2)
    np.testing.assert_allclose(spread_of(model), [0.2, 0.1], rtol=1e-6)


def test_a_run_ends_with_actions_as_narrow_as_it_is_told(tmp_path):
    """Four rollouts: the last one begins when three quarters of the steps are done."""
    policy = train(tiny(tmp_path / "wide"), environment=SHORT)
    assert spread_of(policy.model).min() > 0.5
    policy = train(tiny(tmp_path / "narrow", final_std=0.006), environment=SHORT)
    assert spread_of(policy.model).max() < 0.6 * 0.01**0.75 * 1.05  # and one update


def test_a_run_that_goes_on_is_as_narrow_as_one_that_was_not_interrupted(tmp_path):
    config = tiny(tmp_path, final_std=0.006)

    def interrupt(row):
        if row["steps"] >= 96:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(config, environment=SHORT, report=interrupt)
    policy = train(config, environment=SHORT)
    assert spread_of(policy.model).max() < 0.6 * 0.01**0.75 * 1.05


def test_pushes_by_number_have_no_spread_to_narrow(tmp_path):
    discrete = TransportConfig(horizon=8, action="discrete")
    policy = train(tiny(tmp_path, final_std=0.1), environment=discrete)
    assert policy.model.num_timesteps == 128


@pytest.mark.parametrize("final", [0, -0.1, np.nan, "narrow"])
def test_a_spread_that_is_none_is_refused(final):
    with pytest.raises(InvalidInput, match="final_std must be"):
        TrainConfig(final_std=final)
