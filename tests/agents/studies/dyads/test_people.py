"""Simulated pairs of people: what they know, how they differ, what a study of them records."""

from dataclasses import fields

import numpy as np
import pytest

pytest.importorskip("statsmodels")
pytest.importorskip("matplotlib")
pytest.importorskip("pyarrow")
pytest.importorskip("pandas")

import pandas as pd

from coopenv import cli
from coopenv.agents.partners.person import Person
from coopenv.agents.studies.dyads.analysis import GUIDES, quadrant_shares
from coopenv.agents.studies.dyads.config import DyadsConfig
from coopenv.agents.studies.dyads.people import Pairs, People
from coopenv.agents.studies.dyads.reading import read_trials
from coopenv.agents.studies.dyads.simulation import simulate
from coopenv.agents.studies.dyads.trials import first_to_enter
from coopenv.errors import InvalidInput
from coopenv.physics.scene import Box
from coopenv.transport import Transport
from tests.agents.studies.printed import files_named

BRIEF = DyadsConfig(pairs=3, trials=2, seconds=14.0, dt=0.04)


@pytest.fixture(scope="module")
def run():
    return simulate(BRIEF)


def test_every_trait_is_drawn_as_said_and_differs_between_people():
    people = People()
    drawn = people.draw(0, 200)
    for entry in fields(people):
        span, values = getattr(people, entry.name), getattr(drawn, entry.name)
        assert values.shape[:2] == (200, 2)
        assert len(np.unique(values)) == values.size
        if isinstance(span, tuple):
            assert span[0] <= values.min()
            assert values.max() <= span[1]
            assert values.mean() == pytest.approx(np.mean(span), rel=0.05)
        else:
            assert values.std() == pytest.approx(span, rel=0.15)
            assert abs(values.mean()) < 0.15 * span


def test_the_same_seed_draws_the_same_people_and_moves_their_hands_alike_in_every_version(run):
    np.testing.assert_allclose(run.people.speed[0], (0.55531759, 0.7448267), rtol=1e-7)
    np.testing.assert_allclose(run.people.habit[1], (0.17753335, -0.48585583), rtol=1e-7)
    moved = run.trials[run.trials["f1x"] != 0].iloc[0]  # agent 1's first wrench, with its tremor
    assert moved["time"] == pytest.approx(0.12)
    wrench = moved[["f1x", "f1y", "t1z"]].to_numpy(float)
    np.testing.assert_allclose(wrench, (-0.67167913, 6.35220434, 0.06632801), rtol=1e-6)


def test_who_is_told_plans_with_the_goal_and_who_is_not_with_the_start():
    config = BRIEF.environment
    people = People(place=0.0, reading=0.0, habit=0.0).draw(0, 3)
    told = np.array([(True, False), (True, True), (False, False)])
    core = Transport(num_worlds=3, config=config)
    core.reset(seed=0)
    start = core.transition
    assert start is not None
    pairs = Pairs(config, people, told)
    pairs.reset(start, core.generators)
    goal, angle = start.next_state.goal[:, None, 2], start.next_state.pose[:, None, 2]
    np.testing.assert_array_equal(pairs.goals[..., 2], np.where(told, goal, angle))
    np.testing.assert_array_equal(pairs.goals[:, 0, :2], start.next_state.goal[:, :2])


def test_goals_of_people_lie_in_memory_as_those_for_which_partners_are_compiled(monkeypatch):
    core = Transport(num_worlds=3, config=BRIEF.environment)
    core.reset(seed=0)
    start = core.transition
    assert start is not None
    laid = []

    def act(_, transition):
        laid.append(transition.next_state.goal.flags.c_contiguous)
        return np.zeros((3, 1, 3))

    pairs = Pairs(BRIEF.environment, People().draw(0, 3), np.ones((3, 2), dtype=np.bool_))
    pairs.reset(start, core.generators)
    monkeypatch.setattr(Person, "act", act)
    pairs.act(start)
    assert laid == [True, True]


def test_only_who_is_not_told_gives_in_to_unexpected_torque():
    config = BRIEF.environment
    core = Transport(num_worlds=1, config=config)
    core.reset(seed=0)
    start = core.transition
    assert start is not None
    pairs = Pairs(config, People().draw(0, 1), np.array([(True, False)]))
    pairs.reset(start, core.generators)
    before = pairs.goals.copy()
    action = np.zeros((1, 2, 3))
    action[0, 0, 2] = 0.5  # agent 1 turns it, agent 2 does nothing
    core.step(action)
    after = core.transition
    assert after is not None
    pairs.act(after)
    turn = pairs.goals[0, :, 2] - before[0, :, 2]
    assert turn[0] == 0
    assert turn[1] > 0


def test_rooms_are_the_same_with_each_guide_and_differ_between_pairs_and_trials(run):
    starts = run.trials.groupby(["pair", "trial", "condition"])[["x", "y", "theta"]].first()
    spread = starts.groupby(["pair", "trial"]).agg(np.ptp)
    assert (spread == 0).all(axis=None)
    assert len(starts.drop_duplicates()) == 6


def test_the_beam_arrives_turned_as_those_who_know_want_it(run):
    assert run.arrived.sum() >= 15  # of 18
    assert sorted(run.trials["condition"].unique()) == sorted(GUIDES)
    off = dict(zip(GUIDES, run.turned_wrong.mean(axis=0), strict=True))
    assert off["both"] < 0.3 < off["none"]
    assert off["one"] < off["none"]


def test_simulated_trials_say_who_is_first_as_recorded_ones_do(run):
    platform = Box(center=(2.4, 0.0), size=(2.2, 4.0))  # of the doorway task
    np.testing.assert_array_equal(run.trials["first"], first_to_enter(run.trials, platform))
    first = run.trials.groupby(["pair", "condition", "trial"])["first"].first()
    assert first.isin([1, 2]).mean() > 0.8
    counted = (first == 1).groupby(["pair", "condition"]).sum().unstack()[list(GUIDES)]
    np.testing.assert_array_equal(run.first, counted)


def test_a_pair_does_the_same_whoever_else_takes_part(run):
    fewer = simulate(DyadsConfig(pairs=2, trials=2, seconds=14.0, dt=0.04)).trials
    same = run.trials[run.trials["pair"] <= 2].reset_index(drop=True)
    numbers = [table.drop(columns="condition").to_numpy() for table in (fewer, same)]
    np.testing.assert_allclose(*numbers, atol=1e-8)  # NumPy rounds by place in the array


def test_the_command_simulates_and_its_trials_can_be_analysed_again(tmp_path, capsys, monkeypatch):
    pytest.importorskip("tyro")
    monkeypatch.setenv("COLUMNS", "160")
    options = ("--pairs", 3, "--trials", 4, "--seconds", 9, "--dt", 0.1, "--out", tmp_path)
    assert cli.main(["study", "dyads", *map(str, options)]) == 0
    printed = capsys.readouterr().out
    assert "simulated people beside the people" in printed
    assert "the trials of simulated people" in printed
    assert files_named(printed, tmp_path) == {path.name for path in tmp_path.iterdir()}
    again = quadrant_shares(read_trials([tmp_path / "trials.parquet"]))
    found = pd.read_csv(tmp_path / "quadrants.csv")
    pd.testing.assert_frame_equal(again, found, check_dtype=False)
    assert len(pd.read_csv(tmp_path / "people.csv")) == 6


@pytest.mark.parametrize(
    ("build", "said"),
    [
        (lambda: People(speed=(0.9, 0.5)), r"people\.speed must be \(low, high\)"),
        (lambda: People(habit=-1.0), r"people\.habit must be a number from 0"),
        (lambda: DyadsConfig(dt=0.07), r"dt must divide 0\.6 s"),
        (lambda: DyadsConfig(pairs=0), r"pairs must be"),
    ],
)
def test_what_makes_no_sense_is_refused(build, said):
    with pytest.raises(InvalidInput, match=said):
        build()
