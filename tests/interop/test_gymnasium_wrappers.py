"""Every wrapper of Gymnasium's that fits a box of numbers, and every id in several of them."""

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.utils.env_checker import data_equivalence

from tests.helpers import EASY_TASKS
from tests.interop.cases import DRAWS, around_ids, drawn_actions, names

Wrap = Callable[[Any], Any]


def finite(env: Any) -> Any:
    """Observations cut to ±10, where a wrapper needs bounds."""
    space = gymnasium.spaces.Box(-10, 10, env.observation_space.shape)
    return wrappers.TransformObservation(env, lambda obs: obs.clip(-10, 10), space)


def drawn(env: Any) -> Any:
    """Pictures as observations."""
    return wrappers.AddRenderObservation(env)


# Name → what goes around a single environment; those that draw get render_mode="rgb_array".
PLAIN: dict[str, Wrap] = {
    "DelayObservation": lambda env: wrappers.DelayObservation(env, 2),
    "DtypeObservation": lambda env: wrappers.DtypeObservation(env, np.float64),
    "DiscretizeObservation": lambda env: wrappers.DiscretizeObservation(
        finite(env), bins=5, multidiscrete=True
    ),
    "FlattenObservation": wrappers.FlattenObservation,
    "FrameStackObservation": lambda env: wrappers.FrameStackObservation(env, 3),
    "TransformObservation": finite,
    "MaxAndSkipObservation": lambda env: wrappers.MaxAndSkipObservation(env, 2),
    "NormalizeObservation": wrappers.NormalizeObservation,
    "ReshapeObservation": lambda env: wrappers.ReshapeObservation(
        env, (2, env.observation_space.shape[0] // 2)
    ),
    "RescaleObservation": lambda env: wrappers.RescaleObservation(
        finite(env), np.float32(-1), np.float32(1)
    ),
    "TimeAwareObservation": wrappers.TimeAwareObservation,
    "ClipAction": wrappers.ClipAction,
    "DiscretizeAction": lambda env: wrappers.DiscretizeAction(env, bins=3, multidiscrete=True),
    "TransformAction": lambda env: wrappers.TransformAction(env, np.negative, env.action_space),
    "RescaleAction": lambda env: wrappers.RescaleAction(env, np.float32(-2), np.float32(2)),
    "StickyAction": lambda env: wrappers.StickyAction(env, 0.25),
    "RepeatAction": lambda env: wrappers.RepeatAction(env, 3),
    "ClipReward": lambda env: wrappers.ClipReward(env, -0.01, 0.01),
    "TransformReward": lambda env: wrappers.TransformReward(env, lambda reward: 2 * float(reward)),
    "NormalizeReward": wrappers.NormalizeReward,
    "TimeLimit": lambda env: wrappers.TimeLimit(env, 7),
    "Autoreset": wrappers.Autoreset,
    "PassiveEnvChecker": wrappers.PassiveEnvChecker,
    "OrderEnforcing": wrappers.OrderEnforcing,
    "RecordEpisodeStatistics": wrappers.RecordEpisodeStatistics,
}
DRAWN: dict[str, Wrap] = {
    "AddRenderObservation": drawn,
    "FilterObservation": lambda env: wrappers.FilterObservation(
        wrappers.AddRenderObservation(env, render_only=False), ["state"]
    ),
    "GrayscaleObservation": lambda env: wrappers.GrayscaleObservation(drawn(env)),
    "AddWhiteNoise": lambda env: wrappers.AddWhiteNoise(env, 0.1),
    "ObstructView": lambda env: wrappers.ObstructView(env, 0.1, 8),
    "RenderCollection": wrappers.RenderCollection,
    "HumanRendering": wrappers.HumanRendering,
}
ELSEWHERE = {  # in libraries/gymnasium.py, since they need more packages than our tests
    "ArrayConversion",
    "NumpyToTorch",
    "RecordVideo",
    "ResizeObservation",
}
UNFIT = {"AtariPreprocessing", "JaxToNumpy", "JaxToTorch"}  # an emulator; an environment in JAX

KNOWN = [name for name in wrappers.__all__ if name in PLAIN or (DRAWS and name in DRAWN)]


def test_every_wrapper_of_gymnasiums_is_tried_or_named():
    assert set(wrappers.__all__) - {"vector"} <= {*PLAIN, *DRAWN, *ELSEWHERE, *UNFIT}


def made(view: str, name: str, **keywords: Any) -> Any:
    mode = "rgb_array" if name in DRAWN else None
    keywords = {"task": EASY_TASKS[view], "horizon": 12, "render_mode": mode, **keywords}
    return gymnasium.make(view, **keywords)


@pytest.mark.parametrize(("view", "name"), around_ids(KNOWN))
def test_a_wrapped_environment_keeps_its_spaces_seed_and_infos(view, name, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    wrap = {**PLAIN, **DRAWN}[name]
    env, twin = (wrap(made(view, name)) for _ in "ab")
    assert names(env)[0] == name
    assert env.unwrapped.spec.id == view
    begun, first = env.reset(seed=3)
    assert data_equivalence(twin.reset(seed=3), (begun, first), exact=True)
    assert begun in env.observation_space
    for action in drawn_actions(env, 4 if name in DRAWN else 20):
        step, other = env.step(action), twin.step(action)
        for told in (step[-1], other[-1]):
            told.get("episode", {}).pop("t", None)  # the clock's time
        assert data_equivalence(other, step, exact=True)
        assert step[0] in env.observation_space
        assert np.isfinite(step[1])
        assert step[-1].keys() >= first.keys()
        if (step[2] or step[3]) and name != "Autoreset":
            assert data_equivalence(env.reset(), twin.reset(), exact=True)
    if name in DRAWN and name != "HumanRendering":
        assert data_equivalence(env.render(), twin.render(), exact=True)
    env.close()
