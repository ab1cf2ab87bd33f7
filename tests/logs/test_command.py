"""coopenv decompose, as a user calls it."""

import ast
import inspect
import re
from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("pyarrow")
pytest.importorskip("matplotlib")

from coopenv import cli
from coopenv.logs import Layout
from coopenv.logs.command import Decompose
from coopenv.logs.layout import TABLES, UNITS
from tests.logs import cases, motions


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")


def run(*arguments) -> int:
    return cli.main([str(argument) for argument in arguments])


def test_it_prints_a_summary_and_leaves_table_and_picture(tmp_path, capsys):
    columns = cases.planar() | {"trial": np.repeat([1, 2], 20)}
    columns["Fx left"] = -columns.pop("f1x") / 1000
    columns |= {name: values / 1000 for name, values in columns.items() if name[0] == "f"}
    path = cases.save(columns, tmp_path / "trial.csv")
    options = ("--map", "f1x=-Fx left", "--force", "kN", "--grips", *cases.BEAM)
    assert run("decompose", path, *options) == 0
    printed = capsys.readouterr().out
    for word in ("40 rows, 2 trials, 0.380 s", "optimal by pair", "balance", "0 fallbacks",
                 "relative_cost", "wasted_cost [N]", "internal_force_level [N]", "energy_share_2",
                 "median", "undefined", "trial.decomposed.csv"):  # fmt: skip
        assert word in printed
    table = cases.load(tmp_path / "trial.decomposed.csv")
    np.testing.assert_allclose(table["f1x"], cases.planar()["f1x"])
    assert (tmp_path / "trial.decomposed.png").exists()


def test_on_a_terminal_a_bar_comes_to_its_end(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    path = cases.save(cases.planar(), tmp_path / "trial.csv")
    assert run("decompose", path, "--grips", *cases.BEAM, "--no-picture") == 0
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", capsys.readouterr().out)
    assert re.search(r"decomposing .* 100 %", plain)


def test_the_summary_fits_eighty_columns(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    columns = cases.planar()
    columns |= {name: 1.234e-6 * columns[name] for name in columns if name[0] in "ftv"}
    columns["time"] = cases.planar()["time"]
    path = cases.save(columns, tmp_path / "trial.csv")
    assert run("decompose", path, "--grips", *cases.BEAM, "--no-picture") == 0
    lines = capsys.readouterr().out.splitlines()
    heading = next(line for line in lines if "median" in line)
    assert heading.split() == ["mean", "median", "5", "%", "95", "%", "largest", "undefined"]
    assert not any("…" in line for line in lines)
    assert max(map(len, lines[:-1])) <= 80


def test_options_may_come_from_a_file(tmp_path, capsys):
    path = cases.save(cases.planar(), tmp_path / "trial.npz")
    (tmp_path / "lab.toml").write_text('force = "kN"\ngrips = [[-0.9, 0], [0.9, 0]]\n')
    options = ("--layout", tmp_path / "lab.toml", "--no-picture", "--method", "moore_penrose")
    assert run("decompose", path, *options, "--out", tmp_path / "out.csv") == 0
    assert "moore_penrose by closed_form" in capsys.readouterr().out
    table = cases.load(tmp_path / "out.csv")
    np.testing.assert_allclose(table["f2y"], 1000 * cases.planar()["f2y"])
    assert not (tmp_path / "out.png").exists()


@pytest.mark.parametrize(
    ("change", "options", "says"),
    [
        ({"f1x": "f1X"}, (), "did you mean 'f1X'"),
        ({}, ("--map", "f1x"), "map must be NAME=COLUMN"),
        ({}, ("--force", "kn"), "did you mean 'kN'"),
        ({}, ("--method", "optimum"), "did you mean 'optimal'"),
        ({}, ("--bad-rows", "ignore"), "bad_rows must be"),
        ({}, ("--mass", "5"), "body must have both mass and inertia or none of them, got one"),
        ({}, ("--mass", "0", "--inertia", "1"), "body.mass must be positive, got 0"),
        ({}, ("--mass", "5", "--inertia", "1", "2"), "body.inertia must be a number in the plane"),
        ({}, ("--out", "a.xlsx"), "file must end in one of"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(change, options, says, tmp_path, capsys):
    columns = {change.get(name, name): values for name, values in cases.planar().items()}
    path = cases.save(columns, tmp_path / "trial.csv")
    assert run("decompose", path, "--grips", *cases.BEAM, *options) == 1
    printed = capsys.readouterr().err
    assert says in printed
    assert printed.count("\n") == 1
    assert [each.name for each in tmp_path.iterdir()] == ["trial.csv"]


def test_a_known_body_may_be_said_by_options_which_win_over_a_layout(tmp_path, capsys):
    columns = motions.planar(0, noise=0)
    path = cases.save(columns, tmp_path / "trial.npz")
    options = ("--grips", *np.ravel(motions.BEAM), "--twist-frame", "world", "--check")
    (tmp_path / "lab.toml").write_text("[body]\nmass = 1.0\ninertia = 1.0\ndrag = [2.0, 0.3]\n")
    layout = ("--layout", tmp_path / "lab.toml")
    assert run("decompose", path, *options, *layout) == 0
    wrong = " ".join(capsys.readouterr().out.split())
    body = ("--mass", motions.MASS, "--inertia", motions.INERTIA)
    assert run("decompose", path, *options, *layout, *body) == 0
    right = " ".join(capsys.readouterr().out.split())
    assert run("decompose", path, *options, *body, "--drag", 2.0, 0.3) == 0
    assert " ".join(capsys.readouterr().out.split()) == right
    assert "fx: r² 1.000, gain 1.000" in right
    assert "fx: r² 1.000, gain 1.000" not in wrong


def test_an_inertia_in_space_is_three_numbers_or_nine(tmp_path, capsys):
    columns = motions.spatial(0, rate=50, noise=0)
    path = cases.save(columns, tmp_path / "trial.npz")
    told = []
    for inertia in ((0.3, 2.0, 2.2), (0.3, 0, 0, 0, 2.0, 0, 0, 0, 2.2)):
        options = ("--check", "--mass", motions.MASS, "--gravity", 0, 0, -9.81)
        assert run("decompose", path, *options, "--inertia", *inertia) == 0
        told.append(" ".join(capsys.readouterr().out.split()))
    assert told[0] == told[1]
    assert "tz: r² 1.000" in told[0]


@pytest.mark.parametrize("where", ["before", "after", "layout"])
def test_forces_only_is_a_flag(where, tmp_path):
    columns = {name: values for name, values in cases.planar().items() if not name.endswith("z")}
    path = cases.save(columns, tmp_path / "trial.npz")
    (tmp_path / "lab.toml").write_text("forces_only = true")
    words = {
        "before": ("--forces-only", path),
        "after": (path, "--forces-only"),
        "layout": (path, "--layout", tmp_path / "lab.toml"),
    }
    assert run("decompose", *words[where], "--grips", *cases.BEAM, "--no-picture") == 0
    assert not cases.load(tmp_path / "trial.decomposed.npz")["t1z"].any()


def test_bad_rows_are_told_of_when_they_are_passed_over(tmp_path, capsys):
    columns = cases.planar()
    columns["f1x"][3] = np.nan
    path = cases.save(columns, tmp_path / "trial.csv")
    assert run("decompose", path, "--grips", *cases.BEAM) == 1
    assert "trial.csv, line 5, column 'f1x' must be a finite number" in capsys.readouterr().err
    assert run("decompose", path, "--grips", *cases.BEAM, "--bad-rows", "skip", "--no-picture") == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "1 bad rows are NaN; the first:" in printed
    assert "line 5, column 'f1x'" in printed


def test_every_field_of_a_layout_is_an_option_and_names_its_units():
    body = ast.parse(inspect.getsource(Decompose)).body[0]
    assert isinstance(body, ast.ClassDef)
    said = {
        node.target.id: ast.literal_eval(text.value)
        for node, text in pairwise(body.body)
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
        if isinstance(text, ast.Expr)
    }
    assert {entry.name for entry in fields(Layout)} - set(TABLES) <= set(said)
    for quantity, known in UNITS.items():
        first, *others = known
        assert said[quantity].startswith(f"Unit: {', '.join([f'{first} (default)', *others])}.")
