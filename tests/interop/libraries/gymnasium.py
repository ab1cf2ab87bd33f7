"""Gymnasium: vectors of spawned processes, and the wrappers that need more than our tests have."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium import wrappers
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from gymnasium.wrappers import vector

import coopenv  # noqa: F401 - whose ids Gymnasium then knows

IDS = [
    "coopenv/BeamTransport-v0",
    "coopenv/BeamDoorway-v0",
    "coopenv/BeamTracking-v0",
    "coopenv/WalkerTurn-v0",
    "coopenv/WalkerAvoid-v0",
    "coopenv/BeamLift-v0",
]


def main() -> None:
    """Run all of it, and print one line of JSON."""
    for view in IDS:
        convert(view)
        resize(view)
        with TemporaryDirectory() as folder:
            film(view, Path(folder))
    for view in IDS[::4]:
        spawn(view)
    checked = (
        "AsyncVectorEnv with spawn returns what SyncVectorEnv does, infos too; NumpyToTorch, "
        "ArrayConversion, ResizeObservation and RecordVideo around one world and around many"
    )
    version = gymnasium.__version__
    told = {"library": "Gymnasium", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def spawn(view: str) -> None:
    """Two processes that know nothing of this one: the id says which module registers it."""
    makers = [lambda: gymnasium.make(f"coopenv:{view}", horizon=4) for _ in range(2)]
    apart, near = AsyncVectorEnv(makers, context="spawn"), SyncVectorEnv(makers)
    try:
        assert data_equivalence(apart.reset(seed=1), near.reset(seed=1), exact=True)
        near.action_space.seed(0)
        for _ in range(6):
            action = near.action_space.sample()
            assert data_equivalence(apart.step(action), near.step(action), exact=True)
    finally:
        apart.close()


def convert(view: str) -> None:
    """Tensors in and out, of one world and of many."""
    kinds: list[tuple[Any, Any]] = [
        (wrappers.NumpyToTorch, gymnasium.make),
        (vector.NumpyToTorch, gymnasium.make_vec),
        (lambda env: wrappers.ArrayConversion(env, np, torch), gymnasium.make),
        (lambda env: vector.ArrayConversion(env, np, torch), gymnasium.make_vec),
    ]
    for around, make in kinds:
        env, plain = around(make(view)), make(view)
        obs, info = env.reset(seed=3)
        np.testing.assert_array_equal(obs.numpy(), plain.reset(seed=3)[0])
        assert isinstance(info["internal_wrench"], torch.Tensor)
        plain.action_space.seed(0)
        for _ in range(3):
            action = plain.action_space.sample()
            got, wanted = env.step(torch.from_numpy(action)), plain.step(action)
            np.testing.assert_array_equal(got[0].numpy(), wanted[0], strict=True)
            np.testing.assert_allclose(np.asarray(got[1]), wanted[1], rtol=1e-6)
            assert got[4].keys() == wanted[4].keys()


def resize(view: str) -> None:
    """Pictures as observations, of a size that a network takes."""
    env: Any = wrappers.ResizeObservation(
        wrappers.AddRenderObservation(gymnasium.make(view, render_mode="rgb_array")), (64, 84)
    )
    obs, _ = env.reset(seed=0)
    assert obs in env.observation_space
    assert obs.shape == (64, 84, 3)
    env.close()


def film(view: str, folder: Path) -> None:
    """Videos of one world and of many side by side."""
    single: Any = gymnasium.make(view, render_mode="rgb_array", horizon=4)
    many: Any = gymnasium.make_vec(view, num_envs=4, render_mode="rgb_array", horizon=4)
    for name, env in (
        ("one", wrappers.RecordVideo(single, str(folder / "one"), episode_trigger=is_first)),
        ("many", vector.RecordVideo(many, str(folder / "many"), episode_trigger=is_first)),
    ):
        env.reset(seed=0)
        for _ in range(4):
            env.step(env.action_space.sample())
        env.close()
        assert next((folder / name).glob("*.mp4")).stat().st_size > 1000


def is_first(episode: int) -> bool:
    return episode == 0


if __name__ == "__main__":
    main()
