"""Grids spread over nodes: results come home whole, and what a lost node had begins again."""

import json
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("matplotlib")

from coopenv.agents.experiments import conduct
from coopenv.agents.experiments.cell import RESULT
from coopenv.agents.experiments.nodes import Spread, spread
from coopenv.agents.experiments.run import INTERRUPTED
from coopenv.errors import InvalidInput
from tests.agents.experiments.cases import files, here, no_pictures, small
from tests.agents.experiments.nodes.cases import Threads


@pytest.fixture(scope="module", autouse=True)
def _unpictured():
    with no_pictures():
        yield


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """The folder of an experiment that this machine ran."""
    out = tmp_path_factory.mktemp("alone")
    conduct(small(out, seeds=1), launch=here, workers=1)
    return out


def saved(folder: Path, name: str = "random"):
    """A cell that is about to be worked on, and its folder."""
    cell = next(c for c in small(folder, seeds=1).cells() if c.algorithm == name)
    cell.save(folder)
    return cell


def cells_of(out: Path) -> dict[str, bytes]:
    paths = (path for path in (out / "cells").rglob("*") if path.is_file())
    return {path.relative_to(out).as_posix(): path.read_bytes() for path in paths}


def test_a_grid_on_nodes_leaves_what_it_leaves_here(alone, tmp_path):
    nodes = Threads()
    outcome = conduct(small(tmp_path, seeds=1), nodes=nodes)
    assert outcome.failures == {}
    assert len(nodes.begun) == outcome.cells == 2
    assert files(tmp_path) == files(alone)
    results = {name: data for name, data in cells_of(tmp_path).items() if name.endswith(RESULT)}
    assert results == {n: data for n, data in cells_of(alone).items() if n.endswith(RESULT)}
    conduct(small(tmp_path, seeds=1), nodes=nodes)
    assert len(nodes.begun) == 2  # nothing finished goes out again


def test_cells_of_lost_nodes_run_again_and_the_report_is_the_same(alone, tmp_path, capsys):
    nodes = Threads(losses=3)
    outcome = conduct(small(tmp_path, seeds=1), nodes=nodes)
    assert outcome.failures == {}
    assert len(nodes.begun) == 2 + 3
    assert capsys.readouterr().err.count("begins anew: the machine is gone") == 3
    assert files(tmp_path) == files(alone)


def test_a_cell_whose_nodes_are_lost_again_and_again_fails(tmp_path, monkeypatch):
    monkeypatch.setattr(spread, "LOSSES", 3)
    nodes = Threads(losses=99)
    outcome = conduct(small(tmp_path, seeds=1, grid={}), nodes=nodes, workers=1)
    assert len(nodes.begun) == 3
    assert list(outcome.failures.values()) == [
        "its node was lost 3 times, the last time as the machine is gone"
    ]


def test_what_fails_on_a_node_is_told_here_and_not_tried_again_by_itself(tmp_path):
    nodes = Threads(launch=lambda folder, report: "it diverged")
    outcome = conduct(small(tmp_path, seeds=1, grid={}), nodes=nodes)
    assert list(outcome.failures.values()) == ["it diverged"]
    assert len(nodes.begun) == 1
    assert (tmp_path / "cells" / "all" / "seed_0" / "failure.txt").read_text() == "it diverged\n"


def test_an_error_on_a_node_is_a_failure_with_its_kind(tmp_path):
    def broken(folder, report):
        raise OSError("no room")

    saved(tmp_path)
    assert Spread(Threads(launch=broken))(tmp_path, print) == "OSError: no room"


def test_progress_comes_from_the_node_and_falls_back_where_it_is_lost(tmp_path):
    def telling(folder, report):
        report({"steps": 10})
        return here(folder, report)

    saved(tmp_path)
    told = []
    assert Spread(Threads(losses=1, launch=telling))(tmp_path, told.append) is None
    assert [said["steps"] for said in told] == [0, 10]


def test_all_that_lies_in_the_folder_travels_but_what_is_hidden_or_a_link(tmp_path):
    home = tmp_path / "home"
    (home / "deep").mkdir(parents=True)
    saved(home)
    (home / "deep" / "log.bin").write_bytes(b"\0\1")
    (home / "checkpoint.zip").write_bytes(b"old")
    (home / ".hidden").write_text("a lock")
    (home / "link").symlink_to(tmp_path)

    def seeing(folder, report):
        names = {path.relative_to(folder).as_posix() for path in folder.rglob("*")}
        assert names == {"cell.json", "deep", "deep/log.bin", "checkpoint.zip"}
        (folder / "checkpoint.zip").unlink()  # as a training does at its end
        (folder / "new" / "er").mkdir(parents=True)
        (folder / "new" / "er" / "curve").write_text("1")
        return here(folder, report)

    assert Spread(Threads(launch=seeing))(home, print) is None
    assert (home / "deep" / "log.bin").read_bytes() == b"\0\1"
    assert (home / "new" / "er" / "curve").read_text() == "1"
    assert not (home / "checkpoint.zip").exists()
    assert (home / ".hidden").exists()


def test_a_result_comes_last_so_that_half_a_folder_is_no_finished_cell(tmp_path, monkeypatch):
    cell, seen = saved(tmp_path), []
    real = spread.unpack

    def cut(parcel, folder, sent):
        from coopenv.agents.experiments.nodes import parcel as module

        order = module.names_in(parcel)
        seen.extend(order)
        real(parcel, folder, sent)

    monkeypatch.setattr(spread, "unpack", cut)
    assert Spread(Threads())(tmp_path, print) is None
    assert seen[-1] == RESULT
    assert cell.is_finished(tmp_path)


def test_a_parcel_that_leads_out_of_its_folder_is_refused(tmp_path):
    import io
    import zipfile

    from coopenv.agents.experiments.nodes.parcel import unpack

    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        archive.writestr("../out.txt", "x")
    with pytest.raises(InvalidInput, match="leads out"):
        unpack(data.getvalue(), tmp_path / "in")
    assert not (tmp_path / "out.txt").exists()


def test_a_result_of_another_configuration_is_no_result(tmp_path):
    """As a node with another coopenv would send it."""

    def other(folder, report):
        assert here(folder, report) is None
        content = json.loads((folder / RESULT).read_text())
        (folder / RESULT).write_text(json.dumps({**content, "cell": "0" * 64}))

    saved(tmp_path)
    assert "install the same version there" in str(Spread(Threads(launch=other))(tmp_path, print))


def test_an_interruption_ends_what_nodes_work_on(tmp_path):
    begun, going = threading.Event(), threading.Event()

    def long(folder, report):
        begun.set()
        for step in range(200):
            report({"steps": step})
            time.sleep(0.05)
            if going.is_set():
                return "never heard"
        return None

    saved(tmp_path)
    worker, came = Spread(Threads(launch=long)), []
    thread = threading.Thread(target=lambda: came.append(worker(tmp_path, lambda said: None)))
    thread.start()
    assert begun.wait(20)
    worker.stop()
    going.set()
    thread.join(20)
    assert came == [INTERRUPTED]
    assert worker(tmp_path, print) == INTERRUPTED  # nothing begins any more
