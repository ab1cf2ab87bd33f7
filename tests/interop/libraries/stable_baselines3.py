"""Stable-Baselines3: PPO on our own ``VecEnv``, SAC and TD3 on its own, and its wrappers."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import stable_baselines3
import torch
from stable_baselines3 import PPO, SAC, TD3
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize, VecVideoRecorder

import coopenv
from coopenv.agents import sb3

IDS = ["coopenv/BeamTransport-v0", "coopenv/BeamDoorway-v0"]
EASY = coopenv.TransportTask(position_tolerance=0.5, angle_tolerance=0.6, speed_tolerance=1.0)


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    before, after = learn()
    assert after > before + 0.5, (before, after)
    with TemporaryDirectory() as folder:
        for view in IDS:
            normalise_and_evaluate(view, Path(folder) / "ppo")
            for algorithm in (SAC, TD3):
                go_off_policy(view, algorithm)
        film(Path(folder))
    checked = (
        "PPO's return rises in 60,000 steps; VecNormalize, VecMonitor and EvalCallback report "
        "success; SAC and TD3 learn and come back from a file; VecVideoRecorder writes"
    )
    version = stable_baselines3.__version__
    told = {"library": "Stable-Baselines3", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def learn() -> tuple[float, float]:
    """Mean return of PPO before and after 60,000 steps."""
    venv = VecMonitor(sb3.make_vec_env(IDS[0], 64, task=EASY, seed=0))
    model = PPO(
        "MlpPolicy", venv, n_steps=64, batch_size=1024, n_epochs=8, learning_rate=1e-3, seed=0
    )
    before, _ = evaluate_policy(model, venv, n_eval_episodes=64)
    model.learn(60_000)
    after, _ = evaluate_policy(model, venv, n_eval_episodes=64)
    return float(before), float(after)


def normalise_and_evaluate(view: str, folder: Path) -> None:
    """PPO under running statistics, evaluated meanwhile; a reloaded model acts alike."""
    train = VecNormalize(VecMonitor(sb3.make_vec_env(view, 8, seed=0, horizon=30)))
    held = VecNormalize(VecMonitor(sb3.make_vec_env(view, 2, seed=9, horizon=30)), training=False)
    report = EvalCallback(held, n_eval_episodes=4, eval_freq=64, log_path=str(folder), verbose=0)
    model = PPO("MlpPolicy", train, n_steps=64, batch_size=256, n_epochs=2, seed=0)
    start = model.policy.mlp_extractor.policy_net[0].weight.detach().clone()
    model.learn(1024, callback=report)
    assert not torch.equal(start, model.policy.mlp_extractor.policy_net[0].weight)
    assert len(model.ep_success_buffer) > 0
    with np.load(folder / "evaluations.npz") as told:
        assert told["successes"].shape == told["results"].shape == (2, 4)
    train.save(str(folder / "statistics.pkl"))
    model.save(folder / "model.zip")
    train.training = False
    obs = train.reset()
    again = VecNormalize.load(str(folder / "statistics.pkl"), sb3.make_vec_env(view, 8))
    raw = train.get_original_obs()
    np.testing.assert_array_equal(again.normalize_obs(raw), obs)
    mine, _ = model.predict(obs, deterministic=True)
    theirs, _ = PPO.load(folder / "model.zip").predict(obs, deterministic=True)
    np.testing.assert_array_equal(mine, theirs)


def go_off_policy(view: str, algorithm: type[SAC] | type[TD3]) -> None:
    """A replay buffer filled by SB3's own vectors of the Gymnasium view."""
    envs = make_vec_env(view, n_envs=2, seed=0, env_kwargs={"horizon": 25})
    model = algorithm(
        "MlpPolicy", envs, learning_starts=60, buffer_size=2000, batch_size=32, seed=0,
        policy_kwargs={"net_arch": [32]},
    )  # fmt: skip
    start = [weight.detach().clone() for weight in model.actor.parameters()]
    model.learn(240)
    moved = [not torch.equal(a, b) for a, b in zip(start, model.actor.parameters(), strict=True)]
    assert any(moved)
    assert model.replay_buffer.dones.sum() > 0
    assert model.replay_buffer.timeouts.sum() > 0
    with TemporaryDirectory() as folder:
        model.save(f"{folder}/model")
        again = algorithm.load(f"{folder}/model")
    obs = envs.reset()
    mine, theirs = (one.predict(obs, deterministic=True)[0] for one in (model, again))
    assert mine.shape == (2, *envs.action_space.shape)
    np.testing.assert_array_equal(mine, theirs)


def film(folder: Path) -> None:
    """A video of worlds side by side."""
    venv = VecVideoRecorder(
        sb3.make_vec_env(IDS[0], 2, render_mode="rgb_array"),
        str(folder / "videos"),
        record_video_trigger=lambda step: step == 0,
        video_length=5,
    )
    venv.reset()
    for _ in range(7):
        venv.step(np.zeros((2, *venv.action_space.shape)))
    venv.close()
    (video,) = (folder / "videos").glob("*.mp4")
    assert video.stat().st_size > 1000


if __name__ == "__main__":
    main()
