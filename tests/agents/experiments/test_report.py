"""Reports: what the page says of runs whose numbers are known, its pictures and its table."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.experiments import Results, write_report
from coopenv.agents.experiments.cell import Cell
from coopenv.agents.experiments.report import pictures
from coopenv.agents.experiments.report.measures import MEASURES
from coopenv.agents.experiments.report.page import Estimate
from coopenv.agents.experiments.report.results import Run
from coopenv.agents.experiments.sweep import sweep
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.experiments.cases import no_pictures

nan = float("nan")
SUCCESS = {  # setting -> problem -> of each seed
    "plain": {"open": [0.5, 0.75, 0.5, 0.25], "door": [0.0, 0.25, 0.25, 0.0]},
    "gentle": {"open": [1.0, 1.0, 0.75, 1.0], "door": [0.5, 0.5, 0.75, 0.5]},
    "lost": {"open": [0.0] * 4, "door": [0.0] * 4},
}
TIME = {"plain": 4.0, "gentle": 5.0, "lost": nan}
WASTE = {"plain": 3.0, "gentle": 1.0, "lost": 0.5}


def run(task: str, reward: str, seed: int) -> Run:
    success = SUCCESS[reward][task][seed]
    numbers = {name: 0.1 for name in MEASURES} | {"episodes": 8.0}
    numbers |= {"success_rate": success, "wasted_cost": WASTE[reward]}
    numbers["success_time"] = TIME[reward] + 0.1 * seed if success else nan
    curves = [
        {"steps": 100.0 * k, "success": success * k / 4, "wasted_cost": WASTE[reward] / k}
        for k in range(1, 5)
    ]
    return Run(
        levels={"task": task, "reward": reward},
        seed=seed,
        numbers=numbers,
        curves=curves,
        versions={"numpy": "2"},
        revision="abc",
    )


@pytest.fixture(scope="module")
def results():
    runs = [run(t, r, seed) for t in ("open", "door") for r in SUCCESS for seed in range(4)]
    return Results(
        name="known numbers",
        axes={"task": ["open", "door"], "reward": [*SUCCESS]},
        problems=("task", "body"),
        runs=runs,
        waiting=["cells/a", "cells/b"],
        failed={"cells/a": "it broke"},
        settings_found={"ppo": {"epochs": 3}},
    )


@pytest.fixture(scope="module")
def written(results, tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    return out, write_report(results, out)


def row(page: str, heading: str, name: str) -> list[str]:
    part = page.partition(f"## {heading}")[2].partition("\n## ")[0]
    (line,) = re.findall(rf"^\| {name} \|.*$", part, flags=re.MULTILINE)
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_the_page_has_the_interquartile_means_over_problems(written):
    page = (written[0] / "report" / "report.md").read_text()
    plain = row(page, "Settings", "plain")
    assert plain[1:3] == ["8", "2"]
    assert plain[3].startswith("0.312 [")  # of 0 0 | .25 .25 .25 .5 | .5 .75, by hand
    assert plain[-1] == "0.688"  # 1 - 2.5 / 8
    assert row(page, "Settings", "gentle")[3].startswith("0.75 [")  # .5 .5 | .5 .75 .75 1 | 1 1
    assert row(page, "Settings", "lost")[4] == "–"


def test_the_page_says_of_how_many_runs_a_time_is(written):
    page = (written[0] / "report" / "report.md").read_text()
    assert row(page, "Settings", "plain")[4].endswith("(6 runs)")


def test_the_page_compares_with_the_first_setting_on_the_same_problems(written):
    page = (written[0] / "report" / "report.md").read_text()
    gentle = row(page, "Probability of improvement on plain", "gentle")
    assert gentle[1].startswith("0.984 [")  # one tie in one of two times 16 pairs
    assert gentle[3] == "1 [1, 1]"
    assert gentle[2] == "0 [0, 0]"
    lost = row(page, "Probability of improvement on plain", "lost")
    assert lost[2] == "–"


def test_the_front_has_who_is_beaten_by_nobody_in_time_and_disagreement(written):
    page = (written[0] / "report" / "report.md").read_text()
    assert row(page, "Pareto front", "plain")
    assert row(page, "Pareto front", "gentle")
    assert "lost" not in page.partition("## Pareto front")[2].partition("![")[0]


def test_the_page_says_what_failed_what_was_found_and_with_what_it_was_made(written):
    page = (written[0] / "report" / "report.md").read_text()
    for said in (
        "# known numbers",
        "24 of 26 cells are finished",
        "- failed: `cells/a`: it broke",
        "- 1 have not run to their end",
        "settings of ppo, found by the search: epochs = 3",
        "- versions: numpy 2\n",
        "- revision: abc\n",
    ):
        assert said in page


def test_the_page_marks_cells_of_other_code(results, tmp_path):
    runs = [replace(results.runs[0], revision="def"), *results.runs[1:]]
    with no_pictures():
        write_report(replace(results, runs=runs), tmp_path)
    page = (tmp_path / "report" / "report.md").read_text()
    assert "- revision: def; abc, **not the same in all cells**" in page


def test_the_table_holds_every_run(written, results):
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    table = pandas.read_parquet(written[0] / "report" / "runs.parquet")
    assert len(table) == 24
    found = table[(table.task == "door") & (table.reward == "gentle")]
    assert found.sort_values("seed").success_rate.tolist() == [0.5, 0.5, 0.75, 0.5]
    assert table.success_time.isna().sum() == 10


def test_the_pictures_are_pictures(written):
    out, files = written
    assert {f"report/{name}.png" for name in ("intervals", "profiles", "curves", "pareto")} < set(
        files
    )
    for name in files:
        if name.endswith(".png"):
            assert (out / name).read_bytes().startswith(b"\x89PNG")
            assert f"({name.removeprefix('report/')})" in (out / "report" / "report.md").read_text()


def test_of_a_picture_of_what_is_won_and_lost_the_front_alone_is_filled(tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    drawn: list[Figure] = []

    def save(figure: Figure, part: Path, **_: Any) -> None:
        drawn.append(figure)
        part.touch()

    monkeypatch.setattr(Figure, "savefig", save)
    found = {
        name: {"success_time": at, "wasted_cost": at, "success_rate": None}
        for name, at in (("first", Estimate(1, 0.9, 1.1)), ("worse", Estimate(2, 1.9, 2.1)))
    }
    pictures.draw_pareto(found, ["first"], tmp_path / "pareto.png")
    lines = {line.get_label(): line for line in drawn[0].axes[0].lines}
    filled = {name: lines[name].get_markerfacecolor() != "none" for name in found}
    assert filled == {"first": True, "worse": False}


def test_equal_results_give_equal_reports(written, results, tmp_path):
    with no_pictures():
        write_report(results, tmp_path)
    scores = {
        r: results.scores(runs, "success_rate") for (r,), runs in results.by_setting().items()
    }
    pictures.draw_profiles(scores, tmp_path / "report" / "profiles.png")
    for path in (tmp_path / "report").iterdir():
        assert path.read_bytes() == (written[0] / "report" / path.name).read_bytes()


def test_without_the_libraries_there_is_a_page_that_says_so_and_a_table_as_csv(
    results, tmp_path, monkeypatch
):
    for name in ("matplotlib.figure", "pyarrow"):
        monkeypatch.setitem(sys.modules, name, None)
    assert write_report(results, tmp_path) == ["report/report.md", "report/runs.csv"]
    page = (tmp_path / "report" / "report.md").read_text()
    assert "no pictures: the pictures of a report needs an optional package" in page
    lines = (tmp_path / "report" / "runs.csv").read_text().splitlines()
    assert len(lines) == 25
    assert lines[0].startswith("task,reward,seed,success_rate")


def test_a_folder_that_is_no_experiment_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match=r"which has no experiment\.json"):
        Results.load(tmp_path)


@pytest.mark.parametrize("axes", [3, {"reward": 3}])
def test_a_damaged_list_of_cells_is_told_as_such(axes, tmp_path):
    content = {"format": 1, "name": "x", "problems": [], "search": {}, "cells": [], "axes": axes}
    (tmp_path / "experiment.json").write_text(json.dumps(content))
    with pytest.raises(InvalidInput, match=r"experiment\.json must be whole"):
        Results.load(tmp_path)


def weight(cell: Cell, name: str) -> float:
    term: Any = cell.environment.terms[name]
    return term.weight


def test_a_sweep_has_a_setting_a_weight(tmp_path):
    training = TrainConfig(
        environment=EnvironmentChoice(reward="harmony", body=("mass=5",), weights=("progress=4",)),
        steps=10_000,
        seed=2,
        out=tmp_path,
    )
    experiment = sweep("relative_cost", [0, 0.1], training, seeds=3)
    cells = experiment.cells()
    assert [cell.levels["reward"] for cell in cells[::3]] == [
        "relative_cost_0.0",
        "relative_cost_0.1",
    ]
    assert [cell.seed for cell in cells[:3]] == [2, 3, 4]
    assert experiment.out == tmp_path
    for cell in cells:
        environment: Any = cell.environment
        assert environment.body.mass == 5
        assert environment.terms["progress"].weight == 4
        assert cell.training.steps == 10_000
    assert [weight(cell, "relative_cost") for cell in cells[::3]] == [0, 0.1]


def test_a_sweep_adds_a_term_that_the_reward_has_not(tmp_path):
    experiment = sweep("wasted_cost", [0.1, 1.0], TrainConfig(out=tmp_path), seeds=1)
    assert [weight(cell, "wasted_cost") for cell in experiment.cells()] == [0.1, 1]


def test_a_sweep_of_what_does_not_exist_is_refused(tmp_path):
    with pytest.raises(UnknownName, match="did you mean 'wasted_cost'"):
        sweep("wastd_cost", [1.0], TrainConfig(out=tmp_path))
    for values, said in (([], "at least one"), ([1, 1.0], "once"), ([nan], "finite")):
        with pytest.raises(InvalidInput, match=said):
            sweep("time", values, TrainConfig(out=tmp_path))
    with pytest.raises(InvalidInput, match="fresh must be False"):
        sweep("time", [1.0], TrainConfig(out=tmp_path, fresh=True))


def test_what_the_lines_of_a_profile_are_stands_beside_them(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(pictures, "_save", lambda figure, path: drawn.append(figure))
    scores = {name: [*map(np.array, SUCCESS[name].values())] for name in ("plain", "gentle")}
    pictures.draw_profiles(scores, tmp_path / "profiles.png")
    (axes,) = drawn[0].axes
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["plain", "gentle"]


def test_settings_beyond_the_colours_have_marks_of_their_own(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(pictures, "_save", lambda figure, path: drawn.append(figure))
    some = Estimate(value=1.0, low=0.5, high=1.5)
    found: Any = {
        f"setting {n}": dict.fromkeys(("success_time", "wasted_cost", "success_rate"), some)
        for n in range(12)
    }
    pictures.draw_pareto(found, [], tmp_path / "pareto.png")
    lines = [
        line for line in drawn[0].axes[0].get_lines() if line.get_label().startswith("setting")
    ]
    looks = [(line.get_marker(), line.get_color()) for line in lines]
    assert len(set(looks)) == 12
    assert looks[0][1] == looks[10][1]
