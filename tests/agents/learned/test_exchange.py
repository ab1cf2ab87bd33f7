"""Models of Stable-Baselines3 in plain numbers, and back."""

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")

from stable_baselines3 import DQN, PPO

from coopenv.agents import load, sb3
from coopenv.agents.learned import read_notes
from coopenv.agents.sb3 import SB3Policy
from coopenv.agents.trained import PlainPolicy
from coopenv.errors import InvalidInput
from tests.agents.learned import damage
from tests.agents.learned.cases import (
    ALGORITHMS,
    CONFIG,
    OFF_POLICY,
    ON_POLICY,
    SPREADLESS,
    normalized,
    small,
    start,
    trained,
)

REFUSED = ("ARS", "CrossQ", "RecurrentPPO")
TAKEN = tuple(name for name in ALGORITHMS if name not in REFUSED)
ROUNDING = 1e-6  # of actions in [−1, 1], in single precision


def both_ways(policy: SB3Policy, path, config=CONFIG) -> None:
    """What is exported acts alike; what is made of it again, to the bit."""
    policy.plain().save(path)
    obs, transition = start(config=config)
    wanted = policy(obs, transition)
    np.testing.assert_array_equal(SB3Policy.load(path)(obs, transition), wanted)
    again = load(path)
    np.testing.assert_allclose(again(obs, transition), wanted, rtol=0, atol=ROUNDING)
    drawn, sampled = policy.sampled(), PlainPolicy.load(path).sampled()
    assert (drawn is None) == (sampled is None)
    if drawn is not None and sampled is not None:
        np.testing.assert_allclose(
            sampled(obs, transition), drawn(obs, transition), rtol=0, atol=ROUNDING
        )


@pytest.mark.parametrize("name", TAKEN)
@pytest.mark.parametrize("control", ["joint", "shared"])
def test_it_acts_as_its_model_and_becomes_one_again_to_the_bit(name, control, tmp_path):
    policy = SB3Policy(trained(name, small(control)))
    both_ways(policy, tmp_path / "policy.npz")
    assert (policy.sampled() is None) == (name in SPREADLESS)


def test_normalised_observations_go_along(tmp_path):
    policy = SB3Policy(trained("PPO", normalized()))
    both_ways(policy, tmp_path / "policy.npz")
    assert SB3Policy.load(tmp_path / "policy.npz").normalization is not None


@pytest.mark.parametrize(
    ("algorithm", "keywords", "control"),
    [(PPO, ON_POLICY, "joint"), (PPO, ON_POLICY, "shared"), (DQN, OFF_POLICY, "shared")],
)
def test_choices_of_pushes_go_along(algorithm, keywords, control, tmp_path):
    venv = sb3.make_vec_env(
        "coopenv/BeamTransport-v0", 2, control=control, seed=5, action="discrete", horizon=6
    )
    model = algorithm("MlpPolicy", venv, device="cpu", seed=1, **keywords).learn(12)
    both_ways(SB3Policy(model), tmp_path / "policy.npz", venv.transport.config)


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_row_of_dense_layers_is_refused_and_named(name):
    policy = SB3Policy(trained(name, small()))
    with pytest.raises(InvalidInput, match=rf"dense layers .*, got .* of {name}; keep its \.zip"):
        policy.plain()


def test_the_model_learns_on_with_a_new_optimiser(tmp_path):
    policy = SB3Policy(trained("PPO", small()))
    policy.plain().save(tmp_path / "policy.npz")
    again = SB3Policy.load(tmp_path / "policy.npz")
    assert not again.model.policy.optimizer.state
    again.model.set_env(small())
    before = again.model.policy.state_dict()["action_net.weight"].clone()
    again.model.learn(12)
    assert (again.model.policy.state_dict()["action_net.weight"] != before).any()
    assert again.model.policy.optimizer.state


def test_the_record_of_its_environment_goes_along(tmp_path):
    policy = SB3Policy(trained("PPO", small()), notes=small().to_notes())
    policy.plain().save(tmp_path / "policy.npz")
    assert read_notes(tmp_path / "policy.npz")["provenance"]["environment"]["horizon"] == 6


def test_a_damaged_copy_is_refused_in_our_words_or_read_whole(tmp_path):
    whole = tmp_path / "policy.npz"
    policy = SB3Policy(trained("PPO", normalized()), notes=small().to_notes())
    policy.plain().save(whole)
    for read, seed in ((PlainPolicy.load, 1), (SB3Policy.load, 2)):
        counts = damage.refused_or_whole(
            damage.damaged_archive, whole, tmp_path / "copy.npz", read, times=150, seed=seed
        )
        assert counts["refused"] > 75


def test_a_policy_whose_choices_are_masked_is_refused_and_named():
    masked = pytest.importorskip("sb3_contrib").MaskablePPO
    venv = sb3.make_vec_env("coopenv/BeamTransport-v0", 2, seed=5, action="discrete")
    model = masked("MlpPolicy", venv, device="cpu", policy_kwargs={"net_arch": [8]})
    with pytest.raises(InvalidInput, match=r"dense layers .* of MaskablePPO; keep its \.zip"):
        SB3Policy(model).plain()
