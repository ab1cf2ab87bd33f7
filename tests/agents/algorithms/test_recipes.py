"""Settings of other algorithms than PPO: rules, and forms in which they are kept."""

import json
import sys

import pytest

from coopenv.agents.algorithms import RECIPES, RecurrentConfig, SACConfig, recipe_of
from coopenv.agents.algorithms.recipes import name_of, plain, require_installed
from coopenv.errors import CoopenvError, InvalidInput, MissingExtra
from tests.agents.algorithms.cases import SMALL


@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe_comes_back_from_json(name):
    for recipe in (RECIPES[name](), SMALL[name]):
        assert recipe_of(name, json.loads(json.dumps(plain(recipe)))) == recipe
        assert name_of(recipe) == name


WRONG = [
    ("sac", {"steps": 0}, "at least 1"),
    ("sac", {"steps": 5_000}, "random_steps must be fewer than the 5,000 steps"),
    ("sac", {"num_worlds": 10**7}, "num_worlds must be at most"),
    ("sac", {"gradient_steps": 0}, "at least 1"),
    ("sac", {"buffer": 10}, "buffer must hold the 256 samples"),
    ("sac", {"batch_size": 1.5}, "whole"),
    ("sac", {"learning_rate": 0}, "learning_rate must be positive"),
    ("sac", {"learning_rate": 2}, "learning_rate must be at most 1"),
    ("sac", {"discount": 1.01}, "discount must be at most 1"),
    ("sac", {"tau": 0}, "tau must be positive"),
    ("sac", {"entropy": "automatic"}, "entropy must be a weight or auto"),
    ("sac", {"entropy": "auto_1.2.3"}, "entropy must be a weight or auto"),
    ("sac", {"entropy": "auto_0"}, "entropy must be a weight or auto"),
    ("sac", {"entropy": -0.1}, "entropy must be zero or positive"),
    ("sac", {"target_entropy": "low"}, "target_entropy must be a number"),
    ("sac", {"hidden": []}, "hidden must be sizes"),
    ("sac", {"falling": 1}, "falling must be True or False"),
    ("sac", {"buffer": 10**9}, "buffer must be at most"),
    ("sac", {"gradient_step": 1}, "did you mean 'gradient_steps'"),
    ("recurrent", {"units": 0}, "units must be"),
    ("recurrent", {"epochs": 0}, "epochs must be"),
    ("recurrent", {"steps": 8192}, "one rollout"),
    ("recurrent", {"unit": 8}, "did you mean 'units'"),
    ("sacc", {}, "did you mean 'sac'"),
]


@pytest.mark.parametrize(("name", "given", "said"), WRONG)
def test_a_setting_that_breaks_its_rule_is_refused(name, given, said):
    with pytest.raises(CoopenvError, match=said):
        recipe_of(name, given)


def test_a_whole_number_may_be_written_as_a_float_and_is_the_same():
    floats = recipe_of("sac", {"steps": 3e5, "hidden": [64.0, 64.0]})
    assert repr(floats) == repr(SACConfig(steps=300_000))


@pytest.mark.parametrize("entropy", ["auto", "auto_0.1", "auto_1e-3", 0, 0.02])
def test_the_weight_of_the_entropy_is_given_or_learned(entropy):
    assert SACConfig(entropy=entropy).entropy == entropy


def test_recurrent_ppo_has_the_defaults_of_ppo_but_for_its_steps():
    of_ppo = RecurrentConfig().of_ppo(seed=3)
    assert of_ppo == type(of_ppo)(seed=3, steps=RecurrentConfig().steps)


def test_recurrent_ppo_without_its_package_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    with pytest.raises(MissingExtra, match=r"recurrent PPO .*coopenv\[contrib\]"):
        require_installed("recurrent")
    require_installed("sac")


def test_errors_are_of_the_house():
    with pytest.raises(InvalidInput, match=r"^tau must be .*, got 3; "):
        SACConfig(tau=3)
