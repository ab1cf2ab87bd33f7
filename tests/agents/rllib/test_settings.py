"""Settings of a training with RLlib, checked before Ray begins."""

import re
import sys
from typing import Any

import pytest

from coopenv.agents.rllib import RLlibConfig, train, training
from coopenv.errors import CoopenvError, InvalidInput, MissingExtra

WRONG: list[tuple[dict[str, Any], str]] = [
    ({"steps": 100}, "at least one batch, 4,096"),
    ({"worlds": 0}, "worlds must be a whole number of at least 1"),
    ({"runners": -1}, "runners must be a whole number of at least 0"),
    ({"policies": "each"}, "known: own, shared"),
    ({"learning_rate": 0}, "learning_rate must be positive"),
    ({"discount": 1.1}, "discount must be in [0, 1], got 1.1"),
    ({"entropy_weight": -1}, "entropy_weight must be 0 or more, got -1"),
    ({"hidden": ()}, "give at least one"),
    ({"hidden": (0,)}, "hidden must be a whole number of at least 1"),
    ({"seed": -1}, "seed must be"),
    ({"episodes": 2**21}, "at most 1048576 worlds"),
]


@pytest.mark.parametrize(("changes", "said"), WRONG)
def test_a_setting_that_breaks_its_rule_is_told(changes, said):
    with pytest.raises(CoopenvError, match=re.escape(said)):
        RLlibConfig(**changes)


def test_a_policy_that_is_there_is_not_written_over(tmp_path, monkeypatch):
    monkeypatch.setattr(training, "require_rllib", lambda: None)
    (tmp_path / "policy.npz").write_text("mine")
    with pytest.raises(InvalidInput, match="which has one; choose another out"):
        train(RLlibConfig(out=tmp_path))
    assert (tmp_path / "policy.npz").read_text() == "mine"


def test_without_ray_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingExtra, match=r"coopenv\[rllib\]"):
        train(RLlibConfig(out=tmp_path / "out"))
    assert not (tmp_path / "out").exists()
