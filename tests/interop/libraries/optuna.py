"""Optuna: a study over a reward's weight and a learning rate, trials pruned as they run."""

import json

import numpy as np
import optuna
import torch
from stable_baselines3 import PPO

from coopenv import rewards
from coopenv.agents import sb3

IDS = ["coopenv/BeamTransport-v0", "coopenv/BeamTracking-v0"]


def main() -> None:
    """Run all of it, and print one line of JSON."""
    torch.set_num_threads(1)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    for view in IDS:
        search(view)
    checked = (
        "a study of three trials over learning rate and the weight of a reward term, with "
        "intermediate values; the best trial's parameters give its value again"
    )
    version = optuna.__version__
    told = {"library": "Optuna", "version": version, "ids": IDS, "checked": checked}
    print(json.dumps(told))


def search(view: str) -> None:
    """Three short trainings."""
    study = optuna.create_study(
        direction="maximize",
        sampler=optuna.samplers.TPESampler(seed=0),
        pruner=optuna.pruners.MedianPruner(),
    )
    study.optimize(lambda trial: train(view, trial), n_trials=3)
    assert len(study.trials) == 3
    assert study.best_trial.intermediate_values
    assert len({trial.params["rate"] for trial in study.trials}) == 3
    again = train(view, optuna.trial.FixedTrial(study.best_params))
    assert again == study.best_value


def train(view: str, trial: optuna.trial.BaseTrial) -> float:
    """Mean return of the last episodes of a short training."""
    squeeze = rewards.InternalForce(weight=trial.suggest_float("weight", 0.001, 0.1, log=True))
    reward = rewards.RewardSum({"progress": rewards.Progress(), "squeeze": squeeze})
    rate = trial.suggest_float("rate", 1e-4, 1e-2, log=True)
    venv = sb3.make_vec_env(view, 8, seed=0, horizon=16, reward=reward)
    model = PPO(
        "MlpPolicy", venv, n_steps=32, batch_size=128, n_epochs=1, learning_rate=rate, seed=0
    )
    value = 0.0
    for step in range(2):
        model.learn(256, reset_num_timesteps=False)
        value = float(np.mean([episode["r"] for episode in model.ep_info_buffer]))
        trial.report(value, step)
        if trial.should_prune():
            raise optuna.TrialPruned
    return value


if __name__ == "__main__":
    main()
