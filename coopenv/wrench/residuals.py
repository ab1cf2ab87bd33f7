"""Residuals: by how much a split breaks balance and the balls of plausibility."""

from typing import NamedTuple

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.grasp import moment, sum_at_centre


class Residuals(NamedTuple):
    """By how much a decomposition breaks its constraints, per sample ``(...)``; 0 is perfect."""

    balance: FloatArray  # largest component of |G h_M − G h| [N or N·m]
    force: FloatArray  # largest excess of a force over its ball (19) [N]
    induced_torque: FloatArray  # of an induced torque (20) [N·m]
    torque: FloatArray  # of a pure torque (21) [N·m]


def residuals_of(applied: FloatArray, manipulation: FloatArray, grips: FloatArray) -> Residuals:
    """Return by how much a manipulation wrench breaks balance (18) and the balls (19)-(21).

    The ball form is max(0, ‖x_M − x/2‖ − ‖x‖/2), the largest over the effectors. Methods that are
    not plausible have large ones; the virtual linkage need not even balance.
    """
    dimension = grips.shape[-1]
    balance = sum_at_centre(manipulation, grips) - sum_at_centre(applied, grips)
    parts = [
        _ball_excess(part(manipulation), part(applied))
        for part in (
            lambda wrench: wrench[..., :dimension],
            lambda wrench: moment(grips, wrench),
            lambda wrench: wrench[..., dimension:],
        )
    ]
    return Residuals(np.abs(balance).max(axis=-1), *parts)


def _ball_excess(manipulation: FloatArray, applied: FloatArray) -> FloatArray:
    distance = np.linalg.norm(manipulation - 0.5 * applied, axis=-1)
    excess = distance - 0.5 * np.linalg.norm(applied, axis=-1)
    return np.maximum(excess, 0.0).max(axis=-1)
