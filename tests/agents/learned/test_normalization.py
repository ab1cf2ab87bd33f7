"""Policies that were trained behind a VecNormalize: never evaluated without it."""

import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from coopenv.agents.sb3 import SB3Policy
from coopenv.errors import InvalidInput
from tests.agents.learned.cases import ALGORITHMS, normalized, small, start, trained


def wanted(model, venv, obs):
    """What SB3's own loop would do: normalise, predict."""
    rows = obs.reshape(-1, model.observation_space.shape[0])
    action, _ = model.predict(venv.normalize_obs(rows), deterministic=True)
    return action.reshape(*obs.shape[:2], -1)


@pytest.mark.parametrize("control", ["joint", "shared"])
def test_statistics_travel_with_model_and_file(control, tmp_path):
    venv = normalized(control)
    model = trained("PPO", venv)
    policy = SB3Policy(model)
    obs, transition = start()
    expected = wanted(model, venv, obs)
    np.testing.assert_array_equal(policy(obs, transition), expected)
    policy.save(tmp_path / "policy.zip")
    loaded = SB3Policy.load(tmp_path / "policy.zip")
    np.testing.assert_array_equal(loaded(obs, transition), expected)
    loaded.save(tmp_path / "again.zip")
    again = SB3Policy.load(tmp_path / "again.zip")
    np.testing.assert_array_equal(again(obs, transition), expected)
    assert not np.allclose(SB3Policy(model, normalize=False)(obs, transition), expected)


def test_statistics_are_found_below_other_wrappers_and_followed_while_they_change():
    venv = normalized()
    model = trained("PPO", VecMonitor(venv))
    policy = SB3Policy(model)
    obs, transition = start()
    before = policy(obs, transition)
    venv.obs_rms.mean = venv.obs_rms.mean + 1.0  # type: ignore[union-attr, operator]
    after = policy(obs, transition)
    np.testing.assert_array_equal(after, wanted(model, venv, obs))
    assert not np.allclose(before, after)


def test_statistics_are_stored_as_plain_numbers(tmp_path):
    SB3Policy(trained("PPO", normalized())).save(tmp_path / "policy.zip")
    with (
        zipfile.ZipFile(tmp_path / "policy.zip") as archive,
        archive.open("normalization.npz") as member,
        np.load(member, allow_pickle=False) as arrays,
    ):
        assert set(arrays) == {"mean", "variance", "epsilon", "clip"}
        assert arrays["mean"].shape == (44,)


@pytest.mark.parametrize("name", ALGORITHMS)
def test_a_file_of_sb3_from_a_normalised_training_is_refused_without_statistics(name, tmp_path):
    venv = normalized()
    model = trained(name, venv)
    model.save(tmp_path / "model.zip")
    with pytest.raises(InvalidInput, match=r"that was trained behind a VecNormalize.*model\.zip"):
        SB3Policy.load(tmp_path / "model.zip", trust=True)
    venv.save(str(tmp_path / "vecnormalize.pkl"))
    with pytest.raises(InvalidInput, match=r"vecnormalize\.pkl' for example"):
        SB3Policy.load(tmp_path / "model.zip", trust=True)
    statistics = tmp_path / "vecnormalize.pkl"
    policy = SB3Policy.load(tmp_path / "model.zip", normalize=statistics, trust=True)
    obs, transition = start()
    np.testing.assert_allclose(policy(obs, transition), wanted(model, venv, obs), atol=1e-6)


def test_a_model_that_has_lost_its_normalised_environment_is_refused(tmp_path):
    venv = normalized()
    trained("PPO", venv).save(tmp_path / "model.zip")
    with pytest.raises(InvalidInput, match="normalize must be given"):
        SB3Policy(PPO.load(tmp_path / "model.zip"))
    with pytest.raises(InvalidInput, match="normalize must be given"):
        SB3Policy(PPO.load(tmp_path / "model.zip", env=small()))
    model = PPO.load(tmp_path / "model.zip")
    obs, transition = start()
    action = SB3Policy(model, normalize=venv)(obs, transition)
    np.testing.assert_array_equal(action, wanted(model, venv, obs))


def test_a_training_that_normalised_nothing_or_rewards_alone_needs_no_statistics(tmp_path):
    trained("PPO", small()).save(tmp_path / "model.zip")
    assert SB3Policy.load(tmp_path / "model.zip", trust=True).normalization is None
    model = trained("PPO", VecNormalize(small(), norm_obs=False))
    SB3Policy(model).save(tmp_path / "policy.zip")
    loaded = SB3Policy.load(tmp_path / "policy.zip")
    obs, transition = start()
    np.testing.assert_array_equal(loaded(obs, transition), SB3Policy(model)(obs, transition))


def test_statistics_of_another_kind_are_refused(tmp_path):
    model = trained("PPO", normalized())
    text = tmp_path / "vecnormalize.pkl"
    text.write_text("not a pickle")
    other = tmp_path / "other.pkl"
    VecNormalize(small("shared")).save(str(other))
    array = tmp_path / "array.pkl"
    array.write_bytes(np.zeros(3).dumps())
    wrong: list[str | Path | int] = [text, tmp_path / "nothing.pkl", str(array), 3]
    for given in wrong:
        with pytest.raises(InvalidInput, match="normalize must be"):
            SB3Policy(model, normalize=given, trust=True)  # type: ignore[arg-type]
    with pytest.raises(InvalidInput, match="44 features that the policy takes, got 22"):
        SB3Policy(model, normalize=other, trust=True)
    with pytest.raises(InvalidInput, match="normalize must be"):
        SB3Policy(model, normalize=True)


def test_a_file_that_does_not_say_whether_it_was_normalised_is_refused(tmp_path):
    trained("PPO", normalized()).save(tmp_path / "traceless.zip", exclude=["_last_original_obs"])
    trained("SAC", small()).save(tmp_path / "model.zip")
    for name in ("traceless", "model"):
        with pytest.raises(InvalidInput, match=rf"may have been.*{name}\.zip.*\.save writes"):
            SB3Policy.load(tmp_path / f"{name}.zip", trust=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        SB3Policy.load(tmp_path / "model.zip", normalize=False, trust=True)
    normalized().save(str(tmp_path / "vec_normalize.pkl"))
    with pytest.raises(InvalidInput, match=r"may have been.*vec_normalize\.pkl"):
        SB3Policy.load(tmp_path / "model.zip", trust=True)
