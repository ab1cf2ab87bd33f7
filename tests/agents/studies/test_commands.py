"""``coopenv study``, as a user calls it."""

import sys

import pytest

pytest.importorskip("tyro")
pytest.importorskip("statsmodels")

from coopenv import cli
from tests.agents.studies.dyads.cases import make_trials, varied
from tests.agents.studies.printed import files_named


def run(*arguments) -> int:
    return cli.main([str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")


def test_beam_prints_its_claims_and_leaves_its_files(tmp_path, capsys):
    options = ("--duration", 1, "--dt", 0.02, "--inertias", 1, "--out", tmp_path)
    assert run("study", "beam", *options) == 0
    printed = capsys.readouterr().out
    for words in ("ours: F_I = 0 throughout", "holds", "19 of 21 hold", "claims.md"):
        assert words in printed
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "claims.md",
        "claims.csv",
        "motion.png",
        "disagreement.png",
        "series.csv",
        "series.npz",
    }
    assert files_named(printed, tmp_path) == names
    for name in ("motion.png", "disagreement.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "claims.md").read_text().splitlines()) == 2 + 21


def test_dyads_analyses_files_whatever_says_who_was_first(tmp_path, capsys):
    table = make_trials(pairs=3, trials=2, disagreement=varied, spin=0.0)
    table.to_csv(tmp_path / "told.csv", index=False)
    # at θ = 3 rad grip 1 leads along x
    table.drop(columns="first").to_parquet(tmp_path / "untold.parquet")
    assert run("study", "dyads", tmp_path / "untold.parquet") == 1
    assert "platform" in capsys.readouterr().err
    for file, options in (
        ("told.csv", ()),
        ("untold.parquet", ("--platform", "2.6", "0", "2", "6")),
    ):
        out = tmp_path / file.split(".")[0]
        assert run("study", "dyads", tmp_path / file, *options, "--out", out) == 0
        printed = capsys.readouterr().out
        assert "beside the people" in printed
        assert files_named(printed, out) == {path.name for path in out.iterdir()}
    told, untold = (
        (tmp_path / name / "internal_torque.csv").read_text() for name in ("told", "untold")
    )
    assert told == untold


def test_a_bad_file_is_explained_in_one_line(tmp_path, capsys):
    (tmp_path / "bad.csv").write_text("time\n0\n")
    assert run("study", "dyads", tmp_path / "bad.csv", "--out", tmp_path / "out") == 1
    printed = capsys.readouterr().err
    assert "bad.csv" in printed
    assert "f1x" in printed
    assert printed.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_missing_extra_is_named(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "statsmodels", None)
    assert run("study", "beam") == 1
    assert "pip install 'coopenv[analysis]'" in capsys.readouterr().err
