"""Running of grids: interruptions, kills, failures, and what is never written over."""

import io
import json
import subprocess
import sys
import time
import types
from dataclasses import replace
from itertools import pairwise

import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.experiments import Search, conduct
from coopenv.agents.experiments.cell import CELL, FAILURE, RESULT, Cell
from coopenv.agents.experiments.run import WORK, run_cells
from coopenv.agents.experiments.work import main, tell, work
from coopenv.errors import InvalidInput, MissingPackage
from tests.agents.experiments.cases import ENVIRONMENT, files, here, no_pictures, small


class Killed:
    """Works on cells until so many are done, and is interrupted in the middle of the next."""

    def __init__(self, after: int):
        self.after, self.worked = after, []

    def __call__(self, folder, report):
        if len(self.worked) == self.after:
            raise KeyboardInterrupt
        self.worked.append(folder.relative_to(folder.parents[2]).as_posix())
        return here(folder, report)


@pytest.fixture(scope="module", autouse=True)
def _unpictured():
    with no_pictures():
        yield


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The folder of an experiment that nothing disturbed."""
    out = tmp_path_factory.mktemp("finished")
    outcome = conduct(small(out), launch=here, workers=1)
    assert outcome.failures == {}
    assert len(outcome.results.runs) == outcome.cells == 4
    return out


@pytest.mark.parametrize("tune", [0, 3])
def test_a_search_changes_the_grid_before_its_cells_run_if_it_has_trials(tune, tmp_path):
    class Found(Search):
        def algorithms(self, experiment) -> dict[str | None, str]:
            return {None: "ppo"}

        def run(self, experiment, trials, run):
            return replace(experiment, seeds=1), {"ppo": {"trials": trials}}

    search = Found(space={"epochs": {"low": 1, "high": 4}})
    outcome = conduct(small(tmp_path), search=search, tune=tune, launch=here, workers=1)
    assert outcome.cells == (2 if tune else 4)
    assert outcome.results.settings_found == ({"ppo": {"trials": 3}} if tune else {})


def test_every_cell_has_a_folder_with_its_configuration_versions_revision_and_evaluation(finished):
    folders = sorted(finished.glob("cells/*/*"))
    assert [path.relative_to(finished).as_posix() for path in folders] == [
        f"cells/algorithm={name}/seed_{seed}" for name in ("random", "scripted") for seed in (0, 1)
    ]
    for folder in folders:
        cell, result = (json.loads((folder / name).read_text()) for name in (CELL, RESULT))
        assert cell["environment"]["horizon"] == 60
        assert result["versions"]["numpy"]
        assert result["revision"] == cell["revision"]
        assert result["evaluation"]["episodes"] == 3
        assert Cell.load(folder).digest() == result["cell"]


def test_an_experiment_that_is_interrupted_again_and_again_comes_to_the_same_report(
    finished, tmp_path
):
    experiment = small(tmp_path)
    worked = []
    for after in (0, 1, 0, 2):
        killed = Killed(after)
        with pytest.raises(KeyboardInterrupt):
            conduct(experiment, launch=killed, workers=1)
        worked += killed.worked
    last = Killed(9)
    conduct(experiment, launch=last, workers=1)
    worked += last.worked
    assert len(worked) == len(set(worked)) == 4  # nothing finished was repeated
    assert files(tmp_path) == files(finished)


def test_several_cells_at_a_time_give_the_same_report(finished, tmp_path):
    conduct(small(tmp_path), launch=here, workers=3)
    assert files(tmp_path) == files(finished)


def test_a_cell_that_fails_is_told_and_tried_again_and_the_others_go_on(finished, tmp_path):
    def failing(folder, report):
        return "it broke\nat last" if "random/seed_1" in str(folder) else here(folder, report)

    out = tmp_path / "out"
    outcome = conduct(small(out), launch=failing, workers=1)
    assert outcome.failures == {"cells/algorithm=random/seed_1": "at last"}
    assert "it broke" in (out / "cells/algorithm=random/seed_1" / FAILURE).read_text()
    page = (out / "report" / "report.md").read_text()
    assert "3 of 4 cells are finished" in page
    assert "`cells/algorithm=random/seed_1`: at last" in page
    again = conduct(small(out), launch=here, workers=1)
    assert again.failures == {}
    assert not (out / "cells/algorithm=random/seed_1" / FAILURE).exists()
    assert files(out) == files(finished)


def test_a_grid_may_grow_and_never_shrink_or_change(tmp_path):
    worked = Killed(9)
    first = small(tmp_path, seeds=1)
    conduct(first, launch=worked, workers=1)
    grown = small(tmp_path, seeds=2)
    conduct(grown, launch=worked, workers=1)
    assert len(worked.worked) == 4
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(InvalidInput, match="cells that are not in this grid"):
        conduct(first, launch=worked, workers=1)
    with pytest.raises(InvalidInput, match=r"differs in episodes; choose another out"):
        conduct(replace(grown, episodes=2), launch=worked, workers=1)
    with pytest.raises(InvalidInput, match=r"differs in environment\.horizon"):
        conduct(
            replace(grown, environment={**ENVIRONMENT, "horizon": 50}), launch=worked, workers=1
        )
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_what_no_experiment_wrote_is_not_written_over(tmp_path):
    folder = tmp_path / "cells" / "algorithm=random" / "seed_0"
    folder.mkdir(parents=True)
    (folder / "notes.txt").write_text("mine")
    worked = Killed(9)
    with pytest.raises(InvalidInput, match="whose files no experiment wrote"):
        conduct(small(tmp_path), launch=worked, workers=1)
    assert not worked.worked
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["notes.txt"]


def test_a_report_that_no_experiment_wrote_is_not_written_over(tmp_path):
    (tmp_path / "report").mkdir()
    page = tmp_path / "report" / "report.md"
    page.write_text("mine")
    worked = Killed(9)
    with pytest.raises(InvalidInput, match="no other report"):
        conduct(small(tmp_path), launch=worked, workers=1)
    assert not worked.worked
    assert page.read_text() == "mine"


def test_the_progress_counts_all_cells_up_to_their_end(tmp_path):
    seen = []
    cells = small(tmp_path).cells()
    run_cells(cells, tmp_path, workers=1, launch=here, show=lambda **said: seen.append(said))
    assert seen[-1] == {"done": 600.0, "total": 600.0, "cells": 4, "of": 4}  # 50 steps an episode
    assert all(one["done"] <= two["done"] for one, two in pairwise(seen))


def test_a_process_of_its_own_does_what_this_one_would(finished, tmp_path):
    cell = small(tmp_path).cells()[-1]
    assert run_cells([cell], tmp_path, workers=1) == {}
    mine, theirs = (
        json.loads((out / cell.folder / RESULT).read_text()) for out in (tmp_path, finished)
    )
    assert mine == theirs
    assert not (tmp_path / cell.folder / FAILURE).exists()


def test_a_process_says_why_it_failed(tmp_path, monkeypatch, capsys):
    (tmp_path / CELL).write_text("{}")
    monkeypatch.setattr(sys, "argv", ["work", str(tmp_path)])
    monkeypatch.setattr("coopenv.agents.experiments.work.Thread", lambda **given: Idle())
    monkeypatch.setattr("signal.signal", lambda *given: None)
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code == 1
    assert "must be of format 1" in json.loads(capsys.readouterr().out)["failed"]


class Idle:
    """A thread that does nothing."""

    def start(self):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="processes are ended otherwise there")
def test_a_process_ends_when_its_experiment_is_gone(tmp_path):
    """Its standard input ends then, however the experiment ended."""
    cell = small(tmp_path, episodes=100_000, grid={"algorithm": ["random"]}).cells()[0]
    cell.save(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-m", WORK, str(tmp_path)], stdin=subprocess.PIPE
    ) as process:
        end = time.monotonic() + 120
        while not (tmp_path / ".coopenv.lock").exists() and time.monotonic() < end:
            time.sleep(0.05)
        assert process.stdin is not None
        process.stdin.close()
        assert process.wait(120) == 130
    assert not (tmp_path / RESULT).exists()
    assert not (tmp_path / ".coopenv.lock").exists()


class Project:
    """Stands for the package of Weights & Biases."""

    def __init__(self):
        self.rows, self.given, self.finished = [], {}, False

    def init(self, **given):
        self.given = given
        return types.SimpleNamespace(log=self.rows.append, finish=self.finish)

    def finish(self):
        self.finished = True


def test_curves_and_evaluation_go_to_weights_and_biases_where_a_project_is_named(
    tmp_path, monkeypatch
):
    project = Project()
    monkeypatch.setitem(sys.modules, "wandb", project)
    cell = small(tmp_path, wandb="carrying").cells()[0]
    cell.save(tmp_path)
    seen = work(tmp_path)
    assert project.given["project"] == "carrying"
    assert project.given["group"] == "algorithm=scripted"
    assert project.rows[-1]["evaluation/success_rate"] == seen.success_rate
    assert project.finished


def test_a_project_without_the_package_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "wandb", None)
    cell = small(tmp_path, wandb="carrying").cells()[0]
    cell.save(tmp_path)
    with pytest.raises(MissingPackage, match="pip install 'wandb'"):
        work(tmp_path)


def test_what_a_worker_tells_is_read_at_once(monkeypatch):
    told = []

    class Pipe(io.StringIO):
        def flush(self):
            told.append(self.getvalue())

    monkeypatch.setattr(sys, "stdout", Pipe())
    tell({"done": 3})
    assert json.loads(told[-1]) == {"done": 3}
