"""The paper's definition: the cheapest wrench that does the same and claims nothing implausible.

minimise  J(h_M) = Σ_i (1−w)‖f_M,i‖ + s·w‖t_fM,i‖ + w‖t_M,i‖    (eq. 17)
subject to  G h_M = G h  and every part of h_M in the ball over the same part of h  (eqs. 18-21)
"""

from collections.abc import Callable

from coopenv.arrays import FloatArray
from coopenv.wrench.answer import Prepared, Solve
from coopenv.wrench.conic import solver as conic
from coopenv.wrench.pair import on_axis as pair
from coopenv.wrench.settings import Settings
from coopenv.wrench.structured import solver as structured

SOLVERS: dict[str, Callable[[FloatArray, Settings], Solve]] = {
    "pair": pair.prepare,
    "structured": structured.prepare,
    "conic": conic.prepare,
}


def prepare(grips: FloatArray, settings: Settings) -> Prepared:
    """Choose the fastest exact solver for these grips, or take the one that was asked for."""
    name = settings.solver
    if name == "auto":
        name = "pair" if pair.applies(grips).all() else "structured"
    return Prepared(name, SOLVERS[name](grips, settings))
