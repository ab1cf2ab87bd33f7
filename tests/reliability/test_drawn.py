"""What the soak test draws at random: all that an environment can be told, and nothing refused."""

from dataclasses import fields, replace

import numpy as np
import pytest

pytest.importorskip("tyro")

from benchmarks.soak.drawn.features import FEATURES, any_decomposition, any_environment, ids
from benchmarks.soak.drawn.pushes import any_actions
from benchmarks.soak.drawn.ranges import any_ranges
from benchmarks.soak.drawn.teams import any_actuators
from coopenv import Actuators, Hands, Ranges, Scene, Transport, TransportConfig
from coopenv.config import ACTIONS
from coopenv.envs.registry import find_config

BASE = TransportConfig(action="motion", hands=Hands(), scene=Scene(gravity=(0.0, -1.0)))
ENV = "coopenv/BeamTransport-v0"
TIMES = 60


def drawn(*features, times: int = TIMES) -> list[dict]:
    """Keywords that each feature drew, many times."""
    generators = [np.random.default_rng(seed) for seed in range(times)]
    return [draw(rng, ENV, BASE) for rng in generators for draw in features]


def test_all_fields_of_a_configuration_are_drawn():
    found = [set(keywords) for keywords in drawn(*FEATURES)]
    missing = {entry.name for entry in fields(TransportConfig)} - set.union(*found)
    assert not missing
    kinds = {keywords["action"] for keywords in drawn(*FEATURES) if "action" in keywords}
    assert kinds == set(ACTIONS)


@pytest.mark.parametrize(
    ("feature", "name", "kind"),
    [(any_ranges, "randomise", Ranges), (any_actuators, "actuators", Actuators)],
)
def test_all_that_is_drawn_anew_and_all_of_actuators_are_drawn(feature, name, kind):
    values, usual = [keywords[name] for keywords in drawn(feature)], kind()
    for entry in fields(kind):
        default = getattr(usual, entry.name)
        assert any(getattr(value, entry.name) != default for value in values), entry.name
        assert any(getattr(value, entry.name) == default for value in values), entry.name


def test_surroundings_are_drawn_with_every_solver_that_takes_them():
    settings = [each["decomposition"] for each in drawn(any_decomposition, times=400)]
    found = {(each.method, each.solver) for each in settings if each.surroundings}
    assert found == {(name, "auto") for name in ("optimal", "point_mass")} | {
        ("optimal", solver) for solver in ("structured", "conic")
    }


@pytest.mark.parametrize("env", ids())
def test_nothing_is_refused_as_it_is_drawn(env):
    config = find_config(env, {})
    for seed in range(TIMES):
        for draw in FEATURES:
            assert draw(np.random.default_rng(seed), env, config)


def test_actions_of_all_kinds_are_those_that_a_core_takes():
    for action in ACTIONS:
        hands = BASE.hands if action in ("motion", "impedance") else None
        core = Transport(num_worlds=7, config=replace(BASE, action=action, hands=hands))
        core.reset(seed=0)
        for given in any_actions(np.random.default_rng(0), core, 3):
            core.step(given)


def test_an_environment_is_a_function_of_its_seed():
    for seed in range(5):
        one, other = (any_environment(np.random.default_rng(seed), 5) for _ in range(2))
        assert one == other
