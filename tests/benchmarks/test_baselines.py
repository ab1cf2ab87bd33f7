"""Baselines of every environment: the page shows all runs, with the settings of today."""

from dataclasses import replace

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("tyro")

from benchmarks.learning import baselines, tables
from benchmarks.learning.run import configured, is_of
from benchmarks.pages import filled
from tests.agents.training.cases import tiny

COMMON = {
    "env": "BeamLift",
    "control": "joint",
    "settings": {"steps": 5, "hidden": [8]},
    "steps": 5,
    "seconds": 1.5,
    "reached": (0.5, None),
    "success": 0.5,
    "sampled": 0.25,
    "time": None,
    "relative_cost": 0.125,
}


def test_the_pages_show_every_run_that_was_saved():
    runs = baselines.saved()
    shown = filled(baselines.PAGE, {"baselines": baselines.table(runs)})
    assert shown == baselines.PAGE.read_text(encoding="utf-8")
    beside = {"partners": tables.partners(runs), "hands": tables.hands(runs)}
    page = baselines.BESIDE_PAGE
    assert filled(page, beside) == page.read_text(encoding="utf-8")
    rows = sum(max(0, each.count("\n") - 1) for each in (baselines.table(runs), *beside.values()))
    assert rows == len(runs)


def test_a_table_has_a_row_a_run_and_without_runs_there_is_none():
    second, first = (baselines.Run(seed=seed, **COMMON) for seed in (1, 0))
    header, _, *rows = baselines.table([second, first]).splitlines()
    assert header.split(" | ")[2] == "seed"
    assert [line.split(" | ")[2] for line in rows] == ["0", "1"]
    assert baselines.table([]) == "None of these runs is finished yet."


def test_every_run_has_the_settings_that_the_command_has_today(tmp_path):
    assert len(list(baselines.planned(baselines.Baselines()))) == 2 * 5 * len(baselines.names())
    for run in baselines.saved():
        others = {"partner": run.partner, "action": run.action}
        config = configured(run.env, run.control, run.seed, tmp_path, **others)
        assert is_of(run, run.env, config), run


def test_a_run_beside_a_partner_is_of_that_partner_and_action(tmp_path):
    default = configured("WalkerTurn", "partner", 0, tmp_path, action="wrench")
    assert default.environment.partner == "walking"
    assert default.environment.action is None  # it is the environment's own
    assert default.out.name == "WalkerTurn_partner_walking_0"
    hands = configured("BeamLift", "joint", 3, tmp_path, action="motion")
    assert hands.out.name == "BeamLift_joint_motion_3"
    run = baselines.Run(seed=0, **{**COMMON, "env": "WalkerTurn", "control": "partner"})
    settings = baselines.settings_of(default)
    assert not is_of(replace(run, settings=settings), "WalkerTurn", default)
    assert is_of(replace(run, settings=settings, partner="walking"), "WalkerTurn", default)


def test_partners_that_feel_are_planned_beside_hands_alone():
    asked = baselines.Baselines(
        envs=("BeamLift",),
        controls=("partner",),
        partners=("leader", "guiding"),
        actions=("wrench", "motion"),
        seeds=(1,),
    )
    chosen = [config.environment for _, config in baselines.planned(asked)]
    assert [(each.action, each.partner) for each in chosen] == [
        (None, "leader"),
        ("motion", "leader"),
        ("motion", "guiding"),
    ]


def test_runs_beside_partners_and_by_hands_are_kept_apart_and_each_is_in_its_table(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(baselines, "FOLDER", tmp_path)
    plain = baselines.Run(seed=0, **COMMON)
    hands = replace(plain, action="motion")
    beside = replace(plain, control="partner", partner="robot", action="motion")
    for run in (plain, hands, beside):
        baselines.save(run)
    kept = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.json")}
    assert kept == {
        "BeamLift_joint.json",
        "partners/BeamLift_joint_motion.json",
        "partners/BeamLift_partner_robot_motion.json",
    }
    assert "partner" not in (tmp_path / "BeamLift_joint.json").read_text()
    runs = baselines.saved()
    assert sorted(runs, key=lambda run: run.name) == [plain, hands, beside]
    for made, cells in (
        (baselines.table(runs), "| BeamLift | joint | 0 |"),
        (tables.hands(runs), "| BeamLift | joint | 0 |"),
        (tables.partners(runs), "| BeamLift | motion | robot | 0 |"),
    ):
        assert len(made.splitlines()) == 3
        assert made.splitlines()[-1].startswith(cells)


def test_runs_come_back_as_they_were_saved_by_seed_and_the_newest_of_each(tmp_path, monkeypatch):
    monkeypatch.setattr(baselines, "FOLDER", tmp_path)
    last, first = (baselines.Run(seed=seed, **COMMON) for seed in (3, 1))
    again = baselines.Run(seed=3, **{**COMMON, "success": 1.0})
    for run in (last, first, again):
        baselines.save(run)
    assert baselines.saved() == [first, again]
    assert baselines.row(first)[-2:] == ("0", "–")  # [s] until 90 % and 98 %


def test_a_level_is_reached_when_the_curve_first_is_there():
    curve = [(float(at), {"steps": at, "success": s}) for at, s in enumerate((1.0, 0.9, 0.5, 1.0))]
    assert baselines.reached(curve, 0.9, 0) == 0.0
    assert baselines.reached(curve[:3], 0.98, 1) is None
    assert baselines.reached([(0.5, {"steps": 1})], 0.9, 0) is None  # no episode has ended


def test_episodes_that_ended_first_because_they_were_short_reach_nothing():
    curve = [(float(at), {"steps": at, "success": s}) for at, s in enumerate((1.0, 0.9, 0.5, 1.0))]
    assert baselines.reached(curve, 0.9, 1) == 1.0
    assert baselines.reached(curve, 0.98, 1) == 3.0


def test_a_run_is_trained_tested_saved_and_not_asked_for_again(tmp_path, monkeypatch):
    config = tiny(tmp_path / "run", seed=2)
    told = []
    monkeypatch.setattr(baselines, "FOLDER", tmp_path / "kept")
    monkeypatch.setattr(baselines, "EPISODES", 4)
    monkeypatch.setattr(baselines, "planned", lambda asked: [("BeamTransport", config)])
    (run,) = baselines.run_all(baselines.Baselines(), told.append)
    assert (run.steps, run.seed, run.success, run.reached) == (128, 2, 0.0, (None, None))
    assert run.seconds > 0
    assert baselines.run_all(baselines.Baselines(), told.append) == [run]
    assert len(told) == 1
    other = replace(config, epochs=2, fresh=True)  # trained anew, in the place of the first
    monkeypatch.setattr(baselines, "planned", lambda asked: [("BeamTransport", other)])
    (again,) = baselines.run_all(baselines.Baselines(), told.append)
    assert again.settings["epochs"] == 2
    monkeypatch.setattr(baselines, "planned", lambda asked: [("BeamTransport", config)])
    assert baselines.run_all(baselines.Baselines(minutes=0.0), told.append) == [again]
    assert told[-1] == "the budget is spent; the same command goes on"
