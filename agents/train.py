"""Training with PPO: logs, curves and checkpoints that a killed run goes on from."""

import json
import zipfile
from collections import deque
from collections.abc import Callable
from itertools import chain
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from coopenv.config import TransportConfig
from coopenv.errors import InvalidInput, MissingExtra
from coopenv.files import written

from . import curves
from .curves import Row
from .sb3 import FallingRate, SB3Policy, Scaled, TransportVecEnv, feature_scale
from .seeds import BLOCK, training_seeds
from .settings import EnvironmentChoice, TrainConfig

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback
except ImportError as error:
    raise MissingExtra("coopenv.agents.train", "train") from error

__all__ = ["EnvironmentChoice", "TrainConfig", "train"]

_NOTES = "coopenv.json"  # what a checkpoint holds beside SB3's own: curves so far, configuration


def train(
    config: TrainConfig,
    *,
    environment: TransportConfig | None = None,
    report: Callable[[Row], None] | None = None,
) -> SB3Policy:
    """Train a policy and leave it in ``config.out``.

    Written there: ``policy.zip`` (`SB3Policy.load`, or ``PPO.load``), ``config.json``,
    ``curves.csv``, ``curves.png``, ``tensorboard/``, and while it runs ``checkpoint.zip``, with
    which the next call of the same configuration goes on. Episodes that ran when it was killed
    begin anew, so a run that was killed does not give the same bits as one that was not.

    Parameters
    ----------
    config
        Of the run.
    environment
        Instead of the one that ``config.environment`` names.
    report
        Called with the newest row of the curves after every rollout.

    Raises
    ------
    InvalidInput
        If ``config.out`` holds a checkpoint of another configuration.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(config.threads)
    try:
        return _train(config, environment or config.environment.config(), report)
    finally:
        torch.set_num_threads(threads)


def _train(
    config: TrainConfig, environment: TransportConfig, report: Callable[[Row], None] | None
) -> SB3Policy:
    venv = TransportVecEnv(environment, config.num_worlds, control=config.control)
    per_step = venv.num_envs // config.num_worlds  # rows of the VecEnv a control step of a world
    checkpoint = config.out / "checkpoint.zip"
    if config.fresh:
        checkpoint.unlink(missing_ok=True)
    model, rows = _resume(config, venv) if checkpoint.exists() else (_begin(config, venv), [])
    config.save(config.out / "config.json")
    model.learn(
        max(0, config.steps * per_step - model.num_timesteps),
        callback=_Log(config, environment.horizon, per_step, rows, report),
        reset_num_timesteps=model.num_timesteps == 0,
        tb_log_name="ppo",
    )
    policy = SB3Policy(model)
    policy.save(config.out / "policy.zip")
    curves.save_rows(rows, config.out / "curves.csv")
    curves.draw({"": [rows]}, config.out / "curves.png")
    checkpoint.unlink(missing_ok=True)
    venv.close()
    return policy


def _begin(config: TrainConfig, venv: TransportVecEnv) -> PPO:
    scale = feature_scale(venv)
    model = PPO(
        "MlpPolicy",
        venv,
        n_steps=config.rollout,
        batch_size=min(config.batch_size, config.rollout * venv.num_envs),
        n_epochs=config.epochs,
        learning_rate=FallingRate(config.learning_rate),
        gamma=config.discount,
        gae_lambda=config.gae_lambda,
        clip_range=config.clip_range,
        ent_coef=config.entropy_weight,
        tensorboard_log=str(config.out / "tensorboard"),
        policy_kwargs={
            "net_arch": list(config.hidden),
            "log_std_init": float(np.log(config.initial_std)),
            "features_extractor_class": Scaled,
            "features_extractor_kwargs": {"scale": scale},
        },
        seed=config.seed,
        device="cpu",
    )
    _seed_worlds(config, venv, steps=0)  # after PPO, which seeds them as well
    return model


def _resume(config: TrainConfig, venv: TransportVecEnv) -> tuple[PPO, list[Row]]:
    """The model as it was at the last checkpoint, and the curves up to there."""
    path = config.out / "checkpoint.zip"
    with zipfile.ZipFile(path) as archive:
        notes = json.loads(archive.read(_NOTES))
    if notes["config"] != config.identity():
        differing = [
            name for name, value in config.identity().items() if notes["config"].get(name) != value
        ]
        raise InvalidInput(
            f"out must hold no checkpoint of another run, got {path} which differs in "
            f"{', '.join(differing)}; choose another out, or start over with fresh=True (--fresh)"
        )
    model = PPO.load(path, env=venv, device="cpu")
    model.set_random_seed(config.seed + model.num_timesteps)
    _seed_worlds(config, venv, steps=model.num_timesteps)
    return model, notes["rows"]


def _seed_worlds(config: TrainConfig, venv: TransportVecEnv, *, steps: int) -> None:
    """World seeds of this run's block; a resumed run takes others than it began with."""
    first = training_seeds(config.seed, config.num_worlds)[0]
    venv.seed(first + steps % (BLOCK - config.num_worlds))


def _save_checkpoint(path: Path, model: PPO, config: TrainConfig, rows: list[Row]) -> None:
    notes = json.dumps({"config": config.identity(), "rows": rows})
    with written(path) as part:
        with part.open("wb") as file:
            model.save(file)
        with zipfile.ZipFile(part, "a") as archive:
            archive.writestr(_NOTES, notes)


class _Log(BaseCallback):
    """Turns the episodes that ended lately into one row of the curves a rollout.

    Lately: in as many rollouts as an episode may last. In a shorter while those that end are
    mostly the short ones, that is, the successful.
    """

    def __init__(
        self,
        config: TrainConfig,
        horizon: int,
        per_step: int,
        rows: list[Row],
        report: Callable[[Row], None] | None,
    ):
        super().__init__()
        self._config, self._per_step, self._rows = config, per_step, rows
        self._report = report if report is not None else lambda row: None
        self._ended: deque[list[dict[str, Any]]] = deque(maxlen=ceil(horizon / config.rollout))
        self._updates = 0

    def _on_rollout_start(self) -> None:
        if self._updates and self._updates % self._config.checkpoint_every == 0:
            path = self._config.out / "checkpoint.zip"
            assert isinstance(self.model, PPO)
            _save_checkpoint(path, self.model, self._config, self._rows)
        self._updates += 1
        self._ended.append([])

    def _on_step(self) -> bool:
        self._ended[-1] += [info for info in self.locals["infos"] if info]
        return True

    def _on_rollout_end(self) -> None:
        row: Row = {
            "steps": self.num_timesteps // self._per_step,
            **episode_means(list(chain(*self._ended))),
        }
        for name, value in row.items():
            self.logger.record(f"episode/{name}", value)
        self._rows.append(row)
        self._report(row)


def episode_means(ended: list[dict[str, Any]]) -> Row:
    """Means over the infos of ended episodes; nothing where none ended."""
    if not ended:
        return {}
    episodes = [info["episode"] for info in ended]
    means = {
        name: float(np.nanmean([episode[name] for episode in episodes]))
        for name in episodes[0]
        if name != "t"
    }
    success = float(np.mean([info["is_success"] for info in ended]))
    renamed = {"reward": means.pop("r"), "length": means.pop("l")}
    return {"episodes": len(episodes), "success": success, **renamed, **means}
