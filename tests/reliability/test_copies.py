"""What can be pickled and copied, and goes on alike; what cannot says so: `docs/processes.md`."""

import copy
import os
import pickle
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest

from coopenv import Transport, TransportConfig, wrench
from coopenv.agents.controllers import RandomPolicy, find_controller
from coopenv.agents.partners import PARTNERS, find_partner
from coopenv.agents.policy import Policy, forget
from coopenv.arrays import FloatArray
from coopenv.envs.registry import find_config
from tests.agents.partners.cases import acting
from tests.helpers import IDS, LEVEL, PARALLEL, actions, assert_same
from tests.reliability.processes import in_fork

AGAIN: dict[str, Callable[[Any], Any]] = {
    "pickled": lambda one: pickle.loads(pickle.dumps(one)),
    "copied deep": copy.deepcopy,
    "copied": copy.copy,
}


def views(name: str) -> list[Any]:
    module: Any = PARALLEL[name]
    return [
        gymnasium.make(name),
        gymnasium.make_vec(name, num_envs=2),
        module.parallel_env(),
        module.env(),
    ]


def first(env: Any) -> Any:
    """The first observations of a seed."""
    started = env.reset(seed=3)
    return env.last()[0] if started is None else started[0]


@pytest.mark.parametrize("again", ["pickled", "copied deep"])
@pytest.mark.parametrize("name", IDS)
def test_a_view_can_be_copied_before_its_first_reset(name, again):
    for env in views(name):
        twin = AGAIN[again](env)
        np.testing.assert_equal(first(twin), first(env))


@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("name", IDS)
def test_a_core_can_be_copied_before_its_first_reset(name, again):
    core = Transport(num_worlds=3, config=find_config(name, {}))
    twin = AGAIN[again](core)
    assert twin.turn is not core.turn  # one thread in each
    np.testing.assert_array_equal(twin.reset(seed=1)[0], core.reset(seed=1)[0])


@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("name", LEVEL)
def test_a_core_can_be_copied_with_episodes_under_way(name, again):
    core = Transport(num_worlds=3, config=find_config(name, {"horizon": 12}))
    core.reset(seed=1)
    shape = 3, len(core.learners), core.action_size
    plan = 0.3 * actions(0, 20, *shape)
    for action in plan[:5]:
        core.step(action)
    twin = AGAIN[again](core)
    ended = np.zeros(3, dtype=np.bool_)
    for action in plan[5:]:
        mine, theirs = (one.step(action, restart=ended) for one in (core, twin))
        assert_same(mine, theirs)
        ended = mine[2] | mine[3]
    assert not np.shares_memory(core.world.pose, twin.world.pose)


@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("size", [2, 3])
def test_a_decomposer_and_its_answers_can_be_copied(again, size):
    rng = np.random.default_rng(0)
    split = wrench.Decomposer(rng.normal(size=(3, size)))
    answer = split(rng.normal(size=(4, 3, 3 * size - 3)))
    for twin in (AGAIN[again](split)(answer.applied), AGAIN[again](answer)):
        np.testing.assert_array_equal(twin.manipulation, answer.manipulation)
        np.testing.assert_array_equal(twin.relative_cost, answer.relative_cost)


@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("name", PARTNERS)
def test_a_partner_can_be_copied(name, again):
    partner = find_partner(name)
    twin = AGAIN[again](partner)
    assert twin == partner
    seen, expected = (
        Transport(partner=one, **acting(name)).reset(seed=0)[0] for one in (twin, partner)
    )
    np.testing.assert_array_equal(seen, expected)


def acts(policy: Policy) -> FloatArray:
    """Actions at the start of two episodes."""
    core = Transport(num_worlds=2)
    obs, _ = core.reset(seed=0)
    forget(policy, np.ones(2, dtype=np.bool_), seeds=[0, 1])
    assert core.transition is not None
    return policy(obs, core.transition)


@pytest.mark.parametrize("again", AGAIN)
@pytest.mark.parametrize("make", [find_controller, RandomPolicy])
def test_a_policy_can_be_copied(make, again):
    policy = make(TransportConfig())
    np.testing.assert_array_equal(acts(AGAIN[again](policy)), acts(policy))


@pytest.mark.parametrize("again", AGAIN)
def test_a_learned_policy_can_be_copied_and_acts_in_a_forked_child(again):
    pytest.importorskip("stable_baselines3")
    from coopenv.agents import sb3

    policy = untrained(sb3)
    expected = acts(policy)
    np.testing.assert_array_equal(acts(AGAIN[again](policy)), expected)
    if hasattr(os, "fork"):
        in_fork(lambda: np.testing.assert_array_equal(acts(policy), expected))


def untrained(sb3: Any) -> Any:
    """A small policy of PPO, on one thread of torch: more do not survive a fork."""
    import torch
    from stable_baselines3 import PPO

    torch.set_num_threads(1)
    venv = sb3.make_vec_env("coopenv/BeamTransport-v0", 2)
    kind: dict[str, Any] = {"net_arch": [8]}
    return sb3.SB3Policy(PPO("MlpPolicy", venv, policy_kwargs=kind, device="cpu", seed=1))
