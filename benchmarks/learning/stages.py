"""Stages of the search for PPO's settings: from where each began and what it changed."""

from typing import Any

Settings = dict[str, Any]
SEEDS = (100, 101)  # of trainings; no other table has them

WARM: Settings = {"num_worlds": 64, "rollout": 8, "steps": 1024}
BEFORE: Settings = {
    "num_worlds": 64,
    "rollout": 128,
    "batch_size": 2048,
    "epochs": 10,
    "learning_rate": 1e-3,
    "discount": 0.99,
    "gae_lambda": 0.95,
    "initial_std": 0.6,
    "hidden": [64, 64],
}
WIDE: Settings = {**BEFORE, "num_worlds": 256, "rollout": 32}
FEWER: Settings = {**WIDE, "epochs": 5}
WIDER: Settings = {**FEWER, "initial_std": 1.0}

STAGES: dict[str, tuple[Settings, list[Settings]]] = {
    "worlds": (BEFORE, [{}, {"num_worlds": 256, "rollout": 32}]),
    "updates": (WIDE, [{"rollout": 16}, {"epochs": 5}, {"learning_rate": 3e-3, "epochs": 5}]),
    "discount": (WIDE, [{"discount": 0.97}, {"discount": 0.95}]),
    "small updates": (FEWER, [{"rollout": 16, "batch_size": 1024}]),
    "exploration": (FEWER, [{"initial_std": 0.4}, {"initial_std": 1.0}]),
    "clipping": (FEWER, [{"clip_range": 0.3}, {"clip_range": 0.4}]),
    "to the end": (
        FEWER,
        [{"steps": 200_000}, {"steps": 200_000, "learning_rate": 2e-3}, {"steps": 300_000}],
    ),
    "to the end, wider": (WIDER, [{"steps": 300_000}]),
    "to the end, before": (BEFORE, [{"steps": 600_000}]),
}
