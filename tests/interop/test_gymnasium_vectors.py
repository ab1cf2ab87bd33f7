"""Gymnasium's vectors: its wrappers around them, and worker processes."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import vector as vectors

from tests.helpers import EASY_TASKS, IDS
from tests.interop.cases import around_ids, drawn_actions

SCALE: Any = (-3.0, 2.0)
Wrap = Callable[[Any], Any]

# Wrappers of both kinds: (vector's, single's); around many worlds they do what the single one does.
BATCHED: dict[str, tuple[Wrap, Wrap]] = {
    "FlattenObservation": (vectors.FlattenObservation, wrappers.FlattenObservation),
    "DtypeObservation": (
        lambda env: vectors.DtypeObservation(env, np.float64),
        lambda env: wrappers.DtypeObservation(env, np.float64),
    ),
    "ReshapeObservation": (
        lambda env: vectors.ReshapeObservation(env, halves(env.single_observation_space)),
        lambda env: wrappers.ReshapeObservation(env, halves(env.observation_space)),
    ),
    "RescaleObservation": (
        lambda env: vectors.RescaleObservation(env, *span(env.single_observation_space)),
        lambda env: wrappers.RescaleObservation(env, *span(env.observation_space)),
    ),
    "TransformObservation": (
        lambda env: vectors.TransformObservation(env, np.negative),
        lambda env: wrappers.TransformObservation(env, np.negative, env.observation_space),
    ),
    "ClipAction": (vectors.ClipAction, wrappers.ClipAction),
    "RescaleAction": (
        lambda env: vectors.RescaleAction(env, *SCALE),
        lambda env: wrappers.RescaleAction(env, *SCALE),
    ),
    "TransformAction": (
        lambda env: vectors.TransformAction(env, np.negative, env.action_space),
        lambda env: wrappers.TransformAction(env, np.negative, env.action_space),
    ),
    "ClipReward": (
        lambda env: vectors.ClipReward(env, -0.01, 0.01),
        lambda env: wrappers.ClipReward(env, -0.01, 0.01),
    ),
    "TransformReward": (
        lambda env: vectors.TransformReward(env, lambda reward: 2 * reward),
        lambda env: wrappers.TransformReward(env, lambda reward: 2 * float(reward)),
    ),
}
VECTORS_ONLY: dict[str, Wrap] = {
    "DictInfoToList": vectors.DictInfoToList,
    "NormalizeObservation": vectors.NormalizeObservation,
    "NormalizeReward": vectors.NormalizeReward,
    "RecordEpisodeStatistics": vectors.RecordEpisodeStatistics,
    "VectorizeTransformObservation": lambda env: vectors.VectorizeTransformObservation(
        env, wrappers.FlattenObservation
    ),
    "VectorizeTransformAction": lambda env: vectors.VectorizeTransformAction(
        env, wrappers.RescaleAction, min_action=-2.0, max_action=2.0
    ),
    "VectorizeTransformReward": lambda env: vectors.VectorizeTransformReward(
        env, wrappers.ClipReward, min_reward=0.0, max_reward=1.0
    ),
}


# In libraries/gymnasium.py, since they need more packages than our tests; in a world of JAX.
ELSEWHERE = {
    "ArrayConversion",
    "HumanRendering",
    "NumpyToTorch",
    "RecordVideo",
}
UNFIT = {"FilterObservation", "GrayscaleObservation", "JaxToNumpy", "JaxToTorch"}
UNFIT |= {
    "ResizeObservation"
}  # those of pictures and dictionaries: a vector has no pictures in them


def test_every_wrapper_of_vectors_is_tried_or_named():
    assert set(vectors.__all__) <= {*BATCHED, *VECTORS_ONLY, *ELSEWHERE, *UNFIT}


def halves(space: Any) -> tuple[int, int]:
    return 2, space.shape[0] // 2


def span(space: Any) -> tuple[Any, Any]:
    """Bounds of a rescaled observation: [-1, 2] where there were any."""
    bounded = space.bounded_below & space.bounded_above
    low, high = np.where(bounded, -1.0, space.low), np.where(bounded, 2.0, space.high)
    return low.astype(np.float32), high.astype(np.float32)


@pytest.mark.parametrize(
    ("view", "name", "mode"),
    [
        (view, name, mode)
        for view, name in around_ids(BATCHED)
        for mode in ("NextStep", "SameStep")
        if mode == "NextStep" or not name.endswith("Observation")  # Gymnasium refuses these
    ],
)
def test_a_wrapped_vector_does_what_wrapped_environments_do(view, name, mode):
    around, within = BATCHED[name]
    keywords = {"task": EASY_TASKS[view], "horizon": 6}
    ours = around(gymnasium.make_vec(view, num_envs=3, autoreset_mode=mode, **keywords))
    theirs: Any = gymnasium.make_vec(
        view,
        num_envs=3,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": AutoresetMode(mode)},
        wrappers=(within,),
        **keywords,
    )
    for space in ("single_observation_space", "single_action_space", "action_space"):
        assert getattr(ours, space) == getattr(theirs, space)
    assert ours.observation_space == theirs.observation_space
    assert equal(ours.reset(seed=11), theirs.reset(seed=11))
    for action in drawn_actions(theirs, 10):
        assert equal(ours.step(action), theirs.step(action))


def equal(mine: Any, wanted: Any) -> bool:
    """Infos of worlds that have none are filled with what came before or with zeros."""
    known = [{key: value for key, value in part[-1].items()} for part in (mine, wanted)]
    same = data_equivalence(tuple(mine[:-1]), tuple(wanted[:-1]))
    return (
        same
        and known[0].keys() == known[1].keys()
        and all(
            data_equivalence(*(info[key][known[1][f"_{key}"]] for info in known))
            for key in known[1]
            if not key.startswith("_") and key not in ("final_obs", "final_info")
        )
    )


@pytest.mark.parametrize(("view", "name"), around_ids(VECTORS_ONLY))
def test_a_vector_takes_the_wrappers_that_only_vectors_have(view, name):
    env = VECTORS_ONLY[name](gymnasium.make_vec(view, num_envs=3, horizon=6))
    plain: Any = gymnasium.make_vec(view, num_envs=3, horizon=6)
    env.reset(seed=0)
    _, told = plain.reset(seed=0)
    for action in drawn_actions(env, 10):
        obs, reward, *ends, info = env.step(action)
        assert obs in env.observation_space
        assert np.isfinite(reward).all()
        assert [end.shape for end in ends] == [(3,), (3,)]
        rows = info if name == "DictInfoToList" else [info]
        assert all(row.keys() >= wanted(told, name) for row in rows)


def wanted(told: Any, name: str) -> set[str]:
    """Keys of an info, as rows have them without the marks of presence."""
    marked = name != "DictInfoToList"
    return {key for key in told if marked or not key.startswith("_")}


@pytest.mark.parametrize(  # a process that imports everything anew takes seconds
    "view", [IDS[0], *(pytest.param(view, marks=pytest.mark.slow) for view in IDS[1:])]
)
def test_a_vector_of_processes_that_begin_anew_is_the_one_in_this_process(view):
    keywords: dict[str, Any] = {"num_envs": 1, "horizon": 3, "task": EASY_TASKS[view]}
    apart: Any = gymnasium.make_vec(
        view, vectorization_mode="async", vector_kwargs={"context": "spawn"}, **keywords
    )
    try:
        near: Any = gymnasium.make_vec(view, vectorization_mode="sync", **keywords)
        assert data_equivalence(apart.reset(seed=1), near.reset(seed=1), exact=True)
        for action in drawn_actions(near, 5):
            assert data_equivalence(apart.step(action), near.step(action), exact=True)
    finally:
        apart.close()
