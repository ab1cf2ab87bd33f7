"""Suites: what they consist of, and that a version stays what it was."""

from dataclasses import fields, replace
from typing import Any

import gymnasium
import numpy as np
import pytest

from coopenv import Transport
from coopenv.agents.benchmark import SUITES, Scenario, find_suites
from coopenv.agents.seeds import BLOCK, HELD_OUT, evaluation_seeds
from coopenv.envs.registry import PREFIX
from coopenv.errors import UnknownName
from coopenv.physics.body import Body

DIGESTS = {
    "team-1": "8286cfc1f6e6068a7a802e87881082f7d4aafacaeebfe28ade82ee666d5c0b72",
    "partners-1": "1e8fc8aa0c24b8fba56db93fe7eb96d10e50a94d2211747a61c2f4681faca6e3",
    "bodies-1": "a557a948643bdaa355b56cd13467f0a643249d4e0ce6e306e0f9d18ae28a0f71",
    "haptics-1": "c7051258ce5cf7038c1dced7b0db5f06870eb3662727700cb18ec3f5054188da",
}
EVERY = [(suite, one) for suite in SUITES.values() for one in suite.scenarios]


def task_of(scenario: Scenario, factor: float = 1.0) -> Any:
    return scenario.within(factor).task


def test_a_suite_that_changes_gets_a_new_version():
    """Whoever changes one raises its version here and there, and measures all entries anew.

    So does whoever changes a default of an environment, or a policy that a suite's partner is.
    """
    assert {suite.label: suite.digest() for suite in SUITES.values()} == DIGESTS


@pytest.mark.parametrize("suite", SUITES.values(), ids=lambda suite: suite.name)
def test_every_scenario_begins_and_has_other_tolerances(suite):
    for one in suite.scenarios:
        core = Transport(num_worlds=1, config=one.config)
        obs, _ = core.reset(seed=[*evaluation_seeds(suite.evaluation, 1)])
        assert np.isfinite(obs).all()
        half, double = (task_of(one, factor).position_tolerance for factor in (0.5, 2.0))
        assert double == pytest.approx(4 * half)


def test_a_team_is_entered_in_every_environment():
    mine = {f"{PREFIX}{one.env}-v0" for one in SUITES["team"].scenarios}
    assert mine == {name for name in gymnasium.registry if name.startswith(PREFIX)}
    assert all(not one.settings for one in SUITES["team"].scenarios)


def test_names_tell_scenarios_apart():
    names = [(suite.name, one.name) for suite, one in EVERY]
    assert len(set(names)) == len(names)


def test_episodes_are_held_out():
    for suite in SUITES.values():
        seeds = evaluation_seeds(suite.evaluation, suite.episodes)
        assert seeds[0] >= HELD_OUT
        assert suite.episodes < BLOCK


def test_half_the_tolerances_are_of_place_alone():
    one = Scenario(name="it", env="BeamLift")
    task, half = task_of(one), task_of(one, 0.5)
    names = [entry.name for entry in fields(task)]
    changed = {
        name: (getattr(task, name), getattr(half, name))
        for name in names
        if getattr(task, name) != getattr(half, name)
    }
    assert set(changed) == {"position_tolerance", "angle_tolerance", "height_tolerance"}
    assert all(half == pytest.approx(whole / 2) for whole, half in changed.values())
    assert one.within(1.0) == one.config


def test_any_angle_stays_any_angle():
    task = replace(task_of(Scenario(name="it", env="BeamTransport")), angle_tolerance=np.pi)
    one = Scenario(name="it", env="BeamTransport", settings={"task": task})
    assert task_of(one, 0.5).angle_tolerance == np.pi
    assert task_of(one, 0.5).position_tolerance == task.position_tolerance / 2


@pytest.mark.parametrize(
    "change",
    [
        {"episodes": 3},
        {"evaluation": 3},
        {"version": 3},
        {"scenarios": (Scenario(name="it", env="BeamTransport"),)},
        {
            "scenarios": (
                Scenario(name="it", env="BeamTransport", settings={"body": Body(mass=7.8)}),
            )
        },
    ],
)
def test_a_digest_is_of_everything_that_figures_depend_on(change):
    suite = replace(SUITES["team"], scenarios=(Scenario(name="one", env="BeamTransport"),))
    assert replace(suite, **change).digest() != suite.digest()


def test_what_is_null_is_not_in_a_digest():
    plain = Scenario(name="it", env="BeamTransport")
    said = Scenario(name="it", env="BeamTransport", settings={"cost": None, "actuators": None})
    suite = SUITES["team"]
    assert suite.digest_of(plain) == suite.digest_of(said)


def test_bodies_are_drawn_out_of_the_training_range():
    suite = SUITES["bodies"]
    drawn = {}
    for one in suite.scenarios:
        core = Transport(num_worlds=64, config=one.config)
        _, info = core.reset(seed=[*evaluation_seeds(suite.evaluation, 64)])
        drawn[one.name] = info["body"]
    inside = drawn["within the training range"]
    assert inside["mass"].min() >= 5
    assert inside["mass"].max() <= 11
    assert drawn["light"]["mass"].max() < 5
    assert drawn["heavy"]["mass"].min() > 11
    assert drawn["rubbing"]["ground_friction"].min() > 0.05
    assert drawn["heavy, BeamDoorway"]["mass"].min() > 11


def test_suites_are_found_by_name_each_once():
    assert find_suites() == tuple(SUITES.values())
    assert [suite.name for suite in find_suites(["bodies", "team", "bodies"])] == ["bodies", "team"]
    with pytest.raises(UnknownName, match="did you mean 'partners'"):
        find_suites(["partner"])
