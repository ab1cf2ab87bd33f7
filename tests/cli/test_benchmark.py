"""``coopenv benchmark`` on the command line."""

import json

import pytest

pytest.importorskip("tyro")

from coopenv import cli
from coopenv.agents import benchmark
from coopenv.agents.benchmark import read_summary
from tests.agents.benchmark.cases import SMALL

HERE = "tests.agents.benchmark.cases:"


@pytest.fixture(autouse=True)
def _small(monkeypatch):
    """One small suite."""
    monkeypatch.setenv("COLUMNS", "200")
    monkeypatch.setattr(benchmark, "find_suites", lambda names: (SMALL,))


def test_entries_run_once_and_stand_in_a_table(tmp_path, capsys):
    command = ["benchmark", "nobody", f"{HERE}sighted", f"--out={tmp_path}", "--only", "alone"]
    assert cli.main(command) == 0
    printed = capsys.readouterr().out
    assert "team-7: a small one" in printed
    assert "2 of 2 cells" in printed
    files = sorted(tmp_path.glob("team-7/*.json"))
    assert [path.stem for path in files] == ["nobody", "sighted"]
    summary = read_summary(files[1])
    assert (summary.given, summary.sees) == (f"{HERE}sighted", "observation")
    before = {path: path.stat().st_mtime_ns for path in files}
    assert cli.main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {path: path.stat().st_mtime_ns for path in files} == before
    assert [one["entry"] for one in found["summaries"]] == ["nobody", "sighted"]
    assert set(found) == {"summaries", "left_out", "files"}


def test_a_dry_run_tries_everything_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["benchmark", f"{HERE}team_only", "--dry-run", "--json"]) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert found["cells"] == [{"entry": "team_only", "suite": "team-7", "scenario": "alone"}]
    assert found["episodes"] == 4
    assert "left out: team_only in team: beside: config must have no partner" in printed.err
    assert not list(tmp_path.iterdir())


def test_what_is_not_told_of_a_training_or_beyond_the_budget_is_said_and_not_refused(
    tmp_path, capsys
):
    command = ["benchmark", f"{HERE}sighted", "--only", "alone", f"--out={tmp_path}"]
    for told, says in (
        ([], "sighted in team-7: trained not told, of 2,000,000 control steps, is marked so"),
        (["--trained=1000001", "--seeds=2"], "trained 1,000,001 × 2, of 2,000,000 control steps"),
    ):
        for dry in (["--dry-run"], []):
            assert cli.main([*command, *told, *dry]) == 0
            assert says in capsys.readouterr().out
    assert cli.main([*command, "--trained=1000000", "--seeds=2"]) == 0
    assert "of 2,000,000" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ([], "entries must name at least one, got none"),
        (["random", "nobody", "--name=it"], "name must be of a single entry, got 'it' for 2"),
        (["random", "nobody", "--trained=5"], "trained must be of a single entry, got 5 for 2"),
        ([f"{HERE}sighted", "--seeds=2"], "trained must be told beside seeds"),
        (["random", "--only", "alnoe"], "did you mean 'alone'"),
        (["nobody", f"{HERE}short"], "short must act in the scenario 'alone'"),
        (["scripted:nonesuch"], "nonesuch"),
    ],
)
def test_mistakes_end_the_command_before_anything_is_written(given, says, tmp_path, capsys):
    out = tmp_path / "out"
    assert cli.main(["benchmark", *given, f"--out={out}"]) == 1
    said = capsys.readouterr().err
    assert says in said
    assert not out.exists()


def test_an_interruption_says_how_to_go_on(tmp_path, monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(benchmark, "conduct", interrupted)
    assert cli.main(["benchmark", "nobody", f"--out={tmp_path}"]) == 130
    assert "the same command goes on" in capsys.readouterr().err
