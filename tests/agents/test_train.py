"""Training: files, resuming after a kill, reproducibility, and (slow) what is learned."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("matplotlib")

import torch
from stable_baselines3 import PPO

from coopenv import TransportConfig
from coopenv.agents import curves
from coopenv.agents.curves import PANELS
from coopenv.agents.environment import find_config
from coopenv.agents.evaluate import evaluate
from coopenv.agents.partners import Stubborn
from coopenv.agents.seeds import HELD_OUT, training_seeds
from coopenv.agents.settings import EnvironmentChoice, TrainConfig
from coopenv.agents.train import train
from coopenv.errors import InvalidInput, UnknownName
from tests.agents.training.cases import SHORT, tiny


def weights(policy) -> list[np.ndarray]:
    return [value.numpy().copy() for value in policy.model.policy.state_dict().values()]


def test_a_run_leaves_policy_configuration_curves_and_logs(tmp_path, undrawn, monkeypatch):
    monkeypatch.setattr(curves, "draw", undrawn)
    config = tiny(tmp_path, environment=EnvironmentChoice(reward="harmony"))
    rows = []
    train(config, environment=replace(SHORT, reward="harmony"), report=rows.append)
    assert [row["steps"] for row in rows] == [32, 64, 96, 128]
    assert {"success", "reward", "relative_cost", "load_imbalance", "internal_force_level"} <= set(
        rows[0]
    )
    assert {name for panel in PANELS.values() for name in panel} <= set(rows[0])
    assert any("wasted_cost" in panel for panel in PANELS.values())
    assert {"reward/progress", "reward/relative_cost"} <= set(rows[0])
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"policy.zip", "config.json", "curves.csv", "curves.png", "tensorboard"}
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")
    assert len((tmp_path / "curves.csv").read_text().splitlines()) == 5
    assert list((tmp_path / "tensorboard").glob("*/events*"))
    assert TrainConfig.load(tmp_path / "config.json") == config
    assert PPO.load(tmp_path / "policy.zip").num_timesteps == 128


def test_curves_tell_the_cost_of_an_environment_that_has_one(tmp_path, undrawn, monkeypatch):
    monkeypatch.setattr(curves, "draw", undrawn)
    rows = []
    train(tiny(tmp_path), environment=replace(SHORT, cost="waste"), report=rows.append)
    assert [row["episodes"] for row in rows] == [4, 4, 4, 4]
    assert all(row["cost"] > 0 for row in rows)


def test_the_same_seed_gives_the_same_policy_and_another_one_another(tmp_path):
    first = weights(train(tiny(tmp_path / "a"), environment=SHORT))
    second = weights(train(tiny(tmp_path / "b"), environment=SHORT))
    other = weights(train(tiny(tmp_path / "c", seed=1), environment=SHORT))
    for mine, theirs in zip(first, second, strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert any(not np.array_equal(a, b) for a, b in zip(first, other, strict=True))


def test_a_killed_run_goes_on_from_its_last_checkpoint(tmp_path):
    config = tiny(tmp_path, checkpoint_every=1)
    rows = []

    def killed(row):
        rows.append(row)
        if len(rows) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(config, environment=SHORT, report=killed)
    assert (tmp_path / "checkpoint.zip").exists()
    assert not (tmp_path / "policy.zip").exists()
    later = []
    policy = train(config, environment=SHORT, report=later.append)
    assert [row["steps"] for row in later] == [96, 128]  # the third rollout was lost
    assert policy.model.num_timesteps == 128
    assert len((tmp_path / "curves.csv").read_text().splitlines()) == 5
    assert not (tmp_path / "checkpoint.zip").exists()


def test_a_resumed_run_does_not_repeat_the_episodes_it_began_with(tmp_path):
    config = tiny(tmp_path, checkpoint_every=1)

    def killed(row):
        if row["steps"] == 64:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(config, environment=SHORT, report=killed)
    begun = []
    original = PPO.set_random_seed
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            PPO,
            "set_random_seed",
            lambda self, seed=None: begun.append(seed) or original(self, seed),
        )
        train(config, environment=SHORT)
    assert begun[-1] == config.seed + 32


def test_a_checkpoint_of_another_run_is_refused_and_fresh_starts_over(tmp_path):
    def killed(row):
        if row["steps"] == 64:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(tiny(tmp_path, checkpoint_every=1), environment=SHORT, report=killed)
    other = tiny(tmp_path, epochs=2)
    with pytest.raises(InvalidInput, match=r"epochs.*fresh"):
        train(other, environment=SHORT)
    rows = []
    train(replace(other, fresh=True), environment=SHORT, report=rows.append)
    assert rows[0]["steps"] == 32


def test_shared_control_counts_control_steps_and_runs_every_agent(tmp_path):
    rows = []
    policy = train(tiny(tmp_path, control="shared"), environment=SHORT, report=rows.append)
    assert rows[-1]["steps"] == 128
    assert policy.model.num_timesteps == 256
    assert evaluate(policy, SHORT, episodes=3).episodes == 3


def test_partner_control_trains_the_one_who_is_left(tmp_path):
    config = tiny(tmp_path, control="partner")
    assert config.environment.partner == "impedance"  # somebody has to be there
    environment = replace(config.environment.config(), horizon=8)
    rows = []
    policy = train(config, environment=environment, report=rows.append)
    assert policy.model.num_timesteps == rows[-1]["steps"] == 128
    assert policy.model.observation_space.shape == (22,)
    assert evaluate(policy, environment, episodes=3).episodes == 3
    assert TrainConfig.load(tmp_path / "config.json") == config


def test_training_warns_of_nothing_and_gives_the_threads_back(tmp_path):
    before = torch.get_num_threads()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        train(tiny(tmp_path, threads=1), environment=SHORT)
    assert torch.get_num_threads() == before


def test_worlds_are_seeded_from_the_block_of_the_run(tmp_path, monkeypatch):
    from coopenv.agents.sb3 import TransportVecEnv

    seeds = []
    original = TransportVecEnv.seed
    monkeypatch.setattr(
        TransportVecEnv, "seed", lambda self, seed=None: seeds.append(seed) or original(self, seed)
    )
    train(tiny(tmp_path, seed=3), environment=SHORT)
    assert seeds[-1] == training_seeds(3, 4)[0] < HELD_OUT


def test_a_configuration_survives_json_and_refuses_nonsense(tmp_path):
    config = TrainConfig(
        environment=EnvironmentChoice(observe=("goal", "twist"), action="force"), hidden=(3, 4)
    )
    config.save(tmp_path / "config.json")
    assert TrainConfig.load(tmp_path / "config.json") == config
    (tmp_path / "config.json").write_text(json.dumps({"stepz": 3}))
    with pytest.raises(UnknownName, match="steps"):
        TrainConfig.load(tmp_path / "config.json")
    for wrong in ({"steps": 0}, {"num_worlds": 1.5}, {"discount": 1.1}, {"learning_rate": -1.0}):
        with pytest.raises(InvalidInput, match=next(iter(wrong))):
            replace(config, **wrong)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"gae_lambda": 0.0}, "gae_lambda must be above 0 and at most 1, got 0.0"),
        ({"discount": 1.5}, "discount must be above 0 and at most 1, got 1.5"),
        ({"hidden": ()}, "hidden must be sizes of layers, got none"),
    ],
)
def test_a_number_without_a_unit_is_refused_without_talk_of_units(wrong, says):
    with pytest.raises(InvalidInput, match=says) as refused:
        TrainConfig(**wrong)
    assert "SI" not in str(refused.value)


def test_a_choice_changes_only_what_it_names():
    assert find_config("coopenv/BeamTransport-v0", {}) == EnvironmentChoice().config()
    chosen = EnvironmentChoice(reward="harmony", observe=("goal",), action="force").config()
    assert "relative_cost" in chosen.reward
    assert chosen.observe == ("goal",)
    assert chosen.action == "force"
    assert EnvironmentChoice(partner="stubborn").config().partner == Stubborn()
    assert chosen.horizon == TransportConfig().horizon


@pytest.mark.slow
def test_three_seeds_learn_to_carry_and_harmony_halves_the_relative_cost(tmp_path):
    from benchmarks.learning.presets import Study, mean_relative_cost, run

    seen = run(Study(out=tmp_path))
    assert len(seen) == 6
    for one in seen:
        assert one.success_rate >= 0.98, one
    assert mean_relative_cost(seen, "harmony") <= 0.5 * mean_relative_cost(seen, "task")
