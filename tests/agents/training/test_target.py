"""Trainings that end where enough held-out episodes succeed."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv import TransportConfig, TransportTask
from coopenv.agents.seeds import HELD_OUT, STOPPING, evaluation_seeds, training_seeds
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training import target
from coopenv.agents.training.progress import Progress
from coopenv.errors import InvalidInput
from tests.agents.training.cases import SHORT, tiny

WIDE = {"position_tolerance": 10.0, "angle_tolerance": 4.0, "speed_tolerance": 100.0}
ALWAYS = TransportConfig(
    task=TransportTask(**WIDE, spin_tolerance=100.0), horizon=8
)  # succeeds in the first step
MODEL: Any = None  # of which the stand-in for episodes knows nothing
PROMISING = Progress(steps=32, window=[[{"success": 1.0}]])


class Seen:
    """Stands for `run_episodes`: of which numbers of episodes how many succeed."""

    def __init__(self, successes):
        self.successes, self.asked = successes, []

    def __call__(self, policy, config, *, episodes, seed, num_worlds):
        self.asked.append((episodes, seed))

        class Episodes:
            length = np.ones(episodes)
            success = np.arange(episodes) < self.successes[episodes]

        return Episodes


@pytest.fixture
def seen(monkeypatch):
    def of(successes):
        stand_in = Seen(successes)
        monkeypatch.setattr(target, "run_episodes", stand_in)
        monkeypatch.setattr(target, "SB3Policy", lambda model: model)
        return stand_in

    return of


def test_a_run_ends_after_the_update_whose_policy_succeeds_and_says_so(tmp_path):
    told, rows = [], []
    policy = train(
        tiny(tmp_path, until=0.98), environment=ALWAYS, report=rows.append, tell=told.append
    )
    assert [row["steps"] for row in rows] == [32]  # of 128
    assert policy.model.num_timesteps == 32
    assert len(told) == 1
    assert told[0].startswith("100.0% of 500 held-out episodes succeed")
    assert (tmp_path / "policy.zip").exists()
    assert not (tmp_path / "checkpoint.zip").exists()


def test_the_same_command_again_takes_the_policy_and_one_without_a_target_goes_on(tmp_path):
    config = tiny(tmp_path, until=0.9)
    train(config, environment=ALWAYS)
    rows, told = [], []
    again = train(config, environment=ALWAYS, report=rows.append, tell=told.append)
    assert again.model.num_timesteps == 32
    assert not rows
    assert "100.0%" in told[-1]
    train(replace(config, until=None), environment=ALWAYS, report=rows.append)
    assert rows[-1]["steps"] == 128


def test_a_target_that_is_not_reached_is_told_and_changes_nothing_of_the_run(tmp_path):
    told = []
    one = train(tiny(tmp_path / "a", until=0.98), environment=SHORT, tell=told.append)
    assert one.model.num_timesteps == 128
    assert told == ["128 steps are done and until=0.98 is not reached; more steps go on from there"]
    other = train(tiny(tmp_path / "b"), environment=SHORT)
    for mine, theirs in zip(
        one.model.policy.parameters(), other.model.policy.parameters(), strict=True
    ):
        np.testing.assert_array_equal(mine.detach().numpy(), theirs.detach().numpy())


def test_the_lower_end_of_the_interval_has_to_reach_the_target(seen):
    """At 0.98: 496 of 500 leave 0.9796 by Wilson's interval, 497 leave 0.9825."""
    seen({50: 50, 500: 496})
    target.Target(0.98, SHORT).check(MODEL, PROMISING)
    seen({50: 50, 500: 497})
    with pytest.raises(target.Reached, match=r"99.4% of 500 .* from 98.3%\) after 32 steps"):
        target.Target(0.98, SHORT).check(MODEL, PROMISING)


def test_few_episodes_are_enough_to_see_that_a_policy_is_far_off(seen):
    stand_in = seen({50: 46, 500: 500})
    target.Target(0.98, SHORT).check(MODEL, PROMISING)
    assert stand_in.asked == [(50, STOPPING)]


def test_nothing_is_checked_before_the_exploring_policy_succeeds_half_as_often(seen):
    stand_in = seen({50: 50, 500: 500})
    for window in ([], [[]], [[{"success": 0.0}, {"success": 0.0}, {"success": 1.0}]]):
        target.Target(0.98, SHORT).check(MODEL, Progress(steps=32, window=window))
    assert not stand_in.asked


@pytest.mark.parametrize(("before", "lately"), [(1.0, 0.0), (0.0, 1.0)])
def test_the_newest_rollout_says_whether_anything_is_checked(before, lately, seen):
    stand_in = seen({50: 0, 500: 0})
    window = [[{"success": before}], [{"success": lately}]]
    target.Target(0.98, SHORT).check(MODEL, Progress(steps=32, window=window))
    assert bool(stand_in.asked) == (lately == 1.0)


def test_episodes_that_end_a_run_are_in_no_training_and_in_no_other_evaluation():
    stopping = evaluation_seeds(STOPPING, 500)
    assert stopping[0] > evaluation_seeds(STOPPING - 1, 500)[-1]
    assert stopping[0] > HELD_OUT > training_seeds(STOPPING, 4)[-1]
    with pytest.raises(InvalidInput):
        evaluation_seeds(STOPPING + 1, 1)  # it is the last


@pytest.mark.parametrize("until", [0, 1, 1.5, -0.1])
def test_a_target_that_no_number_of_episodes_shows_is_refused(until):
    with pytest.raises(InvalidInput, match="until must be above 0 and below 1"):
        TrainConfig(until=until)


@pytest.mark.parametrize("until", [np.nan, "all", True])
def test_a_target_is_a_number(until):
    with pytest.raises(InvalidInput, match="until must be"):
        TrainConfig(until=until)
