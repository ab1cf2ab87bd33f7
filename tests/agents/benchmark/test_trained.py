"""Training behind an entry: what files record, what is told, and the budget of a suite."""

import json
from dataclasses import replace

import pytest

from coopenv.agents.benchmark import SUITES, Scenario, conduct, plan, read_entry, read_summary
from coopenv.agents.benchmark.trained import Trained, exceeds, said
from coopenv.errors import InvalidInput
from tests.agents.benchmark.cases import SMALL

ALONE, _ = SMALL.scenarios
SIGHTED = "tests.agents.benchmark.cases:sighted"
JOINT = "pretrained:{task}/joint"


def result_of(given, out, **told):
    outcome = conduct(plan([read_entry(given, **told)], [SMALL], only=["alone"]), out)
    (path,) = outcome.summaries
    return path, read_summary(path).results["alone"]


def test_a_file_says_for_how_many_steps_it_was_trained():
    entry = read_entry(JOINT)
    doorway = Scenario(name="it", env="BeamDoorway")
    assert entry.trained(ALONE) == Trained(901_120)  # 900,000 in whole rollouts of 256 × 32
    assert entry.trained(doorway) == Trained(1_802_240)
    assert read_entry(JOINT, seeds=3).trained(ALONE) == Trained(901_120, 3)


def test_what_does_not_learn_was_not_trained_and_a_function_does_not_tell():
    for word in ("nobody", "random", "scripted"):
        assert read_entry(word).trained(ALONE) == Trained(0)
    assert read_entry(SIGHTED).trained(ALONE) is None
    assert read_entry(SIGHTED, trained=5_000, seeds=2).trained(ALONE) == Trained(5_000, 2)


@pytest.mark.parametrize(
    ("given", "told", "says"),
    [
        (JOINT, {"trained": 900_000}, r"trained must be at least the 901,120 control steps that"),
        (SIGHTED, {"seeds": 3}, r"trained must be told beside seeds, got nothing for 'tests"),
        (SIGHTED, {"trained": -1}, r"trained must be"),
        (SIGHTED, {"trained": 5_000, "seeds": 0}, r"seeds must be"),
        (SIGHTED, {"trained": 0.5}, r"trained must be"),
    ],
)
def test_what_is_told_wrongly_is_refused_before_the_first_episode(given, told, says):
    with pytest.raises(InvalidInput, match=says):
        plan([read_entry(given, **told)], [SMALL], only=["alone"])


def test_a_summary_keeps_what_is_told_and_takes_it_anew_without_running_again(tmp_path):
    path, first = result_of(SIGHTED, tmp_path)
    assert first.trained is None
    assert '"trained"' not in path.read_text()
    _, told = result_of(SIGHTED, tmp_path, trained=5_000, seeds=2)
    assert told == replace(first, trained=Trained(5_000, 2))
    _, kept = result_of(SIGHTED, tmp_path)
    assert kept == told
    _, more = result_of(SIGHTED, tmp_path, trained=8_000)
    assert more.trained == Trained(8_000)


@pytest.mark.parametrize("told", [{"seeds": 1}, {"steps": 5, "seeds": 0}, {"steps": -1}, 7])
def test_a_summary_whose_training_is_none_is_refused(told, tmp_path):
    path, _ = result_of("nobody", tmp_path)
    content = json.loads(path.read_text())
    content["results"]["alone"]["trained"] = told
    path.write_text(json.dumps(content))
    with pytest.raises(InvalidInput, match="must be a summary of coopenv benchmark"):
        read_summary(path)


def test_every_seed_out_of_which_one_was_chosen_counts_against_the_budget():
    assert not exceeds([Trained(400, 2), None], 800)
    assert exceeds([Trained(400, 2)], 799)
    assert not exceeds([], 1)


def test_trainings_are_said_as_one_number_or_from_the_least_to_the_most():
    assert said([Trained(901_120), Trained(901_120)]) == "901,120"
    assert said([Trained(1_000, 5)]) == "1,000 × 5"
    assert said([Trained(2_000), Trained(1_000), Trained(1_500)]) == "1,000 to 2,000"
    assert said([Trained(0), None]) == said([]) == "not told"


def test_policies_of_the_package_are_within_every_budget():
    entries = [read_entry(JOINT), read_entry("pretrained:{task}/shared")]
    for suite in SUITES.values():
        for one in suite.scenarios:
            assert not exceeds([entry.trained(one) for entry in entries], suite.budget)
