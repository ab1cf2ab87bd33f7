"""Trials of pairs whose internal torque and load shares are known."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

GUIDES = ("one", "both", "none")
DT = 0.05  # [s]
STEPS = 40
FORCE, TORQUE = 4.0, 2.0  # [N], [N·m] on the object


UNDONE = {"one": 0.3, "both": 0.2, "none": 0.5}  # [N·m]


def undone(pair, guide, trial, time):
    """Differs by pair, guide and trial; five times as much after 0.6 s."""
    level = UNDONE[guide] + 0.02 * pair * (1 + (guide == "none")) + 0.05 * (trial - 1)
    return np.where(time < 0.6 - 1e-9, level, 5 * level)


def steady_shares(pair: int, guide: str, trial: int, time: np.ndarray):
    """Force and torque share of agent 1 over time."""
    return np.full(len(time), 0.5), np.ones(len(time))


def no_disagreement(pair: int, guide: str, trial: int, time: np.ndarray):
    """Torque of agent 1 that agent 2 undoes, over time [N·m]."""
    return np.zeros(len(time))


def varied(pair, guide, trial, time):
    """As `undone`, in some trials the other way, where the methods differ by pair and guide."""
    generator = np.random.default_rng([pair, GUIDES.index(guide), trial])
    return undone(pair, guide, trial, time) * generator.uniform(-1.5, 1.0)


def make_trials(
    pairs: int = 6,
    trials: int = 3,
    *,
    shares: Callable = steady_shares,
    disagreement: Callable = no_disagreement,
    spin: float = 1.0,
    first: Callable[[int, str, int], int] = lambda pair, guide, trial: 1,
) -> Any:
    """Forces along the beam and pure torques; the beam turns at ``spin`` [rad/s].

    With a torque share of 1, T_I is the disagreement d for ours and the point mass, and
    d + TORQUE / 2 for both pseudoinverses and the virtual linkage.
    """
    parts = []
    for pair in range(pairs):
        for guide in GUIDES:
            for trial in range(trials):
                time = DT * np.arange(STEPS)
                force, torque = shares(pair, guide, trial, time)
                undone = disagreement(pair, guide, trial, time)
                parts.append(
                    pd.DataFrame(
                        {
                            "pair": pair,
                            "condition": guide,
                            "trial": trial,
                            "time": 7.0 + time,
                            "x": 0.5 * time,
                            "y": 0.0,
                            "theta": 3.0 + spin * time,
                            "f1x": force * FORCE,
                            "f1y": 0.0,
                            "t1z": torque * TORQUE + undone,
                            "f2x": (1 - force) * FORCE,
                            "f2y": 0.0,
                            "t2z": (1 - torque) * TORQUE - undone,
                            "r1x": -1.0,
                            "r1y": 0.0,
                            "r2x": 1.0,
                            "r2y": 0.0,
                            "first": first(pair, guide, trial),
                        }
                    )
                )
    table = pd.concat(parts, ignore_index=True)
    wrapped = np.pi - (np.pi - table["theta"]) % (2 * np.pi)
    return table.assign(theta=wrapped)
