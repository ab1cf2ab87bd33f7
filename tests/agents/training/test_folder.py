"""A run's folder: nothing in it that no run wrote is removed or written over."""

import json
from pathlib import Path

import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")
pytest.importorskip("tyro")

from stable_baselines3 import PPO

from coopenv import cli
from coopenv.agents.sb3 import SB3Policy, make_vec_env
from coopenv.agents.train import train
from coopenv.errors import InvalidInput
from tests.agents.training.cases import SHORT, tiny

MINE = "somebody's own"


def put(folder: Path, *names: str, text: str = MINE) -> list[Path]:
    paths = [folder / name for name in names]
    for path in paths:
        path.write_text(text)
    return paths


@pytest.mark.parametrize("fresh", [False, True])
@pytest.mark.parametrize(
    "names", [("config.json", "curves.csv", "table.csv", "episode.gif"), ("table.csv",)]
)
def test_files_that_no_run_wrote_are_neither_removed_nor_written_over(names, fresh, tmp_path):
    paths = put(tmp_path, *names)
    with pytest.raises(InvalidInput, match=rf"{', '.join(names)} that no run wrote.* move it away"):
        train(tiny(tmp_path, steps=64, fresh=fresh), environment=SHORT)
    assert [path.read_text() for path in paths] == [MINE] * len(paths)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


@pytest.mark.parametrize("text", ["{}", "[]", '{"steps": 20000}', '{"colour": "red"}', "{"])
def test_a_config_json_that_is_not_of_a_run_is_not_written_over(text, tmp_path, capsys):
    (path,) = put(tmp_path, "config.json", text=text)
    tiny = ["--steps=64", "--num-worlds=4", "--rollout=8", "--episodes=1", "--no-gif"]
    for fresh in ([], ["--fresh"]):
        assert cli.main(["train", *tiny, f"--out={tmp_path}", *fresh]) == 1
        assert "config.json that no run wrote; choose another out" in capsys.readouterr().err
    assert path.read_text() == text


@pytest.mark.parametrize("fresh", [False, True])
def test_a_policy_that_no_run_wrote_is_neither_removed_nor_written_over(fresh, tmp_path):
    venv = make_vec_env(SHORT, 2)
    model = PPO("MlpPolicy", venv, n_steps=8, batch_size=16, policy_kwargs={"net_arch": [8]})
    SB3Policy(model).save(tmp_path / "policy.zip")
    put(tmp_path, "config.json")
    before = (tmp_path / "policy.zip").read_bytes()
    with pytest.raises(InvalidInput, match=r"holds config\.json.* that no run wrote"):
        train(tiny(tmp_path, steps=64, fresh=fresh), environment=SHORT)
    (tmp_path / "config.json").unlink()
    with pytest.raises(InvalidInput, match="policy"):
        train(tiny(tmp_path, steps=64, fresh=fresh), environment=SHORT)
    assert (tmp_path / "policy.zip").read_bytes() == before


def test_settings_that_a_run_left_show_it_before_its_first_checkpoint(tmp_path):
    def stop(row):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="before the first update"):
        train(tiny(tmp_path, steps=64), environment=SHORT, report=stop)
    assert not (tmp_path / "checkpoint.zip").exists()
    put(tmp_path, "table.csv")
    with pytest.raises(KeyboardInterrupt):
        train(tiny(tmp_path, steps=64, fresh=True, seed=1), environment=SHORT, report=stop)
    assert not (tmp_path / "table.csv").exists()
    assert json.loads((tmp_path / "config.json").read_text())["seed"] == 1
    train(tiny(tmp_path, steps=64, seed=1), environment=SHORT)


def test_fresh_leaves_logs_where_nothing_shows_a_run(tmp_path):
    log = tmp_path / "tensorboard" / "ppo_1" / "events.out.tfevents.0"
    log.parent.mkdir(parents=True)
    log.write_text(MINE)
    train(tiny(tmp_path, steps=64, fresh=True), environment=SHORT)
    assert log.read_text() == MINE
