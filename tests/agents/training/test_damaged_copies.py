"""Hundreds of damaged copies of policies and checkpoints: refused by name, or read as a whole."""

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")
pytest.importorskip("matplotlib")

import torch

from coopenv import cli
from coopenv.agents import curves
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.train import train
from coopenv.agents.training.checkpoint import Checkpoint
from tests.agents.learned import damage
from tests.agents.learned.cases import normalized, small, start, trained
from tests.agents.training.cases import SHORT, tiny

SEED = 20261129  # of what is damaged, and how


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """The policy of a run that is finished, from which more steps would go on."""
    out = tmp_path_factory.mktemp("run")
    train(tiny(out), environment=SHORT)
    return out / "policy.zip"


def test_a_run_goes_on_from_a_damaged_checkpoint_as_a_whole_or_not_at_all(run, tmp_path):
    model: Any = SB3Policy.load(run).model  # of the same build as the run's
    provenance = Provenance.of(tiny(run.parent), SHORT)

    def go_on(path: Path) -> None:
        checkpoint = Checkpoint.read(path)
        checkpoint.check(provenance)
        checkpoint.restore(model, rows=1)
        for parameter in model.policy.parameters():
            parameter.grad = torch.zeros_like(parameter)
        model.policy.optimizer.step()  # its moments fit
        curves.save_rows(checkpoint.progress.rows, tmp_path / "curves.csv")

    target = tmp_path / "checkpoint.zip"
    counts = damage.refused_or_whole(
        damage.damaged_archive, run, target, go_on, times=200, seed=SEED
    )
    assert counts["refused"] > 120
    assert counts["read"] > 5  # what is damaged there is not needed, the command for example
    counts = damage.refused_or_whole(optimizer, run, target, go_on, times=100, seed=SEED)
    assert counts["refused"] > 70


def optimizer(whole: bytes, rng: Any) -> tuple[str, bytes]:
    """Damage to what the optimiser remembers alone."""
    members = damage.members_of(whole)
    name = "policy.optimizer.pth"
    other = damage.of_other_weights(members[name], rng)
    return f"other {name}", damage.archive_of({**members, name: other})


def test_a_damaged_policy_acts_as_a_whole_or_not_at_all(run, tmp_path):
    def act(path: Path) -> None:
        SB3Policy.load(path)(*start(2, SHORT))

    counts = damage.refused_or_whole(
        damage.damaged_archive, run, tmp_path / "policy.zip", act, times=120, seed=SEED
    )
    assert counts["refused"] > 70


def test_a_damaged_record_is_refused_or_says_an_environment(run, tmp_path):
    def recorded(path: Path) -> None:
        provenance = Provenance.read(path)
        if provenance is not None:
            provenance.config()
            provenance.other_versions()

    def damaged(whole: bytes, rng: Any) -> tuple[str, bytes]:
        members = damage.members_of(whole)
        notes = damage.of_other_kind(members["coopenv.json"], rng)
        return "another kind in coopenv.json", damage.archive_of({**members, "coopenv.json": notes})

    counts = damage.refused_or_whole(
        damaged, run, tmp_path / "policy.zip", recorded, times=150, seed=SEED
    )
    assert counts["refused"] > 50


@pytest.mark.parametrize("name", ["SAC", "RecurrentPPO"])
def test_damaged_policies_of_other_algorithms_with_statistics_are_no_other(name, tmp_path):
    whole = tmp_path / "whole.zip"
    SB3Policy(trained(name, normalized())).save(whole)

    def act(path: Path) -> None:
        SB3Policy.load(path)(*start())

    counts = damage.refused_or_whole(
        damage.damaged_archive, whole, tmp_path / "policy.zip", act, times=50, seed=SEED
    )
    assert counts["refused"] > 25


def test_weights_of_another_build_are_refused(run, tmp_path):
    SB3Policy(trained("PPO", small("shared"))).save(tmp_path / "other.zip")
    weights = damage.members_of((tmp_path / "other.zip").read_bytes())["policy.pth"]
    members = {**damage.members_of(run.read_bytes()), "policy.pth": weights}
    path = tmp_path / "policy.zip"
    path.write_bytes(damage.archive_of(members))
    with pytest.raises(ValueError, match="policy must be a whole file of the algorithm"):
        SB3Policy.load(path)
    with pytest.raises(ValueError, match=r"out must hold weights of this run.*--fresh"):
        train(tiny(tmp_path, steps=256), environment=SHORT)


def test_damaged_policies_are_told_in_one_line_on_the_command_line(run, tmp_path, capsys):
    path = tmp_path / "policy.zip"
    members = damage.members_of(run.read_bytes())
    for name in ("coopenv.json", "coopenv_model.json", "data", "policy.pth"):
        for content in (b"", b"{", b"[]", members[name][:-3]):
            path.write_bytes(damage.archive_of({**members, name: content}))
            assert cli.main(["evaluate", str(path), "--episodes=1"]) == 1
            said = capsys.readouterr().err
            assert said.startswith("coopenv: ")
            assert "Traceback" not in said
            assert said.count("\n") == 1
