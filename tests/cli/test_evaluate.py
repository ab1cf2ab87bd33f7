"""``coopenv evaluate``: every policy in the environment of its own file."""

import csv
import json
import zipfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tyro")
pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from coopenv import Body, TransportConfig, cli
from coopenv.agents.environment import find_config
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy, make_vec_env
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.cli import environments
from coopenv.rewards import RewardSum, TimeCost
from tests.modules import OWN_REWARD

DESCRIPTORS = Path("/proc/self/fd")  # on Linux


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


def test_a_policy_of_any_team_is_evaluated_in_one_that_the_options_name(tmp_path, capsys):
    run: dict[str, Any] = {"steps": 16, "num_worlds": 2, "rollout": 4, "batch_size": 8, "epochs": 1}
    config = TrainConfig(control="shared", teams=(2, 3), hidden=(4,), out=tmp_path / "run", **run)
    train(config, environment=TransportConfig(horizon=5, observe=("goal", "place")))
    given = ("evaluate", tmp_path / "run/policy.zip", "--team", "4")
    (row,) = evaluated(*given, out=tmp_path / "table.csv")
    assert [name for name in row if name.startswith("force_load_share")][-1] == "force_load_share_3"
    assert "BeamTransport-v0 with team 4, observe goal place, horizon 5" in capsys.readouterr().out
    train(
        TrainConfig(control="shared", hidden=(4,), out=tmp_path / "pair", **run),
        environment=TransportConfig(horizon=5),
    )
    grown = ["evaluate", str(tmp_path / "pair/policy.zip"), "--team", "4", "--episodes=2"]
    assert cli.main(grown) != 0
    assert "must have the sizes the policy was trained on" in capsys.readouterr().err


def test_an_id_on_the_command_line_is_the_environment(files, tmp_path, capsys):
    ids = ("--env=coopenv/BeamTransport-v0", "--horizon=4")
    evaluated("evaluate", files[0], *ids, out=tmp_path / "table.csv")
    printed = capsys.readouterr().out
    assert "coopenv/BeamTransport-v0 with horizon 4, 2 episodes" in printed


def test_without_trained_policies_the_environment_is_the_default(tmp_path, capsys):
    evaluated("evaluate", "scripted", "--horizon=4", out=tmp_path / "table.csv")
    assert "coopenv/BeamTransport-v0 with horizon 4" in capsys.readouterr().out


def test_the_scripted_controller_moves_hands_where_the_actions_are_motions(tmp_path, capsys):
    options = ("--action=motion", "--hands", "stiffness=100")
    rows = evaluated("evaluate", "scripted", "random", *options, out=tmp_path / "table.csv")
    assert [float(row["success_rate"]) for row in rows] == [1.0, 0.0]
    assert float(rows[0]["relative_cost"]) < 1e-6
    assert "action motion" in capsys.readouterr().out


def bare(path: Path, to: Path) -> Path:
    """The policy as it was written before files said where they come from."""
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(to, "w") as made:
        for name in archive.namelist():
            if not name.startswith("coopenv"):
                made.writestr(name, archive.read(name))
    return to


def test_a_file_that_names_no_environment_is_evaluated_only_in_one_that_is_named(
    files, tmp_path, capsys
):
    old = bare(files[0], tmp_path / "old.zip")
    for options in ([], ["--horizon=4"]):
        assert cli.main(["evaluate", str(old), "--episodes=2", *options]) == 1
        assert "old.zip, which does not; give --env" in capsys.readouterr().err
    env = "--env=coopenv/BeamTransport-v0"
    assert cli.main(["evaluate", str(old), env, "--horizon=4", "--episodes=2"]) == 1
    assert "load it with trust=True (--trust)" in capsys.readouterr().err
    evaluated("evaluate", old, env, "--horizon=4", "--trust", out=tmp_path / "table.csv")
    assert "coopenv/BeamTransport-v0 with horizon 4" in capsys.readouterr().out


def test_an_older_file_is_evaluated_in_what_the_settings_beside_it_name(files, tmp_path, capsys):
    old = bare(files[0], tmp_path / "old.zip")
    settings = json.loads(files[0].with_name("config.json").read_text())
    del settings["provenance"]
    settings["environment"]["horizon"] = 6
    (tmp_path / "config.json").write_text(json.dumps(settings))
    evaluated("evaluate", old, "--trust", out=tmp_path / "table.csv")
    captured = capsys.readouterr()
    assert "config.json names" in captured.err
    assert "horizon 6" in captured.out


def test_a_bare_file_of_a_run_from_python_is_evaluated_in_what_the_run_records(
    files, tmp_path, capsys
):
    old = bare(files[1], tmp_path / "old.zip")
    beside = tmp_path / "config.json"
    beside.write_text(files[1].with_name("config.json").read_text())
    rows = evaluated("evaluate", old, "--trust", out=tmp_path / "table.csv")
    assert float(rows[0]["reward"]) == pytest.approx(-2.0 * 5 * 0.05)  # weight · steps · dt
    captured = capsys.readouterr()
    assert f"evaluated in coopenv/BeamTransport-v0, as {beside} records it" in captured.err
    assert "body.mass 20.0" in captured.out


def test_code_in_the_record_beside_a_bare_file_is_imported_only_with_trust(
    files, tmp_path, capsys, monkeypatch
):
    (tmp_path / "beside_rewards.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(str(tmp_path))
    settings = json.loads(files[1].with_name("config.json").read_text())
    term = {"kind": "beside_rewards:Mine", "sha256": "0", "fields": {"weight": 1.0}}
    settings["provenance"]["environment"]["reward"]["terms"][0]["term"] = term
    (tmp_path / "config.json").write_text(json.dumps(settings))
    old = bare(files[1], tmp_path / "old.zip")
    assert cli.main(["evaluate", str(old), "--episodes=2"]) == 1
    said = capsys.readouterr().err
    assert "--trust beside_rewards" in said
    assert "config.json" in said


def test_another_version_is_said_and_does_not_matter(files, tmp_path, capsys, monkeypatch):
    from coopenv.agents import provenance

    monkeypatch.setattr(provenance, "version", lambda name: "999.0" if name == "torch" else "1")
    evaluated("evaluate", files[0], out=tmp_path / "table.csv")
    assert "(now 999.0)" in capsys.readouterr().err


def test_code_of_ones_own_is_imported_only_if_trusted(tmp_path, monkeypatch, capsys):
    (tmp_path / "my_rewards.py").write_text(OWN_REWARD)
    monkeypatch.syspath_prepend(tmp_path)
    import my_rewards  # type: ignore[import-not-found]

    reward = RewardSum({"mine": my_rewards.Mine(weight=3.0)})
    path = trained(tmp_path / "own", TransportConfig(horizon=3, reward=reward))
    assert cli.main(["evaluate", str(path), "--episodes=2"]) == 1
    assert "--trust my_rewards" in capsys.readouterr().err
    rows = evaluated("evaluate", path, "--trust=my_rewards", out=tmp_path / "table.csv")
    assert float(rows[0]["reward"]) == pytest.approx(9.0)


def test_a_title_imports_no_module_that_is_not_trusted(tmp_path, monkeypatch):
    (tmp_path / "my_envs.py").write_text("raise SystemExit('imported')")
    monkeypatch.syspath_prepend(tmp_path)
    place = environments.Environment("my_envs:Mine-v0", TransportConfig())
    assert "not registered" in place.title()


@pytest.mark.parametrize("control", ["joint", "shared", "partner"])
def test_a_policy_that_a_program_of_ones_own_trained_runs_in_its_environment(
    control, tmp_path, capsys
):
    path = learned(make_vec_env(TransportConfig(horizon=3), 2, control=control), tmp_path)
    evaluated("evaluate", path, out=tmp_path / "table.csv")
    captured = capsys.readouterr()
    partner = ", partner impedance" if control == "partner" else ""
    assert f"coopenv/BeamTransport-v0 with horizon 3{partner}, 2 episodes" in captured.out
    assert not captured.err


def learned(venv: VecEnv, folder: Path) -> Path:
    """A policy of Stable-Baselines3 in a file of ours."""
    model: Any = PPO("MlpPolicy", venv, n_steps=4, batch_size=4, n_epochs=1, device="cpu")
    SB3Policy(model.learn(8)).save(folder / "mine.zip")
    return folder / "mine.zip"


def test_its_record_names_the_nearest_id_and_survives_wrappers_and_another_save(tmp_path):
    walker = find_config("coopenv/WalkerTurn-v0", {"horizon": 3})
    path = learned(VecNormalize(make_vec_env(walker, 2)), tmp_path)
    SB3Policy.load(path).save(tmp_path / "again.zip")
    for file in (path, tmp_path / "again.zip"):
        found = Provenance.read(file)
        assert found is not None
        assert (found.env, found.config()) == ("coopenv/WalkerTurn-v0", walker)
        assert found.training["control"] == "joint"


def test_an_environment_that_cannot_be_written_is_warned_of_and_costs_no_policy(tmp_path, capsys):
    @dataclass(frozen=True)
    class Local:
        weight: float = 1.0

        def __call__(self, transition: Any) -> np.ndarray:
            return np.zeros(transition.action.shape[:2])

    reward = RewardSum({"mine": Local()})
    with pytest.warns(UserWarning, match=r"reward\.mine.*coopenv evaluate needs --env"):
        path = learned(make_vec_env(TransportConfig(reward=reward), 2), tmp_path)
    assert SB3Policy.load(path).notes == {}
    assert cli.main(["evaluate", str(path), "--episodes=2"]) == 1
    assert "give --env" in capsys.readouterr().err


def test_the_table_of_a_training_says_what_is_not_the_default_as_well(tmp_path, capsys):
    tiny = ("--steps=64", "--num-worlds=4", "--rollout=8", "--hidden=4", "--episodes=1", "--no-gif")
    changed = ("--horizon=4", "--partner=stubborn", "--body", "mass=5")
    assert cli.main(["train", *tiny, *changed, f"--out={tmp_path}"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "coopenv/BeamTransport-v0 with body.mass 5" in said
    assert "horizon 4, partner stubborn, 1 episodes" in said
    assert "64 of 64 steps" in said
    assert cli.main(["train", *tiny, *changed, f"--out={tmp_path}"]) == 0
    assert "of 64 steps" not in capsys.readouterr().out  # it is finished: no bar stays at 0


def test_a_policy_that_is_named_twice_is_refused(capsys):
    assert cli.main(["evaluate", "scripted", "random", "scripted", "--episodes=1"]) == 1
    assert "policies must be named once each, got 'scripted' again" in capsys.readouterr().err


def test_a_folder_of_a_run_is_told_which_file_to_give(files, capsys):
    assert cli.main(["evaluate", str(files[0].parent)]) == 1
    assert f"give {str(files[0])!r}" in capsys.readouterr().err


@pytest.mark.skipif(not DESCRIPTORS.is_dir(), reason="the system does not list what is open")
def test_a_record_is_closed_before_it_is_removed_where_the_evaluation_breaks_off(
    tmp_path, monkeypatch
):
    def broken(*_: Any, recorder: Any, **__: Any) -> None:
        assert recorder is not None
        assert open_in(tmp_path)
        raise ArithmeticError

    monkeypatch.setattr("coopenv.agents.evaluate.evaluate", broken)
    with pytest.raises(ArithmeticError) as broken_off:
        cli.main(["evaluate", "random", "--record", str(tmp_path / "a.csv")])
    assert broken_off.tb is not None  # which keeps all alive that was in use
    assert not open_in(tmp_path)
    assert not list(tmp_path.iterdir())


def open_in(folder: Path) -> list[str]:
    """Files of a folder that this process has open."""
    names = []
    for each in DESCRIPTORS.iterdir():
        with suppress(OSError):
            names.append(str(each.readlink()))
    return [name for name in names if name.startswith(str(folder))]
