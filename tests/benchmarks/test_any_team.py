"""Policies for teams of any size: what is run, what is kept, and the page."""

import json

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning import teams
from benchmarks.pages import filled

FIGURES = {"success": 0.9, "sampled": 0.8, "time": 2.0, "relative_cost": 0.1, "load_imbalance": 0.2}


def a_run(training: str, seed: int, **changes) -> teams.Run:
    seen = {f"{size}": {**FIGURES, **changes} for size in teams.SIZES}
    return teams.Run(
        training=training, seed=seed, settings={}, observe=(), seconds=1.0, seen=seen
    )  # fmt: skip


def test_the_page_has_the_tables_of_what_is_saved():
    runs = teams.saved()
    tables = {"teams": teams.summary(runs), "teams-runs": teams.single(runs)}
    assert filled(teams.PAGE, tables) == teams.PAGE.read_text(encoding="utf-8")


def test_every_saved_run_is_one_of_those_that_are_planned_today(tmp_path):
    planned = [*teams.planned(teams.Teams(out=tmp_path))]
    assert len(planned) == 5 * len(teams.TRAININGS)
    for run in teams.saved():
        assert any(teams.is_of(run, name, config) for name, config in planned), run


def test_a_plain_training_differs_in_the_blocks_about_the_team_alone(tmp_path):
    whole, plain = (teams.configured(name, 0, tmp_path) for name in ("2_6", "2_6_plain"))
    seen, less = (each.environment.config().observe for each in (whole, plain))
    assert set(seen) - set(less) == {"others_wrench", "place"}
    assert teams.settings_of(whole) == teams.settings_of(plain)


def test_the_table_has_means_over_seeds_and_the_worst_of_them():
    runs = [a_run("2_4", 0), a_run("2_4", 1, success=1.0)]
    row = teams.summary(runs).splitlines()[3]
    assert row.startswith("| 2 and 4 | 2 | 3 | never seen | 95.0% | 90.0% | 80.0% | 2.00 | 0.100 |")
    assert teams.summary([]) == teams.single([]) == teams.NONE


def test_a_run_is_kept_in_a_file_of_its_own(monkeypatch, tmp_path):
    monkeypatch.setattr(teams, "FOLDER", tmp_path)
    teams.save(a_run("3", 1))
    assert json.loads((tmp_path / "3_1.json").read_text())["seed"] == 1
    assert [run.seed for run in teams.saved()] == [1]
