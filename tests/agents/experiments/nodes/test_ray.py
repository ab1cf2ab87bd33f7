"""A grid on Ray's nodes, a worker of which is killed on the way: `make rllib-test`."""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("ray", reason="Ray has an environment of its own: make rllib-test")
pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv.agents.experiments import conduct, joined
from coopenv.agents.experiments.cell import RESULT
from coopenv.agents.experiments.run import WORK
from coopenv.errors import InvalidInput
from tests.agents.experiments.cases import TRAINING, files, here, no_pictures, small

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are found in /proc")
GRID = {"algorithm": ["ppo", "random"]}
LEARNING = {**TRAINING, "hidden": [8]}
LONGEST = 300.0  # [s] that a worker may take until it works


def grid(out: Path):
    return small(out, grid=GRID, training=LEARNING, seeds=1)


def parent_at_work(wanted: str) -> int | None:
    """The process that has started the one that works on a cell, if there is one."""
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().decode().split("\0")
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            title = Path(f"/proc/{parent}/cmdline").read_bytes().decode()
        except (OSError, ValueError):
            continue
        if WORK in words and wanted in title:
            return parent
    return None


def kill_one(killed: list[int]) -> None:
    """Kill the first of Ray's workers that has a cell."""
    end = time.monotonic() + LONGEST
    while time.monotonic() < end and not killed:
        worker = parent_at_work("ray::work_on")
        if worker is not None:
            os.kill(worker, signal.SIGKILL)
            killed.append(worker)
        time.sleep(0.2)


def test_a_grid_of_two_cells_comes_home_whole_though_a_worker_is_killed(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("RAY_worker_niceness", "0")
    alone, out, killed = tmp_path / "alone", tmp_path / "out", []
    handler = signal.getsignal(signal.SIGTERM)
    with no_pictures():
        conduct(grid(alone), launch=here, workers=1)
        with joined() as nodes:
            assert signal.getsignal(signal.SIGTERM) is handler
            assert str(nodes).startswith("Ray: 1 nodes, ")
            killer = threading.Thread(target=kill_one, args=(killed,))
            killer.start()
            outcome = conduct(grid(out), nodes=nodes)
            killer.join()
    assert outcome.failures == {}
    assert len(killed) == 1
    assert "its cell seed_0 begins anew: WorkerCrashedError" in capsys.readouterr().err
    assert files(out) == files(alone)
    for cell in grid(out).cells():
        mine, theirs = (folder / cell.folder for folder in (out, alone))
        assert (mine / RESULT).read_bytes() == (theirs / RESULT).read_bytes()
        names = [{path.name for path in folder.iterdir()} for folder in (mine, theirs)]
        assert names[0] >= names[1] - {"curves.png"}
    assert (out / "cells" / "algorithm=ppo" / "seed_0" / "policy.zip").is_file()


def test_a_cluster_that_is_not_there_is_told(monkeypatch):
    with (
        pytest.raises(InvalidInput, match=r"address must be that of a Ray cluster that runs"),
        joined("auto"),
    ):
        pass


def test_an_interruption_ends_what_rays_workers_work_on(tmp_path, monkeypatch):
    monkeypatch.setenv("RAY_worker_niceness", "0")
    out = tmp_path / "out"
    endless = small(out, grid={"algorithm": ["random"]}, seeds=1, episodes=100_000)
    end = time.monotonic() + LONGEST

    def show(**said):
        if parent_at_work("ray::work_on") is not None or time.monotonic() > end:
            raise KeyboardInterrupt

    with joined() as nodes:
        with pytest.raises(KeyboardInterrupt):
            conduct(endless, nodes=nodes, show=show)
        assert time.monotonic() < end
        while parent_at_work("ray::work_on") is not None and time.monotonic() < end:
            time.sleep(0.2)
        assert parent_at_work("ray::work_on") is None
    assert not list(out.glob(f"cells/*/*/{RESULT}"))
