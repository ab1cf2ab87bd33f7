"""A run that takes a second or so."""

from pathlib import Path

from coopenv import TransportConfig
from coopenv.agents.settings import TrainConfig

SHORT = TransportConfig(horizon=8)


def tiny(out: Path, **changes) -> TrainConfig:
    """Four rollouts of 32 steps."""
    given = {"steps": 128, "num_worlds": 4, "rollout": 8, "batch_size": 16, "epochs": 1}
    return TrainConfig(**{**given, "hidden": (8,), "out": out, **changes})
