"""Rewards and costs drawn at random: presets, and sums of any terms."""

from typing import Any

import numpy as np

from coopenv import TransportConfig, rewards
from coopenv.wrench import Settings

_OTHER = Settings(torque_weight=0.3, include_induced=True)
TERMS = {
    "success": rewards.Success(),
    "time": rewards.TimeCost(),
    "effort": rewards.Effort(),
    "force": rewards.InternalForce(weight=0.3),
    "other_force": rewards.InternalForce(settings=_OTHER),
    "torque": rewards.InternalTorque(weight=0.3),
    "relative": rewards.RelativeCost(),
    "other_relative": rewards.RelativeCost(settings=Settings(method="moore_penrose")),
    "wasted": rewards.WastedCost(),
    "power": rewards.InternalPower(),
    "force_share": rewards.LoadShare(),
    "torque_share": rewards.LoadShare(of="torque", scale=None),
    "rate": rewards.ActionRate(),
    "contact": rewards.Contact(),
    "tracking": rewards.TrackingError(),
    "progress": rewards.Progress(discount=0.99),
}


def any_reward(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """A preset, or some of `TERMS`."""
    if rng.random() < 0.3:
        return {"reward": str(rng.choice(list(rewards.PRESETS)))}
    return {"reward": _some(rng)}


def any_cost(rng: np.random.Generator, env: str, config: TransportConfig) -> dict[str, Any]:
    """One by its name, or some of `TERMS`."""
    named = str(rng.choice(list(rewards.COSTS)))
    return {"cost": named if rng.random() < 0.3 else _some(rng)}


def _some(rng: np.random.Generator) -> dict[str, Any]:
    some = rng.permutation(list(TERMS))[: rng.integers(1, len(TERMS) + 1)]
    return {name: TERMS[name] for name in some.tolist()}
