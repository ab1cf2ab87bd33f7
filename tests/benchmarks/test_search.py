"""The search for PPO's settings: every trial is on its page, and none on seeds of another table."""

import json

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning import search, speed
from benchmarks.learning.stages import SEEDS
from benchmarks.pages import cells
from coopenv.agents.seeds import STOPPING


def test_the_page_shows_every_trial_that_was_saved():
    trials = search.saved()
    assert search.PAGE.read_text(encoding="utf-8").count(search.table(trials)) == 1
    shown = cells(search.PAGE, "search")[1:]
    assert sum(len(row[2].split(", ")) for row in shown) == len(trials)


def test_every_trial_is_one_that_the_command_would_run():
    planned = [(json.dumps(settings), seed) for _, settings, seed in search.planned()]
    assert len(set(planned)) == len(planned)
    for trial in search.saved():
        assert (json.dumps(trial.settings), trial.seed) in planned


def test_trials_come_back_as_they_were_saved(tmp_path, monkeypatch):
    trials = search.saved()
    monkeypatch.setattr(search, "FILE", tmp_path / "search.json")
    assert search.saved() == []
    search.save(trials)
    assert [repr(one) for one in search.saved()] == [repr(one) for one in trials]  # NaN is not NaN


def test_what_is_timed_was_not_searched_on():
    assert not set(SEEDS) & set(speed.Speed().seeds)
    assert search.EVALUATION not in (0, STOPPING)


def test_rows_that_were_not_timed_stay_on_the_page():
    before = cells(speed.PAGE, "speed")[1:]
    made = [["to its end", "0", *["x"] * (len(speed.COLUMNS) - 2)]]
    after = speed.with_others(made)
    assert [row for row in after if row not in made] == [
        row for row in before if row[:2] != ["to its end", "0"]
    ]
    assert [row for row in after if row in made] == made
