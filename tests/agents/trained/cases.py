"""Policies in plain numbers without a learning library: a network with random weights."""

import json
from typing import Any

import gymnasium
import numpy as np

from coopenv import TransportConfig
from coopenv.agents.trained.form import Form
from coopenv.observation import Observation
from tests.helpers import EASY

CONFIG = TransportConfig(task=EASY, horizon=6)
WIDTH = 8


def plain(config: TransportConfig = CONFIG, control: str = "joint", **notes: Any) -> Form:
    """Two layers, for the whole team or for one agent, with the record of its environment."""
    rows = config.num_agents if control == "joint" else 1
    features, actions = rows * Observation(config.observe, config.num_agents).size, 3 * rows
    rng = np.random.default_rng(0)
    arrays = {
        "scale": np.full(features, 0.5, dtype=np.float32),
        "first.weight": rng.normal(size=(WIDTH, features)).astype(np.float32) / 4,
        "first.bias": rng.normal(size=WIDTH).astype(np.float32),
        "last.weight": rng.normal(size=(actions, WIDTH)).astype(np.float32) / 4,
        "log_std": np.full(actions, -1, dtype=np.float32),
    }
    said = {
        "scale": "scale",
        "layers": [["first.weight", "first.bias", "tanh"], ["last.weight", None, "identity"]],
        "output": "clip",
        "spread": "log_std",
    }
    box = gymnasium.spaces.Box
    spaces = box(-np.inf, np.inf, (features,)), box(-1, 1, (actions,))
    record = {
        "format": 1,
        "environment": json.loads(config.to_json()),
        "training": {"control": control, "environment": {"env": "coopenv/BeamTransport-v0"}},
        "versions": {},
        "command": [],
    }
    return Form.of(
        said,
        spaces,
        arrays,
        algorithm="stable_baselines3.ppo.ppo:PPO",
        normalization=None,
        blueprint={"format": 1, "needs_trust": "nothing at all"},
        notes={"provenance": record, **notes},
    )
