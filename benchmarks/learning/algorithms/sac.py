"""SAC of Stable-Baselines3 with one policy for the team."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from benchmarks.learning.algorithms.curve import Curve
from benchmarks.learning.algorithms.models import learned
from coopenv.agents.algorithms import SACConfig
from coopenv.agents.sb3 import SB3Policy

OF: Mapping[str, Mapping[str, Any]] = {  # what differs from a `SACConfig`'s defaults
    "BeamTransport": {"steps": 150_000},
    "BeamTracking": {"steps": 100_000},
    "WalkerTurn": {"steps": 400_000},
    "BeamDoorway": {"steps": 600_000},
    "WalkerAvoid": {"steps": 400_000},
    "BeamLift": {"steps": 400_000},
}
BY_HANDS: Mapping[str, Mapping[str, Any]] = {  # longer where hands move the body
    "BeamTransport": {"steps": 300_000},
    "BeamTracking": {"steps": 200_000},
    "BeamDoorway": {"steps": 1_000_000},
    "WalkerAvoid": {"steps": 1_600_000},
}


def settings(env: str, action: str | None = None) -> dict[str, Any]:
    """Those with which it is trained: of a `SACConfig`."""
    by_hands = BY_HANDS.get(env, {}) if action else {}
    return asdict(SACConfig(**{**OF[env], **by_hands}))


def learn(
    env: str, seed: int, given: dict[str, Any], action: str | None = None
) -> tuple[SB3Policy, Curve]:
    """Train with such settings of a `SACConfig`."""
    return learned(SACConfig(**given), env, seed, action)
