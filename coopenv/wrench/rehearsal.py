"""Calls that make a decomposer compile all that it will need."""

from typing import Any

import numpy as np

from coopenv.arrays import FloatArray
from coopenv.wrench.settings import Settings

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
    if decomposer.solver == "structured":
        one = grips.reshape(-1, *grips.shape[-2:])[:1]
        _rehearse_rest(fighting.reshape(-1, *fighting.shape[-2:])[:1], one, decomposer.settings)


def _rehearse_rest(applied: FloatArray, grips: FloatArray, settings: Settings) -> None:
    """What the structured solver asks where its first kernel has no answer, or a doubtful one."""
    from coopenv.wrench.conic import solver as conic
    from coopenv.wrench.structured import solver as structured

    structured.iterate(applied, grips, settings, kernel=structured.solve_batch)
    conic.prepare(grips[0], settings)(applied[0])
