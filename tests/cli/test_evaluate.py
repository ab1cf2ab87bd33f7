"""``coopenv evaluate``: every policy in the environment of its own file."""

import csv
import json
import zipfile
from pathlib import Path

import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from coopenv import Body, TransportConfig, cli
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.cli import environments
from coopenv.rewards import RewardSum, TimeCost


@pytest.fixture(autouse=True)
def _wide(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")


def trained(out: Path, environment: TransportConfig) -> Path:
    config = TrainConfig(
        steps=16, num_worlds=2, rollout=4, batch_size=8, epochs=1, hidden=(4,), out=out
    )
    train(config, environment=environment)
    return out / "policy.zip"


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> tuple[Path, Path]:
    """Policies of two environments, one of them with another body, reward and sight."""
    folder = tmp_path_factory.mktemp("runs")
    reward = RewardSum({"time": TimeCost(weight=2.0)})
    heavy = TransportConfig(horizon=5, body=Body(mass=20.0), reward=reward, observe=("goal",))
    return trained(folder / "short", TransportConfig(horizon=3)), trained(folder / "heavy", heavy)


def evaluated(*arguments, out: Path) -> list[dict[str, str]]:
    """The rows of the saved table."""
    assert cli.main([*map(str, arguments), "--episodes=2", f"--out={out}"]) == 0
    with out.open(newline="") as file:
        return list(csv.DictReader(file))


def test_each_policy_runs_in_its_own_environment(files, tmp_path, capsys):
    rows = evaluated("evaluate", *files, "random", out=tmp_path / "table.csv")
    returns = [float(row["reward"]) for row in rows]
    assert [row["policy"] for row in rows] == ["short", "heavy", "random"]
    assert returns[1] == pytest.approx(-2.0 * 5 * 0.05)  # weight · steps · dt
    assert returns[0] != returns[1]
    printed = capsys.readouterr().out
    assert "short, random: coopenv/BeamTransport-v0 with horizon 3" in printed
    assert "heavy: coopenv/BeamTransport-v0 with body.mass 20.0" in printed


def test_options_change_only_what_they_name(files, tmp_path, capsys):
    rows = evaluated("evaluate", files[1], "--horizon=7", out=tmp_path / "table.csv")
    assert float(rows[0]["reward"]) == pytest.approx(-2.0 * 7 * 0.05)
    printed = capsys.readouterr().out
    assert "horizon 7" in printed
    assert "body.mass 20.0" in printed
    assert "2 episodes" in printed


def test_an_id_on_the_command_line_is_the_environment(files, tmp_path, capsys):
    ids = ("--env=coopenv/BeamTransport-v0", "--horizon=4")
    evaluated("evaluate", files[0], *ids, out=tmp_path / "table.csv")
    printed = capsys.readouterr().out
    assert "coopenv/BeamTransport-v0 with horizon 4, 2 episodes" in printed


def test_without_trained_policies_the_environment_is_the_default(tmp_path, capsys):
    evaluated("evaluate", "scripted", "--horizon=4", out=tmp_path / "table.csv")
    assert "coopenv/BeamTransport-v0 with horizon 4" in capsys.readouterr().out


def bare(path: Path, to: Path) -> Path:
    """The policy as it was written before files said where they come from."""
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(to, "w") as made:
        for name in archive.namelist():
            if not name.startswith("coopenv"):
                made.writestr(name, archive.read(name))
    return to


def test_an_older_file_is_evaluated_and_said_to_name_no_environment(files, tmp_path, capsys):
    old = bare(files[0], tmp_path / "old.zip")
    evaluated("evaluate", old, "--horizon=4", out=tmp_path / "table.csv")
    captured = capsys.readouterr()
    assert "old.zip does not say which environment it was trained in" in captured.err
    assert "coopenv/BeamTransport-v0 with horizon 4" in captured.out
    settings = json.loads(files[0].with_name("config.json").read_text())
    del settings["provenance"]
    settings["environment"]["horizon"] = 6
    (tmp_path / "config.json").write_text(json.dumps(settings))
    evaluated("evaluate", old, out=tmp_path / "table.csv")
    captured = capsys.readouterr()
    assert "config.json names" in captured.err
    assert "horizon 6" in captured.out


def test_another_version_is_said_and_does_not_matter(files, tmp_path, capsys, monkeypatch):
    from coopenv.agents import provenance

    monkeypatch.setattr(provenance, "version", lambda name: "999.0" if name == "torch" else "1")
    evaluated("evaluate", files[0], out=tmp_path / "table.csv")
    assert "(now 999.0)" in capsys.readouterr().err


MODULE = """
from dataclasses import dataclass
import numpy as np

@dataclass(frozen=True)
class Mine:
    weight: float = 1.0

    def __call__(self, transition):
        return self.weight * np.ones(transition.applied.shape[:2])
"""


def test_code_of_ones_own_is_imported_only_if_trusted(tmp_path, monkeypatch, capsys):
    (tmp_path / "my_rewards.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    import my_rewards  # type: ignore[import-not-found]

    reward = RewardSum({"mine": my_rewards.Mine(weight=3.0)})
    path = trained(tmp_path / "own", TransportConfig(horizon=3, reward=reward))
    assert cli.main(["evaluate", str(path), "--episodes=2"]) == 1
    assert "my_rewards" in capsys.readouterr().err
    rows = evaluated("evaluate", path, "--trust=my_rewards", out=tmp_path / "table.csv")
    assert float(rows[0]["reward"]) == pytest.approx(9.0)


def test_a_title_imports_no_module_that_is_not_trusted(tmp_path, monkeypatch):
    (tmp_path / "my_envs.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    place = environments.Environment("my_envs:Mine-v0", TransportConfig())
    assert "not registered" in place.title()
