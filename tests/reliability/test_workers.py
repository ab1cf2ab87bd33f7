"""Environments in processes of their own, however those are started: `docs/processes.md`."""

import multiprocessing
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AsyncVectorEnv

from tests.helpers import IDS

WAYS = [  # each worker that is not forked imports everything anew, which takes seconds
    pytest.param(way, name, marks=[] if way == "fork" or name == IDS[1] else [pytest.mark.slow])
    for way in ("fork", "forkserver", "spawn")
    if way in multiprocessing.get_all_start_methods()
    for name in IDS
]
SEED, STEPS = 7, 3


def makers(name: str) -> list[Callable[[], gymnasium.Env[Any, Any]]]:
    """Two of them; the name says where it is registered, which a new process does not know."""
    return [partial(gymnasium.make, f"coopenv:{name}")] * 2


def alone(name: str) -> list[Any]:
    """Observations of the first of the two environments, in this process."""
    env = makers(name)[0]()
    env.action_space.seed(0)
    seen = [env.reset(seed=SEED)[0]]
    return seen + [env.step(env.action_space.sample())[0] for _ in range(STEPS)]


def sampled(name: str) -> list[Any]:
    """The actions of `alone`, the same for both workers."""
    space = makers(name)[0]().action_space
    space.seed(0)
    return [np.stack([space.sample()] * 2) for _ in range(STEPS)]


@pytest.mark.parametrize(("way", "name"), WAYS)
def test_gymnasiums_workers_run_to_the_same_bits(way, name):
    venv = AsyncVectorEnv(makers(name), context=way)
    try:
        seen = [venv.reset(seed=SEED)[0]]
        seen += [venv.step(action)[0] for action in sampled(name)]
    finally:
        venv.close(terminate=True)
    np.testing.assert_array_equal([both[0] for both in seen], alone(name))


@pytest.mark.parametrize(("way", "name"), WAYS)
def test_stable_baselines_workers_run_to_the_same_bits(way, name):
    sb3 = pytest.importorskip("stable_baselines3.common.vec_env")
    venv = sb3.SubprocVecEnv(makers(name), start_method=way)
    try:
        venv.seed(SEED)
        seen = [venv.reset()]
        seen += [venv.step(action)[0] for action in sampled(name)]
    finally:
        venv.close()
    np.testing.assert_array_equal([both[0] for both in seen], alone(name))
