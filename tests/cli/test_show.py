"""coopenv show, as a user calls it."""

import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("matplotlib")

from coopenv import cli, wrench
from coopenv.wrench import plot
from tests.logs import cases

FIGHT = ("--grips", -0.9, 0, 0.9, 0, "--applied", 3, 0, 0, -1, 0, 0)


def run(*arguments) -> int:
    return cli.main([str(argument) for argument in arguments])


@pytest.fixture(autouse=True)
def _here(monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def trial(tmp_path):
    columns = cases.planar(rows=5)
    columns["f1x"][3] = float("nan")
    for name, value in zip(("f1x", "f1y", "t1z", "f2x", "f2y", "t2z"), (3, 0, 0, -1, 0, 0),
                           strict=True):  # fmt: skip
        columns[name][1] = value
    return cases.save(columns, tmp_path / "trial.csv")


def test_it_prints_the_split_and_leaves_a_picture(tmp_path, capsys):
    assert run("show", *FIGHT) == 0
    printed = capsys.readouterr().out
    rows = [line.split() for line in printed.splitlines()]
    assert ["1", "applied", "3", "0", "0"] in rows
    assert ["manipulation", "2", "0", "0"] in rows
    assert ["internal", "-1", "0", "0"] in rows
    assert "γ = 0.5, F_I = 1 N" in printed
    assert "J(h) = 2 N, J(h_M) = 1 N" in printed
    assert "load share: force 1/0, torque undefined/undefined" in printed
    assert "plausible and balanced" in printed
    assert (tmp_path / "split.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("suffix", "begins"), [("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_the_suffix_says_the_format(tmp_path, suffix, begins):
    out = tmp_path / f"made/wrench.{suffix}"
    assert run("show", *FIGHT, "--no-regions", "--out", out) == 0
    assert out.read_bytes().startswith(begins)
    assert [path.name for path in out.parent.iterdir()] == [out.name]


def test_a_row_of_a_recording_is_found_by_number_and_by_time(trial, capsys):
    grips = ("--grips", *cases.BEAM)
    for option in (("--row", 2), ("--at", 0.0138)):
        assert run("show", trial, *option, *grips) == 0
        printed = capsys.readouterr().out
        assert "row 2, optimal: γ = 0.5, F_I = 1 N" in printed
    assert trial.with_name("trial.row2.png").exists()


def test_no_number_is_cut_however_narrow_the_terminal(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "60")
    grips = ("--grips", -0.9, 0, 0, 0.9, 0, 0)
    applied = (-31234.567, -1.2345e-4, 0.3333, -22222.22, 33333.3, -1234.56, 0, -2.34567e10)
    assert run("show", *grips, "--applied", *applied, 0, 0, 0, 0, "--no-regions") == 0
    printed = capsys.readouterr().out
    assert "…" not in printed
    assert "-2.346e+10" in printed


def test_a_split_that_is_not_plausible_is_called_so(capsys):
    assert run("show", *FIGHT, "--internal", 2, 0, 0, -2, 0, 0) == 0
    printed = capsys.readouterr().out
    assert "own split" in printed
    assert "NOT plausible" in printed
    assert "1.0e+00 N" in printed


def test_the_picture_is_of_the_method_that_was_asked_for(monkeypatch):
    drawn = []

    def seen(*given, **said):
        drawn.append(said)
        return plot(*given, **said)

    monkeypatch.setattr(wrench, "plot", seen)
    assert run("show", *FIGHT, "--method", "net_force", "--no-regions") == 0
    (said,) = drawn
    expected = wrench.decompose(
        np.reshape(FIGHT[6:], (2, 3)), [[-0.9, 0], [0.9, 0]], method="net_force"
    )
    np.testing.assert_array_equal(said["decomposition"].internal, expected.internal)
    assert "internal" not in said


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "applied and grips must both be given, or a file with a row"),
        (("--grips", 0, 0, "--applied", 1, 2), "grips and applied must have 2 and 3 numbers"),
        ((*FIGHT, "--out", "wrench.gif"), "out must end in one of .png, .svg, .pdf"),
        ((*FIGHT, "--row", 1), "row must come with a file"),
        ((*FIGHT, "--internal", 1), "internal must be 6 numbers, got 1"),
        (
            (*FIGHT, "--internal", 1, 0, 0, -1, 0, 0, "--method", "net_force"),
            "only one of internal and method must be given",
        ),
        ((*FIGHT, "--torque-weight", 1), "torque_weight must be in ]0, 1["),
        ((*FIGHT, "--method", "optmal"), "did you mean 'optimal'?"),
    ],
)
def test_what_makes_no_sense_is_one_line_and_leaves_nothing(arguments, message, tmp_path, capsys):
    assert run("show", *arguments) == 1
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((), "one of row and at must be given"),
        (("--row", 6), "row must be at most 5, got 6"),
        (("--row", 0), "row must be a whole number of at least 1"),
        (("--row", 4), "row must be one that can be used, got 4"),
        (("--row", 1, "--applied", 1, 2, 3), "applied must be left out beside a file"),
        (("--at", 99), "at must be from 0 to 0.04 s, the first and the last good row"),
        (("--at", -0.001), "got -0.001; times are in seconds"),
    ],
)
def test_rows_that_are_not_there_are_refused(options, message, trial, capsys):
    assert run("show", trial, "--grips", *cases.BEAM, *options) == 1
    assert message in capsys.readouterr().err
