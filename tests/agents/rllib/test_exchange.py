"""Modules of RLlib in plain numbers; where it is not installed, modules of the same layers."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("stable_baselines3")

import torch
from gymnasium.spaces import Box, Discrete

from coopenv import Transport
from coopenv.agents import load
from coopenv.agents.evaluate import evaluate
from coopenv.agents.features import scale_of_features
from coopenv.agents.rllib.exchange import plain_policy
from coopenv.agents.sb3 import SB3Policy
from coopenv.errors import CoopenvError, InvalidInput
from coopenv.pushes import table_of

HIDDEN = 6


def module(features: int, outputs: int, *, spread: bool = True, seed: int = 0, **changes):
    """PPO's default module of RLlib, as far as it acts."""
    torch.manual_seed(seed)
    net = torch.nn.Sequential(torch.nn.Linear(features, HIDDEN), torch.nn.Tanh())
    head = torch.nn.Sequential(torch.nn.Linear(HIDDEN, outputs))
    pi = SimpleNamespace(net=SimpleNamespace(mlp=changes.get("head", head)))
    if spread:
        pi.log_std = torch.nn.Parameter(torch.linspace(-1, 0, outputs))
    encoder = SimpleNamespace(actor_encoder=SimpleNamespace(net=SimpleNamespace(mlp=net)))
    return SimpleNamespace(encoder=encoder, pi=pi)


def acts(of, seen: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """What RLlib would do with what the environment shows, without randomness."""
    with torch.no_grad():
        latent = of.encoder.actor_encoder.net.mlp(torch.tensor(seen * scale, dtype=torch.float32))
        return of.pi.net.mlp(latent).clamp(-1, 1).numpy()


@pytest.fixture(scope="module")
def core():
    core = Transport(num_worlds=3)
    core.reset(seed=0)
    core.step(np.zeros((3, 2, 3)))
    return core


def spaces(core):
    seen = core.observation
    return (
        Box(np.float32(seen.low), np.float32(seen.high), dtype=np.float32),
        Box(-1, 1, (3,), dtype=np.float32),
    )


def test_one_module_acts_for_each_agent_by_itself(core):
    scale = np.array(scale_of_features(core))
    of, obs = module(len(scale), 3), np.random.default_rng(0).normal(size=(3, 2, len(scale)))
    policy = plain_policy([of], scale, spaces(core), {})
    np.testing.assert_allclose(policy(obs, core.transition), acts(of, obs, scale), atol=1e-6)


def test_modules_of_their_own_act_as_one_network_in_which_none_sees_the_other(core):
    scale = np.array(scale_of_features(core))
    both = [module(len(scale), 3, seed=seed) for seed in (1, 2)]
    obs = np.random.default_rng(0).normal(size=(3, 2, len(scale)))
    policy = plain_policy(both, scale, spaces(core), {})
    wanted = np.stack([acts(of, obs[:, agent], scale) for agent, of in enumerate(both)], axis=1)
    np.testing.assert_allclose(policy(obs, core.transition), wanted, atol=1e-6)
    assert np.abs(wanted[:, 0] - wanted[:, 1]).max() > 0.05
    noisy: Any = policy.sampled()
    assert noisy.form.network.spread.shape == (6,)


@pytest.mark.parametrize("agents", [1, 2])
def test_modules_that_choose_among_pushes_choose_the_best(agents):
    core = Transport(num_worlds=3, action="discrete", pushes="axes")
    core.reset(seed=0)
    core.step(np.zeros((3, 2), dtype=np.int64))
    assert core.transition is not None
    scale, pushes = np.array(scale_of_features(core)), len(table_of("axes"))
    of = [module(len(scale), pushes, spread=False, seed=seed) for seed in range(agents)]
    obs = np.random.default_rng(0).normal(size=(3, 2, len(scale)))
    policy = plain_policy(of, scale, (spaces(core)[0], Discrete(pushes)), {})
    for agent in range(2):
        with torch.no_grad():
            one = of[agent % agents]
            rows = torch.tensor(obs[:, agent] * scale, dtype=torch.float32)
            best = one.pi.net.mlp(one.encoder.actor_encoder.net.mlp(rows)).argmax(dim=1)
        assert policy(obs, core.transition)[:, agent].tolist() == best.tolist()


def test_the_file_is_evaluated_as_any_other_and_does_not_learn_on(core, tmp_path):
    scale = scale_of_features(core)
    policy = plain_policy([module(len(scale), 3)], scale, spaces(core), {})
    policy.save(tmp_path / "policy.npz")
    again = load(tmp_path / "policy.npz")
    assert evaluate(again, episodes=2) == evaluate(policy, episodes=2)
    with pytest.raises(CoopenvError, match=r"ray\.rllib"):
        SB3Policy.load(tmp_path / "policy.npz")


def test_layers_of_another_kind_are_refused(core):
    scale = scale_of_features(core)
    odd = module(len(scale), 3, head=torch.nn.Sequential(torch.nn.LayerNorm(HIDDEN)))
    with pytest.raises(InvalidInput, match="dense layers with tanh, relu, silu, got LayerNorm"):
        plain_policy([odd], scale, spaces(core), {})
