"""What is tried in the search of SAC's settings: one factor at a time, and some together."""

from collections.abc import Mapping
from typing import Any

from benchmarks.learning.algorithms.sac import Recipe

SEED = 100  # of trainings that no table has
START = Recipe(
    steps=200_000,
    num_worlds=64,
    gradient_steps=2,
    batch_size=256,
    learning_rate=1e-3,
    falling=False,
    discount=0.98,
    entropy="auto_0.1",
    target_entropy="auto",
    hidden=(64, 64),
    tau=0.01,
    random_steps=5_000,
    n_steps=1,
    buffer=300_000,
    scaled=True,
)
DEFAULTS: Mapping[str, Any] = {  # of Stable-Baselines3
    "gradient_steps": 1,
    "learning_rate": 3e-4,
    "discount": 0.99,
    "entropy": "auto",
    "hidden": [256, 256],
    "tau": 0.005,
    "random_steps": 100,
    "scaled": False,
}
CHANGES: tuple[Mapping[str, Any], ...] = (
    {},
    {"entropy": 0.02},
    {"entropy": 0.02, "falling": True, "steps": 100_000},
    {"entropy": 0.02, "n_steps": 3},
    {"entropy": 0.02, "learning_rate": 2e-3, "gradient_steps": 1, "batch_size": 512},
    DEFAULTS,
)
