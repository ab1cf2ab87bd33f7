"""What can be entered, and what is refused before the first episode."""

import shutil
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from coopenv import Transport
from coopenv.agents import load
from coopenv.agents.benchmark import SUITES, Scenario, plan, read_entry
from coopenv.agents.evaluate import evaluate
from coopenv.agents.partners import Leader
from coopenv.agents.pretrained import file_of
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.benchmark.cases import SMALL, counted

HERE = "tests.agents.benchmark.cases:"
ALONE, BESIDE = SMALL.scenarios


def actions(given, scenario, worlds=3):
    core = Transport(num_worlds=worlds, config=scenario.config)
    obs, _ = core.reset(seed=4)
    assert core.transition is not None
    return read_entry(given).policy(scenario)(obs, core.transition), obs, core


def test_a_function_of_what_is_observed_is_given_that_alone():
    given, obs, _ = actions(f"{HERE}sighted", ALONE)
    np.testing.assert_array_equal(given, np.tanh(obs[..., :3]))
    assert read_entry(f"{HERE}sighted").sees == "observation"
    assert read_entry(f"{HERE}steered").sees == "state"


def test_what_remembers_is_told_where_episodes_begin_whatever_it_is_given():
    counted.clear()
    evaluate(read_entry(f"{HERE}Counting").policy(ALONE), ALONE.config, episodes=3, num_worlds=2)
    assert len(counted) > 2  # of two batches, and where worlds end within one
    plain: Any = read_entry(f"{HERE}sighted").policy(ALONE)
    assert not hasattr(plain, "reset")


def test_a_function_and_a_file_act_as_what_they_stand_for(tmp_path):
    file = shutil.copy(file_of("pretrained:BeamTransport/joint"), tmp_path / "mine.npz")
    expected, obs, core = actions("pretrained:{task}/joint", ALONE)
    np.testing.assert_array_equal(actions(str(file), ALONE)[0], expected)
    policy = load("BeamTransport", "joint")
    assert core.transition is not None
    np.testing.assert_array_equal(policy(obs, core.transition), expected)
    scripted = actions("scripted", ALONE)[0]
    np.testing.assert_array_equal(actions(f"{HERE}made", ALONE)[0], scripted)


def test_each_entry_is_known_by_what_is_behind_it(tmp_path):
    file = shutil.copy(file_of("pretrained:BeamTransport/joint"), tmp_path / "mine.npz")
    one, other = read_entry(str(file)), read_entry("pretrained:{task}/joint")
    assert one.digest(ALONE) == other.digest(ALONE) is not None
    assert read_entry("scripted").digest(ALONE) is None
    digest = read_entry(f"{HERE}sighted").digest(ALONE)
    assert digest is not None
    assert len(digest) == 64


def test_a_policy_of_a_team_takes_one_seat_beside_a_partner():
    scenario = Scenario(name="it", env="BeamTransport", settings={"partner": Leader()})
    for control in ("joint", "shared"):
        given, _, _ = actions(f"pretrained:BeamTransport/{control}", scenario)
        whole, _, _ = actions(
            f"pretrained:BeamTransport/{control}", Scenario(name="it", env="BeamTransport")
        )
        np.testing.assert_allclose(given, whole[:, :1], atol=1e-6)


def test_a_template_stands_for_a_file_of_each_task():
    team = SUITES["team"]
    planned = plan([read_entry("pretrained:{task}/joint")], [team], only=["BeamLift"])
    assert [cell.scenario.env for cell in planned.cells] == ["BeamLift"]
    with pytest.raises(UnknownName, match="WalkerAvoid/alone"):
        plan([read_entry("pretrained:{task}/alone")], [team], only=["WalkerAvoid"])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("scripte", "give nobody, random, scripted, module:function"),
        ("random:0.3", "must have no method behind random"),
        ("pretrained:BeamTransprt/joint", "BeamTransport/joint"),
        ("nowhere/policy.npz", "must be the file of a policy, got 'nowhere/policy.npz'"),
        ("no_such_module:act", "put its folder on PYTHONPATH"),
        (f"{HERE}sigted", "did you mean 'sighted'"),
        (f"{HERE}number", "must be called"),
        (f"{HERE}three", r"takes \(obs, transition, memory\); write act\(obs\)"),
    ],
)
def test_what_cannot_be_entered_is_refused_as_it_is_read(given, says):
    with pytest.raises((InvalidInput, UnknownName), match=says):
        read_entry(given)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("short", r"short must act in the scenario 'alone', got action must have shape"),
        ("broken", r"got ZeroDivisionError: no weight; mend it"),
        ("undefined", r"must be finite"),
        ("nothing", r"must be called"),
    ],
)
def test_what_acts_wrongly_is_refused_before_the_first_episode(given, says):
    with pytest.raises(InvalidInput, match=says):
        plan([read_entry("nobody"), read_entry(f"{HERE}{given}")], [SMALL])


def test_an_entry_is_left_out_where_it_says_that_it_cannot_act():
    entry = read_entry(f"{HERE}team_only")
    planned = plan([entry], [SMALL])
    assert [cell.scenario.name for cell in planned.cells] == ["alone"]
    assert planned.left_out.keys() == {"team_only in team: beside"}
    with pytest.raises(InvalidInput, match="must have no partner"):
        plan([entry], [SMALL], only=["alone", "beside"])
    with pytest.raises(UnknownName, match="did you mean 'alone'"):
        plan([entry], [SMALL], only=["alon"])


def test_a_module_that_leaves_the_interpreter_is_no_module(tmp_path, monkeypatch):
    (tmp_path / "leaving.py").write_text("import sys\nsys.exit(3)\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InvalidInput, match="got 'leaving': SystemExit: 3; mend it"):
        read_entry("leaving:act")


def test_a_file_acts_by_the_blocks_of_its_record_but_where_senses_are_what_is_tried():
    more = Scenario(name="it", env="BeamDoorway", settings={"horizon": 20})
    given, _, _ = actions("pretrained:BeamDoorway/joint", more)  # which saw near_goal too
    assert np.abs(given).max() > 0
    own = Scenario(name="it", env="BeamDoorway", settings={"sensing": "own"})
    with pytest.raises(InvalidInput, match="obs and action must have the sizes"):
        plan([read_entry("pretrained:BeamDoorway/joint")], [replace(SMALL, scenarios=(own,))])


def test_names_become_files_and_differ():
    assert read_entry("pretrained:{task}/joint").name == "pretrained-joint"
    assert read_entry("random", name="carry.2").name == "carry.2"
    assert read_entry(f"{HERE}sighted").name == "sighted"
    with pytest.raises(InvalidInput, match="of letters, digits"):
        read_entry("random", name="../out")
    with pytest.raises(InvalidInput, match="got 'random' twice"):
        plan([read_entry("random"), read_entry("random")], [SMALL])
