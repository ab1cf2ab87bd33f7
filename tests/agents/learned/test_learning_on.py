"""A policy whose model learns on says the environment and the statistics it learned with last."""

import warnings
from dataclasses import replace

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from coopenv import TransportConfig
from coopenv.agents.evaluate import evaluate
from coopenv.agents.provenance import Provenance
from coopenv.agents.sb3 import SB3Policy, TransportVecEnv, make_vec_env
from coopenv.errors import InvalidInput
from tests.agents.learned.cases import CONFIG, normalized, small, start, trained

OTHER = replace(CONFIG, horizon=7, reward="harmony")


def in_other() -> TransportVecEnv:
    return make_vec_env(OTHER, 2, seed=3)


def recorded(path) -> TransportConfig | None:
    found = Provenance.read(path)
    return None if found is None else found.config()


@pytest.fixture
def saved(tmp_path):
    """A policy that was trained without normalisation."""
    SB3Policy(trained("PPO", small())).save(tmp_path / "first.zip")
    return tmp_path / "first.zip"


def learn_on(model: BaseAlgorithm, venv) -> None:
    model.set_env(venv)
    model.learn(8)


def test_a_loaded_policy_that_learns_on_is_saved_with_its_new_environment(saved, tmp_path):
    policy = SB3Policy.load(saved)
    policy.model.set_env(in_other())
    policy.save(tmp_path / "untouched.zip")
    assert recorded(tmp_path / "untouched.zip") == CONFIG
    policy.model.learn(8)
    policy.save(tmp_path / "second.zip")
    assert recorded(tmp_path / "second.zip") == OTHER


def test_a_record_stays_word_for_word_while_its_environment_is_the_same(saved, tmp_path):
    policy = SB3Policy.load(saved)
    policy.notes["provenance"]["command"] = ["long", "ago"]
    learn_on(policy.model, small())
    policy.save(tmp_path / "second.zip")
    found = Provenance.read(tmp_path / "second.zip")
    assert found is not None
    assert found.command == ["long", "ago"]
    assert found.config() == CONFIG


def test_a_loaded_policy_that_learns_on_behind_a_normalisation_has_its_statistics(saved, tmp_path):
    policy = SB3Policy.load(saved)
    venv = normalized()
    policy.model.set_env(venv)
    assert policy.normalization is None  # nothing was learned behind it yet
    policy.model.learn(8)
    found = policy.normalization
    assert found is not None
    np.testing.assert_array_equal(found.mean, venv.obs_rms.mean)  # type: ignore[union-attr]
    drawn = policy.sampled()
    assert drawn is not None
    assert drawn.normalization is not None
    policy.save(tmp_path / "second.zip")
    loaded = SB3Policy.load(tmp_path / "second.zip")
    np.testing.assert_array_equal(loaded(*start()), policy(*start()))
    assert loaded.normalization is not None


def test_statistics_of_a_file_give_way_to_those_of_the_training_that_goes_on(tmp_path):
    SB3Policy(trained("PPO", normalized())).save(tmp_path / "first.zip")
    policy = SB3Policy.load(tmp_path / "first.zip")
    venv = VecNormalize(in_other())
    learn_on(policy.model, venv)
    assert policy.normalization is not None
    np.testing.assert_array_equal(policy.normalization.mean, venv.obs_rms.mean)  # type: ignore[union-attr]
    plain = SB3Policy.load(tmp_path / "first.zip")
    learn_on(plain.model, small())
    assert plain.normalization is None
    given = SB3Policy.load(tmp_path / "first.zip", normalize=False)
    learn_on(given.model, VecNormalize(small()))
    assert given.normalization is not None


def test_what_a_model_learned_in_last_is_not_known_once_it_has_another_environment(saved, tmp_path):
    policy = SB3Policy.load(saved)
    learn_on(policy.model, in_other())
    policy.model.set_env(small())
    with pytest.warns(UserWarning, match="given another one since it learned"):
        policy.save(tmp_path / "second.zip")
    assert recorded(tmp_path / "second.zip") is None
    behind = SB3Policy.load(saved)
    learn_on(behind.model, normalized())
    behind.model.set_env(small())
    with pytest.raises(InvalidInput, match="normalize must be given"):
        _ = behind.normalization
    SB3Policy(trained("PPO", normalized())).save(tmp_path / "normalized.zip")
    plain = SB3Policy.load(tmp_path / "normalized.zip")
    learn_on(plain.model, small())
    assert plain.normalization is None
    plain.model.set_env(in_other())
    with pytest.raises(InvalidInput, match="normalize must be given"):
        _ = plain.normalization


def test_statistics_given_alive_are_those_of_the_moment():
    venv = normalized()
    model = trained("PPO", venv)
    policy = SB3Policy(model, normalize=venv)
    model.learn(64)
    assert policy.normalization is not None
    np.testing.assert_array_equal(policy.normalization.mean, venv.obs_rms.mean)  # type: ignore[union-attr]


def test_statistics_that_are_given_hold_in_the_environment_they_are_given_for():
    venv = normalized()
    model = trained("PPO", venv)
    policy = SB3Policy(model, normalize=False)
    model.learn(8)
    assert policy.normalization is None


def test_an_environment_that_a_model_has_only_been_given_is_not_called_that_of_its_training(
    tmp_path,
):
    model = trained("PPO", small())
    model.set_env(in_other())
    with pytest.warns(UserWarning, match=r"given another one since it learned .*venv\.to_notes"):
        SB3Policy(model).save(tmp_path / "policy.zip")
    assert recorded(tmp_path / "policy.zip") is None
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        SB3Policy(model, notes=small().to_notes()).save(tmp_path / "said.zip")
    assert recorded(tmp_path / "said.zip") == CONFIG


def test_what_is_learned_where_nothing_is_recorded_is_under_no_old_record(saved, tmp_path):
    policy = SB3Policy.load(saved)
    policy.notes["mine"] = 3
    single = [lambda: gymnasium.make("coopenv/BeamTransport-v0", **vars_of(CONFIG))] * 2
    learn_on(policy.model, DummyVecEnv(single))
    with pytest.warns(UserWarning, match="learned on in one that does not say what it is"):
        policy.save(tmp_path / "second.zip")
    assert recorded(tmp_path / "second.zip") is None
    assert SB3Policy.load(tmp_path / "second.zip").notes == {"mine": 3}


def vars_of(config: TransportConfig) -> dict:
    return {"task": config.task, "horizon": config.horizon}


def test_blocks_are_checked_against_the_environment_it_learned_in_last(tmp_path):
    seen = replace(CONFIG, observe=("goal", "twist", "own_wrench"))
    turned = replace(CONFIG, observe=("twist", "goal", "own_wrench"))
    SB3Policy(trained("PPO", make_vec_env(seen, 2))).save(tmp_path / "policy.zip")
    policy = SB3Policy.load(tmp_path / "policy.zip")
    learn_on(policy.model, make_vec_env(turned, 2))
    assert evaluate(policy, turned, episodes=2).episodes == 2
    with pytest.raises(InvalidInput, match="trained on, twist goal own_wrench, got goal"):
        evaluate(policy, seen, episodes=2)
