"""Going on with a run: after a kill, after an interruption, after its end."""

import csv
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

import torch
from stable_baselines3 import PPO

from coopenv.agents.sb3 import FallingRate
from coopenv.agents.settings import TrainConfig
from coopenv.agents.train import train
from coopenv.agents.training.checkpoint import Checkpoint, Keeper
from coopenv.agents.training.progress import Progress, Watch, episode_means
from coopenv.errors import InvalidInput
from tests.agents.training.cases import SHORT, tiny


def weights(model) -> dict[str, np.ndarray]:
    return {name: value.numpy().copy() for name, value in model.policy.state_dict().items()}


def stop_at(steps: int):
    """A report that interrupts when the rollout that ends at ``steps`` is reported."""

    def report(row):
        if row["steps"] == steps:
            raise KeyboardInterrupt

    return report


def curves(out: Path) -> list[dict[str, str]]:
    with (out / "curves.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def interrupt_updates(monkeypatch, at: int):
    """Let the optimiser be interrupted in its ``at``-th step, with half of the weights changed."""
    count = 0
    original = torch.optim.Adam.step

    def step(self, *arguments, **keywords):
        nonlocal count
        count += 1
        if count == at:
            for group in self.param_groups:
                for parameter in group["params"][::2]:
                    parameter.data.fill_(7.0)
            raise KeyboardInterrupt
        return original(self, *arguments, **keywords)

    monkeypatch.setattr(torch.optim.Adam, "step", step)


def test_an_interruption_leaves_a_checkpoint_and_says_where_the_run_goes_on(tmp_path):
    config = tiny(tmp_path, checkpoint_every=1000)
    with pytest.raises(KeyboardInterrupt, match="holds 64 of 128 steps"):
        train(config, environment=SHORT, report=stop_at(96))
    assert [row["steps"] for row in curves(tmp_path)] == ["32", "64"]
    said, rows = [], []
    train(config, environment=SHORT, report=rows.append, tell=said.append)
    assert [row["steps"] for row in rows] == [96, 128]
    assert len(said) == 1
    assert "at 64 of 128 steps" in said[0]


def test_an_update_that_is_broken_off_leaves_no_torn_policy(tmp_path, monkeypatch):
    config = tiny(tmp_path, checkpoint_every=1000)
    seen = []
    original = PPO.train
    with monkeypatch.context() as patch:
        patch.setattr(PPO, "train", lambda self: (original(self), seen.append(weights(self)))[0])
        interrupt_updates(patch, at=5)  # two steps an update: in the third
        with pytest.raises(KeyboardInterrupt, match="holds 64 of 128 steps"):
            train(config, environment=SHORT)
    kept = weights(PPO.load(tmp_path / "checkpoint.zip", device="cpu"))
    assert len(seen) == 2
    for name, value in seen[-1].items():
        np.testing.assert_array_equal(kept[name], value)
    assert train(config, environment=SHORT).model.num_timesteps == 128


def test_an_interruption_before_the_first_update_begins_anew(tmp_path):
    config = tiny(tmp_path)
    with pytest.raises(KeyboardInterrupt, match="before the first update"):
        train(config, environment=SHORT, report=stop_at(32))
    assert not (tmp_path / "checkpoint.zip").exists()
    again = weights(train(config, environment=SHORT).model)
    straight = weights(train(replace(config, out=tmp_path / "b"), environment=SHORT).model)
    for name, value in straight.items():
        np.testing.assert_array_equal(again[name], value)


def test_an_interruption_while_a_checkpoint_is_written_leaves_the_one_before(tmp_path, monkeypatch):
    config = tiny(tmp_path, checkpoint_every=1)
    original = PPO.save

    def torn(self, file, *arguments, **keywords):
        if self.num_timesteps >= 96:
            file.write(b"half of a file")
            raise KeyboardInterrupt
        return original(self, file, *arguments, **keywords)

    with monkeypatch.context() as patch:
        patch.setattr(PPO, "save", torn)
        with pytest.raises(KeyboardInterrupt):
            train(config, environment=SHORT)
    assert Checkpoint.read(tmp_path / "checkpoint.zip").progress.steps == 64
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
    train(config, environment=SHORT)
    assert [row["steps"] for row in curves(tmp_path)] == ["32", "64", "96", "128"]


def test_the_window_of_ended_episodes_belongs_to_the_checkpoint(tmp_path):
    config = tiny(tmp_path, steps=512, checkpoint_every=1)
    long = replace(SHORT, horizon=16)  # two rollouts
    rows = []

    def stopped(row):
        rows.append(row)
        if row["steps"] == 192:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(config, environment=long, report=stopped)
    before = Checkpoint.read(tmp_path / "checkpoint.zip").progress
    assert before.rows == rows[:-1]
    assert sum(len(ended) for ended in before.window) > 0
    later = []
    train(config, environment=long, report=later.append)
    shown = [{**row, "steps": 0} for row in (before.rows[-1], *later)]
    assert shown[1] == shown[0]  # none but short episodes can have ended
    assert shown[2] != shown[0]
    assert shown[2]["episodes"] == config.num_worlds


def test_success_does_not_jump_where_a_run_goes_on(tmp_path):
    """Nine episodes of ten end soon and with success, the others at the horizon without."""
    horizon, rollout, worlds = 200, 128, 400
    generator = np.random.default_rng(0)

    def run(progress: Progress, rollouts: int) -> list[float]:
        watch = Watch(
            progress,
            horizon=horizon,
            rollout=rollout,
            per_step=1,
            begin=lambda model: None,
            report=lambda row: None,
        )
        watch.init_callback(cast(PPO, _Model()))
        succeeds, left = generator.random(worlds) < 0.9, np.zeros(worlds, dtype=int)
        left[:] = np.where(succeeds, 40, horizon)
        for _ in range(rollouts):
            watch.on_rollout_start()
            for _ in range(rollout):
                left -= 1
                ended = np.flatnonzero(left == 0)
                infos = [_info(bool(succeeds[k])) if k in ended else {} for k in range(worlds)]
                watch.locals = {"infos": infos}
                watch.num_timesteps += worlds
                watch._on_step()
                succeeds[ended] = generator.random(len(ended)) < 0.9
                left[ended] = np.where(succeeds[ended], 40, horizon)
            watch.on_rollout_end()
        return [row["success"] for row in progress.rows[-rollouts:]]

    progress = Progress()
    assert np.mean(run(progress, 8)[2:]) == pytest.approx(0.9, abs=0.02)
    for _ in range(3):
        for success in run(progress, 6):
            assert success == pytest.approx(0.9, abs=0.04)


class _Logger:
    def record(self, name: str, value: float) -> None:
        pass


class _Model:
    logger, num_timesteps = _Logger(), 0

    def get_env(self) -> None:
        return None


def _info(success: bool) -> dict:
    return {"episode": {"r": 0.0, "l": 40, "t": 0.0}, "is_success": success}


def test_curves_keep_their_history_and_never_run_backwards(tmp_path):
    config = tiny(tmp_path, steps=320)
    for steps in (96, 160, 256):
        with pytest.raises(KeyboardInterrupt):
            train(config, environment=SHORT, report=stop_at(steps))
        assert (tmp_path / "curves.csv").exists()
    train(config, environment=SHORT)
    assert [int(row["steps"]) for row in curves(tmp_path)] == [*range(32, 321, 32)]


def test_a_finished_run_is_returned_and_not_trained_anew(tmp_path):
    config = tiny(tmp_path)
    first = train(config, environment=SHORT)
    written = (tmp_path / "policy.zip").read_bytes()
    (tmp_path / "curves.csv").unlink()
    said, rows = [], []
    again = train(config, environment=SHORT, report=rows.append, tell=said.append)
    assert not rows
    assert len(said) == 1
    assert "has done its 128 steps" in said[0]
    assert "--fresh" in said[0]
    assert (tmp_path / "policy.zip").read_bytes() == written
    assert len(curves(tmp_path)) == 4
    for name, value in weights(first.model).items():
        np.testing.assert_array_equal(weights(again.model)[name], value)


def test_a_finished_run_of_another_configuration_is_not_overwritten(tmp_path):
    train(tiny(tmp_path), environment=SHORT)
    written = (tmp_path / "policy.zip").read_bytes()
    with pytest.raises(InvalidInput, match=r"policy\.zip.*epochs.*fresh"):
        train(tiny(tmp_path, epochs=2), environment=SHORT)
    assert (tmp_path / "policy.zip").read_bytes() == written


@pytest.mark.parametrize("name", ["policy.zip", "checkpoint.zip"])
def test_a_file_that_says_no_run_is_neither_taken_nor_overwritten(tmp_path, name):
    path = tmp_path / name
    for content in (b"", b"PK\x03\x04 torn", b"no zip at all"):
        path.write_bytes(content)
        with pytest.raises(InvalidInput, match=f"{name}.*fresh"):
            train(tiny(tmp_path), environment=SHORT)
        assert path.read_bytes() == content
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("data", "{}")
    with pytest.raises(InvalidInput, match=f"{name}.*fresh"):
        train(tiny(tmp_path), environment=SHORT)
    train(tiny(tmp_path, fresh=True), environment=SHORT)


def test_fresh_removes_the_run_that_was_there(tmp_path):
    train(tiny(tmp_path), environment=SHORT)
    with pytest.raises(KeyboardInterrupt):
        train(tiny(tmp_path, fresh=True), environment=SHORT, report=stop_at(32))
    assert not (tmp_path / "policy.zip").exists()
    rows = []
    train(tiny(tmp_path), environment=SHORT, report=rows.append)
    assert rows[0]["steps"] == 32


def test_fresh_removes_all_that_the_run_wrote_and_nothing_else(tmp_path):
    train(tiny(tmp_path), environment=SHORT)
    (old,) = (tmp_path / "tensorboard").glob("*/events*")
    of_command = [tmp_path / name for name in ("table.csv", "table.json", "episode.gif")]
    others = [tmp_path / "notes.txt", tmp_path / "tensorboard" / "mine.txt"]
    for path in (*of_command, *others):
        path.write_text("of before")
    with pytest.raises(KeyboardInterrupt):
        train(tiny(tmp_path, fresh=True), environment=SHORT, report=stop_at(32))
    assert not [path for path in of_command if path.exists()]
    assert not old.exists()
    assert len(list((tmp_path / "tensorboard").glob("*/events*"))) == 1
    assert [path.read_text() for path in others] == ["of before"] * 2


@pytest.mark.parametrize("fresh", ["no", "yes", 1, 0, None])
def test_fresh_is_true_or_false_and_nothing_else(fresh, tmp_path):
    with pytest.raises(InvalidInput, match="fresh must be True or False"):
        tiny(tmp_path, fresh=fresh)


def test_an_interrupted_fresh_run_says_that_it_goes_on_without_fresh(tmp_path):
    with pytest.raises(KeyboardInterrupt, match="again without --fresh to go on"):
        train(tiny(tmp_path, fresh=True), environment=SHORT, report=stop_at(96))


def test_more_steps_go_on_from_the_end_of_a_finished_run(tmp_path):
    train(tiny(tmp_path), environment=SHORT)
    said, rows, left = [], [], []
    original = FallingRate.__call__
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            FallingRate,
            "__call__",
            lambda self, remaining: (left.append(remaining), original(self, remaining))[1],
        )
        train(tiny(tmp_path, steps=256), environment=SHORT, report=rows.append, tell=said.append)
    assert [row["steps"] for row in rows] == [160, 192, 224, 256]
    assert "at 128 of 256 steps" in said[0]
    assert [*dict.fromkeys(left)][-4:] == [96 / 256, 64 / 256, 32 / 256, 0.0]
    assert [int(row["steps"]) for row in curves(tmp_path)] == [*range(32, 257, 32)]
    assert TrainConfig.load(tmp_path / "config.json").steps == 256


def test_an_interrupted_continuation_goes_on_from_where_it_was(tmp_path):
    train(tiny(tmp_path), environment=SHORT)
    longer = tiny(tmp_path, steps=256)
    with pytest.raises(KeyboardInterrupt, match="holds 192 of 256"):
        train(longer, environment=SHORT, report=stop_at(224))
    with pytest.raises(InvalidInput, match=r"steps must be at least the 192.*128"):
        train(tiny(tmp_path), environment=SHORT)
    rows = []
    train(longer, environment=SHORT, report=rows.append)
    assert [row["steps"] for row in rows] == [224, 256]


def test_fewer_steps_than_a_run_has_done_are_refused(tmp_path):
    train(tiny(tmp_path), environment=SHORT)
    with pytest.raises(InvalidInput, match=r"steps must be at least the 128 .* got 64"):
        train(tiny(tmp_path, steps=64), environment=SHORT)


def test_a_folder_that_was_moved_keeps_its_logs_together(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        train(tiny(tmp_path / "a"), environment=SHORT, report=stop_at(96))
    (tmp_path / "a").rename(tmp_path / "b")
    train(tiny(tmp_path / "b"), environment=SHORT)
    assert not (tmp_path / "a").exists()
    assert len(list((tmp_path / "b" / "tensorboard").glob("*/events*"))) == 2


def test_the_learning_rate_never_turns_negative_in_a_rollout_beyond_the_end(tmp_path):
    policy = train(tiny(tmp_path, steps=97), environment=SHORT)
    assert policy.model.num_timesteps == 128
    assert policy.model.policy.optimizer.param_groups[0]["lr"] == 0.0


def test_a_run_of_one_rollout_is_refused():
    with pytest.raises(InvalidInput, match=r"steps must be more than the 8,192 .* got 1,000"):
        TrainConfig(steps=1000)


def test_a_mean_is_over_the_episodes_in_which_it_is_defined():
    ended = [{"success": 1.0, "load_imbalance": 0.5}, {"success": 0.0}]
    assert episode_means(ended) == {"episodes": 2, "success": 0.5, "load_imbalance": 0.5}
    assert episode_means([]) == {}


def test_before_the_first_update_there_is_nothing_to_write(tmp_path):
    keeper = Keeper(tmp_path, cast(Any, None), Progress(steps=7), every=1)
    assert keeper.write_kept(cast(Any, None)) == 7
    assert not list(tmp_path.iterdir())
