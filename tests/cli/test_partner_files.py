"""The file of a policy as a partner on the command line."""

import json
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

from coopenv import cli
from coopenv.agents.provenance import Provenance
from coopenv.agents.train import train
from tests.agents.learned import hostile
from tests.agents.training.cases import SHORT, tiny

TINY = ("--steps=64", "--num-worlds=4", "--rollout=8", "--batch-size=16", "--epochs=1")


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    """A policy that drives a whole team."""
    out = tmp_path_factory.mktemp("first")
    train(tiny(out), environment=SHORT)
    return out / "policy.zip"


def learned(out: Path, *options: str) -> int:
    """Train one agent beside a partner, and compare on two episodes."""
    shown = ("--hidden", "4", "--episodes=2", "--no-gif", "--horizon=8")
    return cli.main(["train", *TINY, *shown, "--control=partner", f"--out={out}", *options])


def test_a_policy_learns_beside_a_file_and_is_evaluated_beside_it(file, tmp_path, capsys):
    assert learned(tmp_path, f"--partner={file}") == 0
    title = f"partner {file}"
    assert title in " ".join(capsys.readouterr().out.split())
    record = Provenance.read(tmp_path / "policy.zip")
    assert record is not None
    assert record.environment["partner"]["path"] == str(file)
    policy = str(tmp_path / "policy.zip")
    assert cli.main(["evaluate", policy, "--episodes=2"]) == 0
    assert title in " ".join(capsys.readouterr().out.split())
    assert cli.main(["evaluate", "scripted", "--episodes=2", f"--partner={policy}"]) == 0


def test_another_policy_under_the_name_of_the_partner_is_told(file, tmp_path, capsys):
    partner = tmp_path / "partner.zip"
    partner.write_bytes(file.read_bytes())
    assert learned(tmp_path / "run", f"--partner={partner}") == 0
    partner.write_bytes((tmp_path / "run" / "policy.zip").read_bytes())
    capsys.readouterr()
    assert cli.main(["evaluate", str(tmp_path / "run" / "policy.zip"), "--episodes=2"]) == 1
    assert "partner.digest must be that of the file" in capsys.readouterr().err
    assert learned(tmp_path / "run", f"--partner={partner}", "--steps=128") == 1
    assert "partner.digest" in capsys.readouterr().err


def test_a_partners_file_runs_nothing_unless_the_command_trusts_it(file, tmp_path, capsys):
    marker = tmp_path / "marker"
    path = hostile.in_data(file, tmp_path / "partner.zip", marker)
    beside = ["evaluate", "random", "--episodes=1", f"--partner={path}"]
    assert cli.main(beside) == 0
    options = tmp_path / "options.json"
    options.write_text(json.dumps({"environment": {"partner": str(path)}}))
    assert cli.main(["evaluate", "random", "--episodes=1", f"--config={options}"]) == 0
    assert not marker.exists()
    assert cli.main([*beside, "--trust"]) == 0
    assert marker.exists()
    marker.unlink()
    assert learned(tmp_path / "run", f"--partner={path}") == 0
    assert not marker.exists()
    assert learned(tmp_path / "other", f"--partner={path}", "--trust") == 0
    assert marker.exists()


def test_a_partner_that_is_not_there_is_told_in_one_line(tmp_path, capsys):
    assert cli.main(["evaluate", "random", "--partner=nowhere/policy.zip"]) == 1
    said = capsys.readouterr().err
    assert "partner must be a policy's file" in said
    assert "Traceback" not in said
