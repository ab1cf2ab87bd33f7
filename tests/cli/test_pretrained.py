"""``coopenv evaluate pretrained``, ``coopenv export``, and replay of what they name."""

import csv
from pathlib import Path

import pytest

pytest.importorskip("tyro")

from coopenv import cli
from coopenv.agents import pretrained
from coopenv.agents.trained import PlainPolicy, read_notes
from tests.agents.trained.cases import plain

JOINT = "pretrained:BeamTransport/joint"


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")


def test_all_are_evaluated_in_their_own_environments_and_against_their_rows(tmp_path, capsys):
    pytest.importorskip("rich")
    out = tmp_path / "table.csv"
    assert cli.main(["evaluate", "pretrained", "--episodes=10", f"--out={out}"]) == 0
    with out.open(newline="") as file:
        assert [row["policy"] for row in csv.DictReader(file)] == list(pretrained.names())
    said = capsys.readouterr().out
    count = len(pretrained.names())
    assert f"{count} of {count} succeed as their files say" in said
    for name in pretrained.names():
        assert f"coopenv/{name.split('/')[0]}-v0" in said


def test_a_named_one_stands_beside_others_and_elsewhere_is_held_to_no_row(capsys):
    pytest.importorskip("rich")
    assert cli.main(["evaluate", JOINT, "random", "--episodes=2"]) == 0
    assert "1 of 1 succeed" in capsys.readouterr().out
    assert cli.main(["evaluate", JOINT, "--episodes=2", "--body", "mass=9"]) == 0
    said = capsys.readouterr().out
    assert "BeamTransport/joint" in said
    assert "succeed as" not in said


def test_the_same_one_twice_and_a_name_that_is_none_are_refused(capsys):
    assert cli.main(["evaluate", "pretrained", JOINT]) == 1
    assert "policies must be named once each" in capsys.readouterr().err
    assert cli.main(["evaluate", "pretrained:Beam"]) == 1
    assert "pretrained policy must be one of the known names, got 'Beam'" in capsys.readouterr().err


def test_an_environment_of_another_task_is_refused(capsys):
    assert cli.main(["evaluate", JOINT, "--env", "coopenv/WalkerTurn-v0", "--episodes=1"]) == 1
    assert "task must be the TransportTask" in capsys.readouterr().err


def test_export_writes_a_policy_that_evaluate_takes(tmp_path, capsys):
    sb3 = pytest.importorskip("coopenv.agents.sb3")
    zipped, out = tmp_path / "policy.zip", tmp_path / "carry.npz"
    sb3.SB3Policy.load(pretrained.file_of(JOINT)).save(zipped)
    assert cli.main(["export", str(zipped)]) == 0
    assert (tmp_path / "policy.npz").is_file()
    assert cli.main(["export", str(zipped), "--out", str(out)]) == 0
    assert f"wrote {out}: " in capsys.readouterr().out
    assert cli.main(["export", str(out)]) == 1
    assert "out must be another file" in capsys.readouterr().err
    assert read_notes(out)["provenance"] == read_notes(pretrained.file_of(JOINT))["provenance"]
    assert cli.main(["evaluate", str(out), "--episodes=2"]) == 0
    assert "carry.npz" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (["nowhere.zip", "--out", "a.npz"], "policy must be the file of a trained policy"),
        ([JOINT, "--out", "a.zip"], "out must be another file that ends in .npz, got 'a.zip'"),
    ],
)
def test_export_refuses_in_one_line(arguments, match, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["export", *arguments]) == 1
    said = capsys.readouterr().err
    assert match in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_replay_films_one_by_name_and_by_file(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pygame")
    pytest.importorskip("rich")
    monkeypatch.chdir(tmp_path)
    PlainPolicy(plain()).save(tmp_path / "policy.npz")
    for what, steps in ((JOINT, ""), ("policy.npz", "6 steps")):
        assert cli.main(["replay", what, "--fps=1", "--width=160", "--out=film.gif"]) == 0
        said = capsys.readouterr().out
        assert f"{what} in coopenv/BeamTransport-v0" in said
        assert steps in said
        assert Path("film.gif").stat().st_size > 100
