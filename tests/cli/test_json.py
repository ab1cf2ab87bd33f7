"""``--json``: one document on standard output and nothing else, its keys as documented."""

import json
import re
from dataclasses import fields
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv import cli
from coopenv.agents.controllers import RandomPolicy
from coopenv.options import Common
from coopenv.warming import Warmed
from tests.agents.experiments.cases import TEXT, here, no_pictures
from tests.agents.studies.dyads.cases import make_trials, varied
from tests.cli.commands import LEAST
from tests.logs import cases

PAGE = Path(__file__).parents[2] / "docs" / "commands.md"
GRIPS = ["--grips", *map(str, cases.BEAM)]


def refused(constant: str):
    raise AssertionError(f"{constant} is no JSON")


def asked(arguments: list[str], capsys, told: str) -> dict:
    """The document; ``told`` stands in what people read."""
    assert cli.main([*arguments, "--json"]) == 0
    printed = capsys.readouterr()
    assert told in printed.err
    assert told not in printed.out
    found = json.loads(printed.out, parse_constant=refused)
    assert set(found) == documented(" ".join(each for each in arguments if is_name(each)))
    return found


def is_name(word: str) -> bool:
    return word in cli.COMMANDS or word in ("--dry-run", "--check", "dyads")


def documented(name: str) -> set[str]:
    """Keys of a command's document, by the page of commands."""
    page = PAGE.read_text(encoding="utf-8")
    (keys,) = re.findall(rf"^\| `{re.escape(name)}` \| (.*) \|$", page, flags=re.MULTILINE)
    return set(re.findall(r"`(\w+)`", keys.partition(";")[0]))


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")


@pytest.fixture
def trial(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return str(cases.save(cases.planar(), tmp_path / "trial.csv"))


def test_every_command_but_that_of_shells_has_it():
    for name, kind in cli.COMMANDS.items():
        names = {entry.name for entry in fields(cast(Any, kind))}
        assert names & {"common", "study"} or name == "completion"
    assert not Common().json


def test_an_evaluation_has_every_number_in_full_and_null_for_nan(tmp_path, capsys):
    table = tmp_path / "table.json"
    line = ["evaluate", "random", "--episodes=2", "--horizon=3", f"--out={table}"]
    found = asked(line, capsys, "2 episodes")
    (row,) = found["policies"]
    assert [row] == json.loads(table.read_text())
    assert row["success_time"] is None
    assert len(str(row["relative_cost"])) > 8
    assert found["environments"] == {"random": "coopenv/BeamTransport-v0 with horizon 3"}
    assert found["files"] == [str(table)]


def test_a_training_says_what_its_table_says(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        "coopenv.agents.train.train", lambda config, environment, **_: RandomPolicy(environment)
    )
    line = ["train", "--episodes=2", "--horizon=3", "--no-gif", f"--out={tmp_path}"]
    found = asked(line, capsys, "policy.zip, config.json")
    assert found["policies"] == json.loads((tmp_path / "table.json").read_text())
    assert found["folder"] == str(tmp_path)


def test_a_shown_split_is_the_split(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    found = asked(["show", *LEAST["show"]], capsys, "wrote split.png")
    applied = np.array(found["manipulation"]) + np.array(found["internal"])
    assert np.allclose(applied, [[3, 0, 0], [-1, 0, 0]], atol=1e-12)
    assert found["internal"][0] == pytest.approx([1, 0, 0])
    assert found["plausible"] is True
    assert found["torque_load_share"] == [None, None]
    assert found["picture"] == "split.png"


def test_a_decomposition_says_what_its_summary_says(trial, capsys):
    found = asked(["decompose", trial, *GRIPS, "--no-picture"], capsys, "40 rows")
    assert found == json.loads(Path("trial.decomposed.summary.json").read_text("utf-8"))
    assert found["rows"] == 40
    checked = asked(["decompose", trial, *GRIPS, "--check"], capsys, "40 rows")
    assert checked["rows"] == 40


def test_an_inspection_says_what_each_column_could_be(trial, capsys):
    found = asked(["inspect", trial], capsys, "could be f1x")
    (file,) = found["files"]
    could = {each["name"]: each["could_be"] for each in file["columns"]}
    assert could["f1x"]["name"] == "f1x"
    assert file["clock"]["column"] == "time"


def test_a_film_says_what_it_shows(trial, capsys):
    pytest.importorskip("pygame")
    found = asked(["replay", "random", "--horizon=2", "--width=160"], capsys, "wrote replay.gif")
    assert found["shown"]["episodes"] == [
        {"episode": 1, "success": False, "seconds": pytest.approx(0.1), "steps": 2}
    ]
    assert cli.main(["replay", trial, *GRIPS, "--end=0.05", "--width=160", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["shown"]["trial"], found["shown"]["rows"]) == (1, 6)


def test_a_study_says_which_claims_hold(tmp_path, capsys):
    found = asked(["study", "snapshots", "--samples=100", f"--out={tmp_path}"], capsys, "hold\n")
    assert found["study"] == "snapshots"
    for claim in found["claims"]:
        assert set(claim) == {
            "text",
            "source",
            "measured",
            "relation",
            "bound",
            "unit",
            "why",
            "holds",
        }


def test_a_study_of_dyads_has_the_numbers_of_its_tables(tmp_path, capsys):
    trials = make_trials(pairs=3, trials=2, disagreement=varied, spin=0.0)
    trials.to_csv(tmp_path / "told.csv", index=False)
    line = ["study", "dyads", str(tmp_path / "told.csv"), f"--out={tmp_path / 'out'}"]
    found = asked(line, capsys, "beside the people")
    assert (found["num_pairs"], len(found["claims"])) == (3, 7)
    assert {row["pair"] for row in found["internal_torque"]} == {1, 2, 3} or found["notes"]
    effects = {tuple(effect["factors"]): effect for effect in found["torque_effects"]}
    assert 0 <= effects["condition",]["p"] <= 1
    assert len(str(effects["condition",]["f"])) > 8


@pytest.mark.parametrize("command", ["experiment tiny.toml", "sweep wasted_cost 0 1"])
def test_a_dry_run_says_what_it_comes_to(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("tiny.toml").write_text(TEXT)
    found = asked([*command.split(), "--dry-run"], capsys, "nothing was run")
    assert found["cells"] == 10
    assert isinstance(found["steps"], int)


def test_an_experiment_and_its_report_say_the_same(tmp_path, monkeypatch, capsys):
    from coopenv.agents.experiments import run

    monkeypatch.setattr(run.Processes, "__call__", lambda self, *given: here(*given))
    monkeypatch.chdir(tmp_path)
    Path("tiny.toml").write_text(TEXT)
    with no_pictures():
        found = asked(["experiment", "tiny.toml", "--workers=1", "--out=out"], capsys, "10 of 10")
        again = asked(["report", "out"], capsys, "interquartile mean")
    assert found == again
    assert sum(setting["runs"] for setting in found["settings"]) == 10
    success = found["settings"][0]["measures"]["success_rate"]
    assert success["low"] <= success["value"] <= success["high"]


def test_a_bench_has_a_rate_for_each_batch(monkeypatch, capsys):
    monkeypatch.setattr("coopenv.bench.SPLITS", (("a pair in the plane", 1),))
    monkeypatch.setattr("coopenv.bench.command.CALLS", 20)
    line = ["bench", "--num-worlds", "1", "3", "--threads", "1", "--seconds=0.01", "--horizon=9"]
    found = asked(line, capsys, "a world and step")
    assert found["environment"] == "coopenv/BeamTransport-v0 with horizon 9"
    assert [(rate["worlds"], rate["threads"]) for rate in found["steps"]] == [(1, 1), (3, 1)]
    for rate in found["steps"]:
        assert rate["steps_per_second"] * rate["microseconds"] == pytest.approx(1e6)
    (split,) = found["decompositions"]
    assert split["samples_per_second"] * split["microseconds"] == pytest.approx(1e6)
    for call in found["calls"]:
        assert 0 < call["median"] <= call["rare"] <= call["worst"]


def test_warming_up_says_how_long_it_took(monkeypatch, capsys):
    monkeypatch.setattr("coopenv.warming.warmup", lambda report: Warmed(3, 1.25, None))
    found = asked(["warmup"], capsys, "3 functions compiled")
    assert found == {"kernels": 3, "seconds": 1.25, "cache": None}


def test_what_is_refused_prints_no_document(capsys):
    assert cli.main(["evaluate", "random", "--reward", "harmonie", "--json"]) == 1
    printed = capsys.readouterr()
    assert not printed.out
    assert "harmony" in printed.err


def test_versions_are_a_document_too(capsys):
    assert cli.main(["--version", "--json"]) == 0
    assert {"coopenv", "python", "numpy"} <= set(json.loads(capsys.readouterr().out))


def test_an_export_says_what_it_wrote(tmp_path, capsys):
    out = tmp_path / "carry.npz"
    found = asked(["export", "pretrained:BeamTransport/joint", f"--out={out}"], capsys, "wrote")
    assert Path(found["written"]) == out
    assert found["bytes"] == out.stat().st_size
