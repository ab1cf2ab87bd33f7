"""Weights & Biases itself, without a net, where it is installed."""

import pytest

pytest.importorskip("wandb", reason="pip install wandb, where curves are to go there")
pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv.agents import curves
from coopenv.agents.experiments.work import work
from tests.agents.experiments.cases import TRAINING, small


def test_curves_and_evaluation_of_a_cell_lie_in_its_folder_offline(tmp_path, monkeypatch):
    monkeypatch.setenv("WANDB_MODE", "offline")
    monkeypatch.setattr(curves, "draw", lambda *given: None)
    training = {**TRAINING, "hidden": [8]}
    (cell,) = small(
        tmp_path, grid={"algorithm": ["ppo"]}, training=training, seeds=1, wandb="carrying"
    ).cells()
    cell.save(tmp_path)
    work(tmp_path)
    (kept,) = tmp_path.glob("wandb/offline-run-*/run-*.wandb")
    data = kept.read_bytes()
    names = [b"carrying", b"algorithm=ppo, seed 0", b"steps", b"evaluation/success_rate"]
    assert [name for name in names if name not in data] == []
    assert data.count(b"steps") >= training["steps"] // 32  # a row an update of 4 worlds, 8 steps
