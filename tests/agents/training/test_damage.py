"""Files of a run that are damaged, and trainings that diverge: told by name, never a traceback."""

import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

import torch
from stable_baselines3 import PPO

from coopenv import Transport, cli
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.train import train
from coopenv.agents.training.checkpoint import Checkpoint
from coopenv.errors import InvalidInput
from tests.agents.training.cases import SHORT, tiny


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> bytes:
    """The policy.zip of a run that is finished."""
    out = tmp_path_factory.mktemp("run")
    train(tiny(out), environment=SHORT)
    return (out / "policy.zip").read_bytes()


def replaced(content: bytes, path: Path, member: str, new: bytes) -> Path:
    """A copy of an archive at ``path`` in which one member holds something else."""
    path.write_bytes(content)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in {**members, member: new}.items():
            archive.writestr(name, data)
    return path


def member(content: bytes, path: Path, name: str) -> Any:
    path.write_bytes(content)
    with zipfile.ZipFile(path) as archive:
        return json.loads(archive.read(name))


@pytest.mark.parametrize("file", ["policy.zip", "checkpoint.zip"])
@pytest.mark.parametrize(
    "name", ["policy.pth", "data", "policy.optimizer.pth", "pytorch_variables.pth"]
)
def test_a_run_does_not_go_on_from_a_damaged_file(finished, tmp_path, file, name):
    path = replaced(finished, tmp_path / file, name, b"junk")
    written = path.read_bytes()
    with pytest.raises(InvalidInput, match=rf"{file}.*fresh=True \(--fresh\)"):
        train(tiny(tmp_path, steps=256), environment=SHORT)
    assert path.read_bytes() == written


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("training", 3),
        ("training", {"environment": {}}),
        ("training", {"environment": {"env": "coopenv/BeamTransport-v0"}, "hidden": 3}),
        ("versions", 3),
        ("versions", {"numpy": 3}),
        ("environment", []),
        ("command", "coopenv train"),
    ],
)
def test_damaged_provenance_is_told_with_its_file(finished, tmp_path, entry, value):
    path = tmp_path / "policy.zip"
    notes = member(finished, path, "coopenv.json")
    notes["provenance"][entry] = value
    replaced(finished, path, "coopenv.json", json.dumps(notes).encode())
    with pytest.raises(InvalidInput, match=r"policy\.zip.*--fresh"):
        train(tiny(tmp_path, steps=256), environment=SHORT)
    if "hidden" not in str(value):
        with pytest.raises(InvalidInput, match=rf"provenance\.{entry} must be .*policy\.zip"):
            Provenance.read(path)
        assert cli.main(["evaluate", str(path), "--episodes=1"]) == 1


def test_a_policy_that_no_run_trained_may_say_nothing_of_its_training(finished, tmp_path):
    given = member(finished, tmp_path / "policy.zip", "coopenv.json")["provenance"]
    del given["training"]
    for training in ({"training": {}}, {"training": None}, {}):
        found = Provenance.from_notes({"provenance": {**given, **training}})
        assert found is not None
        assert found.training == {}
        assert found.env == "coopenv/BeamTransport-v0"


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("steps", "a"),
        ("steps", -1),
        ("steps", 1.5),
        ("steps", True),
        ("rows", 3),
        ("rows", [3]),
        ("rows", [{"steps": "many"}]),
        ("window", 3),
        ("window", [[3]]),
        ("other", 1),
    ],
)
def test_damaged_progress_is_told_with_its_file(finished, tmp_path, entry, value):
    path = tmp_path / "policy.zip"
    progress = {**member(finished, path, "coopenv_progress.json"), entry: value}
    replaced(finished, path, "coopenv_progress.json", json.dumps(progress).encode())
    with pytest.raises(InvalidInput, match=r"policy\.zip: progress.*--fresh"):
        train(tiny(tmp_path, steps=256), environment=SHORT)


@pytest.mark.parametrize("name", ["coopenv.json", "coopenv_progress.json"])
def test_json_of_another_kind_is_told_with_its_file(finished, tmp_path, name):
    for text in (b"[]", b"3", b"{"):
        replaced(finished, tmp_path / "policy.zip", name, text)
        with pytest.raises(InvalidInput, match=r"policy\.zip.*--fresh"):
            train(tiny(tmp_path, steps=256), environment=SHORT)


WILD = {
    "steps": 2000,
    "learning_rate": 1.0,
    "clip_range": 1e6,
    "entropy_weight": 1e6,
    "initial_std": 1000.0,
}


def test_a_training_that_diverges_says_so(tmp_path):
    with pytest.raises(InvalidInput, match="diverged; lower learning_rate"):
        train(tiny(tmp_path, **WILD), environment=SHORT)
    assert not (tmp_path / "policy.zip").exists()


@pytest.mark.parametrize("at", [3, 4])
def test_a_training_that_diverges_leaves_the_last_good_checkpoint(tmp_path, monkeypatch, at):
    original, updates = PPO.train, []

    def spoilt(self) -> None:
        original(self)
        updates.append(1)
        if len(updates) == at:
            with torch.no_grad():
                next(self.policy.parameters()).fill_(float("nan"))

    with monkeypatch.context() as patch:
        patch.setattr(PPO, "train", spoilt)
        with pytest.raises(InvalidInput, match=rf"diverged; .*zip holds the {32 * (at - 1)} steps"):
            train(tiny(tmp_path), environment=SHORT)
    assert not (tmp_path / "policy.zip").exists()
    assert Checkpoint.read(tmp_path / "checkpoint.zip").progress.steps == 32 * (at - 1)
    policy = SB3Policy.load(tmp_path / "checkpoint.zip")
    assert all(torch.isfinite(value).all() for value in policy.model.policy.state_dict().values())


def test_a_policy_of_weights_that_are_nan_is_refused(finished, tmp_path, capsys):
    path = tmp_path / "policy.zip"
    path.write_bytes(finished)
    policy = SB3Policy.load(path)
    with torch.no_grad():
        for weights in policy.model.policy.parameters():
            weights.fill_(float("nan"))
    policy.save(path)
    for trust in (False, True):
        with pytest.raises(InvalidInput, match=r"zip' must be finite.*lower learning_rate"):
            SB3Policy.load(path, trust=trust)
    assert cli.main(["evaluate", str(path), "--env=coopenv/BeamTransport-v0", "--episodes=1"]) == 1
    assert "diverged" in capsys.readouterr().err
    core = Transport(num_worlds=2, config=SHORT)
    obs, _ = core.reset(seed=0)
    assert core.transition is not None
    for each in (policy, policy.sampled()):
        assert each is not None
        with pytest.raises(InvalidInput, match="actions of a policy must be finite"):
            each(obs, core.transition)
