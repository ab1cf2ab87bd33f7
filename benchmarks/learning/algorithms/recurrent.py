"""Recurrent PPO of sb3-contrib with one policy for the team.

Its settings are those of `coopenv.agents.algorithms.RecurrentConfig` but for `OF`.
"""

from collections.abc import Mapping
from typing import Any

from benchmarks.learning.algorithms.curve import Curve
from benchmarks.learning.algorithms.models import learned
from coopenv.agents.algorithms import RecurrentConfig
from coopenv.agents.sb3 import SB3Policy

MORE = {"num_worlds": 64, "rollout": 128}  # longer sequences, and four times as many updates
OF: Mapping[str, Mapping[str, Any]] = {  # what differs from `START`, by the search
    "BeamTransport": {"steps": 300_000, **MORE, "epochs": 10},
    "BeamTracking": {"steps": 300_000},
    "WalkerTurn": {"steps": 500_000, **MORE, "epochs": 10},
    "BeamDoorway": {"steps": 1_200_000, **MORE, "epochs": 10},
    "WalkerAvoid": {"steps": 600_000, **MORE, "epochs": 10},
    "BeamLift": {"steps": 1_800_000, **MORE, "residual": True},
}
BY_HANDS: Mapping[str, Mapping[str, Any]] = {  # longer where hands move the body
    "BeamTransport": {"steps": 600_000},
    "BeamTracking": {"steps": 600_000},
    "BeamDoorway": {"steps": 2_400_000},
    "WalkerAvoid": {"steps": 1_200_000},
}
SEARCHED = ("units", "residual", "num_worlds", "rollout", "epochs", "batch_size", "learning_rate")
START = {name: getattr(RecurrentConfig(), name) for name in SEARCHED}


def settings(env: str, action: str | None = None) -> dict[str, Any]:
    """Those with which it is trained."""
    by_hands = BY_HANDS.get(env, {}) if action else {}
    return {**START, **OF[env], **by_hands}


def learn(
    env: str, seed: int, given: dict[str, Any], action: str | None = None
) -> tuple[SB3Policy, Curve]:
    """Train with such settings of a `RecurrentConfig`."""
    return learned(RecurrentConfig(**given), env, seed, action)
