"""Calls that make a decomposer compile all that it will need."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray

WITHOUT_TORQUE = ("max_internal", "one_dimensional", "net_force")  # methods that split forces only
COMPUTED = (
    "gap",
    "fell_back",
    "internal",
    "object_wrench",
    "cost",
    "relative_cost",
    "load_share",
    "share_or_even",
)


def rehearse(decomposer: Any) -> None:
    """Decompose wrenches of all kinds with a `coopenv.wrench.Decomposer`, and ask for everything.

    Those of a team that fights, that agrees, and that is idle; one alone and a batch.
    """
    grips: FloatArray = decomposer.grips
    size = 3 if grips.shape[-1] == 2 else 6
    fighting = np.random.default_rng(0).normal(size=(*grips.shape[:-1], size))
    agreeing = np.zeros_like(fighting)
    agreeing[..., 0] = 1.0
    method, forces = decomposer.settings.method, slice(grips.shape[-1])
    if method in WITHOUT_TORQUE:
        fighting[..., grips.shape[-1] :] = 0.0
    if method == "one_dimensional":
        line = grips[..., 1:, :] - grips[..., :1, :]
        fighting[..., forces], agreeing[..., forces] = line * [[1.0], [-1.0]], line
    for applied in (fighting, agreeing, np.zeros_like(fighting), np.stack([fighting, agreeing])):
        decomposition = decomposer(applied)
        for name in COMPUTED:
            getattr(decomposition, name)
        decomposition.energy_share(np.ones(size))
        decomposition.residuals()
    if decomposer.solver == "structured":  # asks it where its own answer is not good enough
        from coopenv.wrench.conic import solver as conic

        one = grips.reshape(-1, *grips.shape[-2:])[0]
        conic.prepare(one, decomposer.settings)(fighting.reshape(-1, *fighting.shape[-2:])[0])
