"""Cells that learn: runs of the trainer, killed and begun anew, or gone on with."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv.agents import curves
from coopenv.agents.experiments.cell import RESULT
from coopenv.agents.experiments.work import work
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy
from tests.agents.experiments.cases import TRAINING, small

LEARNING = {**TRAINING, "hidden": [8], "checkpoint_every": 1}


def cell_in(folder, **changes):
    """A cell that learns for four rollouts, in its folder."""
    terms = {"squeeze": {"kind": "InternalForce", "settings": {"method": "moore_penrose"}}}
    grid = {"reward": {"squeeze": {"terms": terms}}}
    (cell,) = small(folder, grid=grid, training=LEARNING, seeds=[1], **changes).cells()
    cell.at(folder).save(folder)
    return cell


def killed(said):
    if said["steps"] >= 96:
        raise KeyboardInterrupt


@pytest.fixture(scope="module", autouse=True)
def _undrawn():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curves, "draw", lambda *given: None)
        yield


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cell")
    cell_in(folder)
    work(folder)
    return folder


def test_a_cell_that_learns_is_a_run_of_the_trainer(undisturbed):
    names = {path.name for path in undisturbed.iterdir()}
    assert {"policy.zip", "config.json", "curves.csv", "tensorboard", "evaluation.json"} <= names
    provenance = Provenance.read(undisturbed / "policy.zip")
    assert provenance is not None
    term: Any = provenance.config().terms["squeeze"]
    assert term.settings.method == "moore_penrose"
    assert provenance.training["seed"] == 1


def test_a_cell_that_is_killed_begins_anew_and_comes_to_the_same_result(undisturbed, tmp_path):
    cell_in(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        work(tmp_path, killed)
    assert (tmp_path / "checkpoint.zip").exists()
    work(tmp_path)
    for name in (RESULT, "curves.csv"):
        assert (tmp_path / name).read_bytes() == (undisturbed / name).read_bytes()
    mine, theirs = (
        SB3Policy.load(folder / "policy.zip").model.policy.state_dict()
        for folder in (tmp_path, undisturbed)
    )
    for name in mine:
        np.testing.assert_array_equal(mine[name].numpy(), theirs[name].numpy())


def test_a_cell_that_is_killed_between_training_and_evaluation_is_not_trained_again(
    undisturbed, tmp_path
):
    cell_in(tmp_path)
    for name in ("policy.zip", "config.json"):
        (tmp_path / name).write_bytes((undisturbed / name).read_bytes())
    rows = []
    work(tmp_path, rows.append)
    assert rows == []
    assert (tmp_path / RESULT).read_bytes() == (undisturbed / RESULT).read_bytes()


def test_a_cell_that_continues_goes_on_from_the_checkpoint(tmp_path):
    cell_in(tmp_path, continues=True)
    with pytest.raises(KeyboardInterrupt):
        work(tmp_path, killed)
    rows = []
    work(tmp_path, rows.append)
    assert [row["steps"] for row in rows] == [96, 128]
