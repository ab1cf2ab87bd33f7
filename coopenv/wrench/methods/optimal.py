"""Optimal method: the cheapest plausible wrench of the same resultant, and its registry of solvers.

minimise  J(h_M) = Σ_i (1−w)‖f_M,i‖ + s·w‖t_fM,i‖ + w‖t_M,i‖    (eq. 17)
subject to  G h_M = G h  and every part of h_M in the ball over the same part of h  (eqs. 18-21)
"""

from coopenv.arrays import FloatArray
from coopenv.wrench.answer import Prepare, Prepared, Solve
from coopenv.wrench.conic import solver as conic
from coopenv.wrench.pair import solver as pair
from coopenv.wrench.settings import Settings
from coopenv.wrench.structured import solver as structured


def _structured_or_conic(grips: FloatArray, settings: Settings) -> Solve:
    """Prepare `structured`, which asks `conic` where it cannot certify its own answer."""
    return structured.prepare(grips, settings, conic.prepare)


SOLVERS: dict[str, Prepare] = {
    "pair": pair.prepare,
    "structured": _structured_or_conic,
    "conic": conic.prepare,
}


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Choose the fastest exact solver for these grips, or take the one that was asked for."""
    name = settings.solver
    if name == "auto":
        name = "pair" if pair.applies(grips) else "structured"
    return Prepared(name, SOLVERS[name](grips, settings))
