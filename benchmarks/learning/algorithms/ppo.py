"""PPO with one policy for the team, as ``coopenv train`` trains it.

Its runs are those of `benchmarks.learning.baselines`; here it is for the search of settings.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.learning.algorithms.curve import Curve
from coopenv.agents.policy import Policy
from coopenv.agents.train import train
from coopenv.agents.training.presets import train_config
from coopenv.envs.registry import PREFIX

TAKEN = ("steps", "num_worlds", "rollout", "epochs", "batch_size", "learning_rate")


def settings(env: str) -> dict[str, Any]:
    """Those that are searched, as ``coopenv train`` has them."""
    config = train_config(f"{PREFIX}{env}-v0")
    return {name: getattr(config, name) for name in TAKEN}


def learn(env: str, seed: int, given: dict[str, Any]) -> tuple[Policy, Curve]:
    """Train with such settings."""
    with TemporaryDirectory() as folder:
        whole = f"{PREFIX}{env}-v0"
        config = train_config(whole, seed=seed, out=Path(folder) / "run", **given)
        curve = Curve(config.environment.config().horizon, config.num_worlds)
        return train(config, report=curve.take), curve
