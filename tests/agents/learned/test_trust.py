"""Reading a policy's file runs nothing in it, unless it is trusted."""

import json
import zipfile
from pathlib import Path

import gymnasium
import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecNormalize

from coopenv.agents.learned import read_notes
from coopenv.agents.sb3 import FallingRate, SB3Policy, Scaled, feature_scale
from coopenv.errors import InvalidInput
from tests.agents.learned import hostile
from tests.agents.learned.cases import ALGORITHMS, normalized, small, start, trained, untrained


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> Path:
    """A policy that `SB3Policy.save` wrote."""
    path = tmp_path_factory.mktemp("plain") / "policy.zip"
    SB3Policy(trained("PPO", small())).save(path)
    return path


def test_entries_that_run_code_run_only_if_trusted(plain, tmp_path):
    marker = tmp_path / "marker"
    path = hostile.in_data(plain, tmp_path / "policy.zip", marker)
    obs, transition = start()
    safe = SB3Policy.load(path)
    assert not marker.exists()
    np.testing.assert_array_equal(safe(obs, transition), SB3Policy.load(plain)(obs, transition))
    SB3Policy.load(path, trust=True)
    assert marker.exists()


@pytest.mark.parametrize(
    "made", [hostile.in_weights, hostile.in_pickled_weights, hostile.in_statistics]
)
def test_weights_and_statistics_that_run_code_are_refused(made, plain, tmp_path):
    marker = tmp_path / "marker"
    path = made(plain, tmp_path / "policy.zip", marker)
    for trust in (False, True):  # SB3 reads weights as numbers too
        with pytest.raises(InvalidInput, match="policy must"):
            SB3Policy.load(path, trust=trust)
    assert not marker.exists()


def test_statistics_in_a_pickle_are_read_only_if_trusted(tmp_path):
    model = trained("PPO", normalized())
    path, marker = tmp_path / "vecnormalize.pkl", tmp_path / "marker"
    path.write_bytes(hostile.pickle.dumps(hostile.Touch(marker)))
    with pytest.raises(InvalidInput, match="normalize must be a VecNormalize unless you trust"):
        SB3Policy(model, normalize=path)
    assert not marker.exists()
    with pytest.raises(InvalidInput, match="which holds a NoneType"):
        SB3Policy(model, normalize=path, trust=True)
    assert marker.exists()


@pytest.mark.parametrize("writer", ["Stable-Baselines3 itself", "an older coopenv"])
def test_a_file_without_a_blueprint_asks_for_trust_and_says_why(writer, plain, tmp_path):
    path = tmp_path / "policy.zip"
    names = ["coopenv_model.json", *["coopenv.json"] * (writer != "an older coopenv")]
    hostile.with_members(plain, path, dict.fromkeys(names))
    with pytest.raises(InvalidInput, match=rf"which {writer} wrote: .*trust=True \(--trust\)"):
        SB3Policy.load(path)
    trusted = SB3Policy.load(path, trust=True)
    trusted.save(path)
    obs, transition = start()
    np.testing.assert_array_equal(SB3Policy.load(path)(obs, transition), trusted(obs, transition))


class OwnPolicy(ActorCriticPolicy):
    pass


class OwnFeatures(BaseFeaturesExtractor):
    def __init__(self, observation_space: gymnasium.spaces.Box):
        super().__init__(observation_space, observation_space.shape[0])

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        return 2 * observations


def test_classes_of_ones_own_ask_for_trust_and_are_named(tmp_path):
    features = {"net_arch": [8], "features_extractor_class": OwnFeatures}
    models = {
        "OwnPolicy": untrained(PPO, small(), OwnPolicy),
        "OwnFeatures": trained("PPO", small(), policy_kwargs=features),
    }
    for name, model in models.items():
        SB3Policy(model).save(tmp_path / "own.zip")
        with pytest.raises(InvalidInput, match=rf"made with .*{name}.*trust=True"):
            SB3Policy.load(tmp_path / "own.zip")
        obs, transition = start()
        loaded = SB3Policy.load(tmp_path / "own.zip", trust=True)
        np.testing.assert_array_equal(loaded(obs, transition), SB3Policy(model)(obs, transition))


@pytest.mark.parametrize("name", ALGORITHMS)
def test_a_model_that_is_built_anew_is_what_was_saved(name, tmp_path):
    model = trained(name, small())
    SB3Policy(model).save(tmp_path / "policy.zip")
    built = SB3Policy.load(tmp_path / "policy.zip").model
    assert type(built) is type(model)
    assert built.num_timesteps == model.num_timesteps
    assert built.observation_space == model.observation_space
    assert built.get_env() is None
    left_out = ("learning_rate", "replay_buffer_class", "rollout_buffer_class", "clip_range")
    for entry in ("gamma", "n_steps", "batch_size", "tau", "ent_coef", "seed", "n_envs", *left_out):
        was, now = getattr(model, entry, None), getattr(built, entry, None)
        assert was == now or str(was)[:40] == str(now)[:40], entry
    for part, values in model.get_parameters().items():
        found = built.get_parameters()[part]
        assert str(values) == str(found), part
    SB3Policy.load(tmp_path / "policy.zip").save(tmp_path / "again.zip")
    for member in ("coopenv_model.json", "coopenv.json"):
        assert member_of(tmp_path / "again.zip", member) == member_of(
            tmp_path / "policy.zip", member
        )


def member_of(path: Path, name: str) -> bytes:
    with zipfile.ZipFile(path) as archive:
        return archive.read(name)


def test_a_model_that_is_built_anew_trains_on(tmp_path):
    venv = small()
    keywords = {
        "features_extractor_class": Scaled,
        "features_extractor_kwargs": {"scale": feature_scale(venv)},
        "activation_fn": torch.nn.ReLU,
        "net_arch": {"pi": [8, 4], "vf": [8]},
    }
    model = trained("PPO", venv, learning_rate=FallingRate(1e-3), policy_kwargs=keywords)
    SB3Policy(model).save(tmp_path / "policy.zip")
    built = SB3Policy.load(tmp_path / "policy.zip").model
    assert built.learning_rate == FallingRate(1e-3)
    weights = []
    for each in (PPO.load(tmp_path / "policy.zip", env=small()), built):
        each.set_env(small())
        each.set_random_seed(3)
        each.learn(16, reset_num_timesteps=False)
        weights.append(torch.cat([each.flatten() for each in each.policy.parameters()]))
    torch.testing.assert_close(*weights, rtol=0, atol=0)


@pytest.mark.parametrize("scale", [(1, 2), (np.float64(0.1), np.float64(3.0))])
def test_features_are_scaled_in_single_precision_whatever_the_factors_are(scale):
    layer = Scaled(gymnasium.spaces.Box(-1.0, 1.0, (2,)), scale)
    assert layer.scale.dtype == layer(torch.ones(3, 2)).dtype == torch.float32
    torch.testing.assert_close(layer(torch.ones(3, 2)), torch.tensor([scale] * 3).float())


def test_a_schedule_that_no_plain_value_says_is_not_replaced_in_silence(tmp_path):
    model = trained("PPO", small(), learning_rate=lambda remaining: 1e-3 * remaining**2)
    path = tmp_path / "policy.zip"
    SB3Policy(model).save(path)
    for _ in "ab":  # also once it was loaded and saved again
        policy = SB3Policy.load(path)
        policy(*start())
        policy.model.set_env(small())
        with pytest.raises(InvalidInput, match="learning_rate must be known to train on"):
            policy.model.learn(16)
        policy = SB3Policy.load(path)
        policy.save(path)


def test_a_model_taken_out_of_its_policy_does_not_lose_its_normalisation(tmp_path):
    SB3Policy(trained("PPO", normalized())).save(tmp_path / "policy.zip")
    policy = SB3Policy.load(tmp_path / "policy.zip")
    with pytest.raises(InvalidInput, match="normalize must be given"):
        SB3Policy(policy.model)


def test_a_blueprint_builds_no_layer_beyond_the_weights_in_the_file(plain, tmp_path):
    blueprint = json.loads(member_of(plain, "coopenv_model.json"))
    for size in (10**5, 10**9):
        for layers in ([size], [8, size], {"dict": {"pi": [size]}}):
            blueprint["policy_kwargs"]["dict"]["net_arch"] = layers
            text = json.dumps(blueprint).encode()
            path = hostile.with_members(plain, tmp_path / "large.zip", {"coopenv_model.json": text})
            with pytest.raises(InvalidInput, match="layers have more than the"):
                SB3Policy.load(path)


@pytest.mark.parametrize(
    "layers", [None, [], [8], {"dict": {"pi": [8]}}, [8, {"dict": {"pi": [8]}}]]
)
def test_a_blueprint_chooses_from_no_more_than_the_weights_in_the_file(layers, plain, tmp_path):
    blueprint = json.loads(member_of(plain, "coopenv_model.json"))
    blueprint["spaces"]["action_space"] = {"pushes": 10**4}
    blueprint["policy_kwargs"] = {"dict": {} if layers is None else {"net_arch": layers}}
    text = json.dumps(blueprint).encode()
    path = hostile.with_members(plain, tmp_path / "large.zip", {"coopenv_model.json": text})
    with pytest.raises(InvalidInput, match="chooses from more than its weights can tell apart"):
        SB3Policy.load(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("target_kl", "much"), ("target_kl", [1]), ("n_steps", "many"), ("n_steps", True),
        ("use_sde", 1), ("use_sde", None), ("rollout_buffer_kwargs", "none"),
    ],
)  # fmt: skip
def test_settings_of_another_kind_than_the_algorithms_are_refused(name, value, plain, tmp_path):
    blueprint = json.loads(member_of(plain, "coopenv_model.json"))
    blueprint["settings"][name] = value
    text = json.dumps(blueprint).encode()
    path = hostile.with_members(plain, tmp_path / "odd.zip", {"coopenv_model.json": text})
    with pytest.raises(InvalidInput, match=f"{name} is "):
        SB3Policy.load(path)


def test_an_archive_that_unpacks_to_very_much_is_refused_before_it_does(plain, tmp_path):
    path = tmp_path / "bomb.zip"
    path.write_bytes(plain.read_bytes())
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros", bytes(110_000_000))
    for read in (SB3Policy.load, read_notes):
        with pytest.raises(InvalidInput, match=r"would unpack to 110,\d+,\d+ bytes"):
            read(path)


def test_off_policy_models_and_statistics_of_rewards_alone_need_no_trust(tmp_path):
    model = trained("SAC", VecNormalize(small(), norm_obs=False))
    SB3Policy(model).save(tmp_path / "policy.zip")
    assert type(SB3Policy.load(tmp_path / "policy.zip").model) is SAC
