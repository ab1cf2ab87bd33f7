"""Reward terms, their sums, potential shaping and presets.

A term is a function of a `coopenv.transition.Transition` that returns ``(world, agent)``; its
weight lives in it. A `RewardSum` names the terms and reports each beside the total.
"""

from .energy import InternalPower, StoredEnergy
from .presets import COSTS, PRESETS, find_cost, find_reward
from .shaping import Potential, PotentialShaping, Progress, closeness
from .sums import RewardSum, Term, recompute
from .terms import (
    ActionRate,
    Contact,
    Effort,
    InternalForce,
    InternalTorque,
    LoadShare,
    RelativeCost,
    Success,
    TimeCost,
    TrackingError,
    WastedCost,
)

__all__ = [
    "COSTS",
    "PRESETS",
    "ActionRate",
    "Contact",
    "Effort",
    "InternalForce",
    "InternalPower",
    "InternalTorque",
    "LoadShare",
    "Potential",
    "PotentialShaping",
    "Progress",
    "RelativeCost",
    "RewardSum",
    "StoredEnergy",
    "Success",
    "Term",
    "TimeCost",
    "TrackingError",
    "WastedCost",
    "closeness",
    "find_cost",
    "find_reward",
    "recompute",
]
