"""Trainings of other algorithms than PPO that take a second or so."""

from pathlib import Path

from coopenv.agents.algorithms import RecurrentConfig, SACConfig
from coopenv.agents.settings import TrainConfig

SMALL = {
    "sac": SACConfig(steps=512, num_worlds=4, random_steps=128, batch_size=16, hidden=(8,)),
    "recurrent": RecurrentConfig(
        steps=512, num_worlds=4, rollout=16, batch_size=32, epochs=1, units=8, hidden=(8,)
    ),
}


def run_in(out: Path, **changes) -> TrainConfig:
    """What a run is told beside its recipe."""
    return TrainConfig(**{"out": out, "seed": 1, **changes})
